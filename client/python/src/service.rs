//! Connections and objects.

use crate::argument;
use crate::error::raised;
use crate::impact::{self, Wish};
use crate::result::{FragmentOfResult, Hit};
use crate::ticket::Ticket;
use pyo3::prelude::*;
use shatter_client::{Client, Convention, Deadline, Error, ErrorKind, Impact, ObjectFacts, Ray, SEED_DEFAULT};
use std::time::{Duration, Instant};

// Signatures show literals in `help()`, but not constants.
const _: () = assert!(SEED_DEFAULT == 0);

/// Interval between two checks for Ctrl-C.
const SLICE: Duration = Duration::from_millis(50);

/// Repeats `ask` in slices until it returns a result or an error that is not `pending`, or until `timeout`. Other threads of Python run
/// meanwhile, and signals are handled.
pub fn in_slices<T: Send>(
    py: Python<'_>,
    timeout: Duration,
    pending: fn(&shatter_client::Error) -> bool,
    ask: impl Fn(Deadline) -> Result<T, shatter_client::Error> + Sync,
) -> PyResult<T> {
    let begin = Instant::now();
    loop {
        let left = timeout.saturating_sub(begin.elapsed());
        match py.detach(|| ask(Deadline::after(left.min(SLICE)))) {
            Err(error) if pending(&error) && left > SLICE => py.check_signals()?,
            result => return result.map_err(raised),
        }
    }
}

/// A connection to a service.
#[pyclass(frozen, module = "shatter")]
pub struct Service(Client);

impl Service {
    pub fn connect(py: Python<'_>, name: &str, timeout: Duration, convention: Convention) -> PyResult<Self> {
        let service = py.detach(|| Client::connect(name, Deadline::after(timeout))).map_err(raised)?;
        Ok(Self(service.with_convention(convention)))
    }

    pub fn wait_for(py: Python<'_>, name: &str, timeout: Duration, convention: Convention) -> PyResult<Self> {
        let service =
            in_slices(py, timeout, |error| error.kind == ErrorKind::NoDaemon, |slice| Client::wait_for(name, slice))?;
        Ok(Self(service.with_convention(convention)))
    }
}

#[pymethods]
impl Service {
    /// Finds an object by name, ready to be struck.
    #[pyo3(signature = (name, *, timeout_s = 1.0))]
    fn object(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::object_name)] name: String,
        #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    ) -> PyResult<Object> {
        let deadline = Deadline::after(argument::duration(timeout_s));
        py.detach(|| self.0.object(&name, deadline)).map(Object).map_err(raised)
    }

    /// All objects, ready or not, by name.
    #[pyo3(signature = (*, timeout_s = 1.0))]
    fn objects(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    ) -> PyResult<Vec<Facts>> {
        let deadline = Deadline::after(argument::duration(timeout_s));
        let all = py.detach(|| self.0.objects(deadline)).map_err(raised)?;
        Ok(all.iter().map(Facts::from).collect())
    }

    #[pyo3(signature = (*, timeout_s = 1.0))]
    fn status(&self, py: Python<'_>, #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64) -> PyResult<Status> {
        let deadline = Deadline::after(argument::duration(timeout_s));
        let status = py.detach(|| self.0.status(deadline)).map_err(raised)?;
        Ok(Status {
            pid: status.pid,
            threads: status.threads,
            clients: status.clients,
            queued: status.queued,
            running: status.running,
            completed: status.completed,
            refused: status.refused,
            uptime_s: status.uptime.as_secs_f64(),
        })
    }

    /// Releases a kept result: its fragments cannot be struck any more.
    #[pyo3(signature = (handle, *, timeout_s = 1.0))]
    fn release(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::handle)] handle: u64,
        #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    ) -> PyResult<()> {
        let deadline = Deadline::after(argument::duration(timeout_s));
        py.detach(|| self.0.release(handle, deadline)).map_err(raised)
    }
}

/// State of a service.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Status {
    pid: u32,
    threads: u32,
    clients: u32,
    queued: u32,
    running: u32,
    completed: u64,
    refused: u64,
    uptime_s: f64,
}

/// Facts of an object.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Facts {
    name: String,
    ready: bool,
    state: &'static str,
    error: Option<String>,
    material: String,
    bodies: u32,
    degree_max: u32,
    elastic_nodes: u32,
    crack_nodes: u32,
    gamma_j_m2: f64,
    young_pa: f64,
    poisson: f64,
    density_kg_m3: f64,
    volume_m3: f64,
    diagonal_m: f64,
    center_m: [f64; 3],
    bounds_m: [[f64; 3]; 2],
    radius_m: f64,
    duration_s: f64,
}

impl From<&ObjectFacts> for Facts {
    fn from(facts: &ObjectFacts) -> Self {
        Self {
            name: facts.name.clone(),
            ready: facts.is_ready(),
            state: facts.state.name(),
            error: facts.error.as_ref().map(|error| error.message.clone()),
            material: facts.material.clone(),
            bodies: facts.bodies,
            degree_max: facts.degree_max,
            elastic_nodes: facts.elastic_nodes,
            crack_nodes: facts.crack_nodes,
            gamma_j_m2: facts.gamma_j_m2,
            young_pa: facts.young_pa,
            poisson: facts.poisson,
            density_kg_m3: facts.density_kg_m3,
            volume_m3: facts.volume_m3,
            diagonal_m: facts.diagonal_m,
            center_m: facts.center_m,
            bounds_m: facts.bounds_m,
            radius_m: facts.radius_m,
            duration_s: facts.duration_s,
        }
    }
}

/// An object that can be struck.
#[pyclass(frozen, module = "shatter")]
pub struct Object(shatter_client::Object);

#[pymethods]
impl Object {
    #[getter]
    fn facts(&self) -> Facts {
        self.0.facts().into()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.facts().name
    }

    /// Sends a request of one to eight contacts; never blocks. Keywords are the options of ``shatter impact``.
    ///
    /// ``degree``: a number of sites, which breaks the object whatever γ is, or the rule that sets the number. ``enable`` and ``disable``:
    /// names of effects, such as ``["normals", "hulls"]``, or one name. ``origin``: handle of a kept result and id of its fragment, which is
    /// struck instead of the object.
    #[pyo3(signature = (*contacts, degree = None, quality = None, error = None, time_ms = None, iterations = None,
        enable = None, disable = None, gamma_j_m2 = None, lift = None, elastic = None, surface = None, criterion = None, seed = 0,
        keep = false,
        origin = None, deadline_s = None, fragments_max = None, bytes_max = None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of a call in Python")]
    fn strike(
        &self,
        contacts: Vec<Bound<'_, PyAny>>,
        degree: Option<Bound<'_, PyAny>>,
        quality: Option<&str>,
        #[pyo3(from_py_with = argument::error)] error: Option<f64>,
        #[pyo3(from_py_with = argument::time_ms)] time_ms: Option<f64>,
        #[pyo3(from_py_with = argument::iterations)] iterations: Option<u32>,
        enable: Option<Bound<'_, PyAny>>,
        disable: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::gamma_j_m2)] gamma_j_m2: Option<f64>,
        lift: Option<&str>,
        elastic: Option<&str>,
        surface: Option<&str>,
        criterion: Option<&str>,
        #[pyo3(from_py_with = argument::seed)] seed: u64,
        keep: bool,
        #[pyo3(from_py_with = argument::struck_fragment)] origin: Option<FragmentOfResult>,
        #[pyo3(from_py_with = argument::deadline_s)] deadline_s: Option<Duration>,
        #[pyo3(from_py_with = argument::fragments_max)] fragments_max: Option<u32>,
        #[pyo3(from_py_with = argument::bytes_max)] bytes_max: Option<u64>,
    ) -> PyResult<Ticket> {
        let sites_max = self.0.facts().degree_max;
        let wish = Wish {
            degree: degree.map(|degree| impact::Degree::of(&degree, sites_max)).transpose()?,
            quality,
            error,
            time_ms,
            iterations,
            enable: impact::names("enable", enable.as_ref())?,
            disable: impact::names("disable", disable.as_ref())?,
            gamma_j_m2,
            lift,
            elastic,
            surface,
            criterion,
            seed,
            keep,
            origin,
            deadline: deadline_s,
            fragments_max,
            bytes_max,
        };
        let impact = wish.describe(impact::at(&contacts)?)?;
        self.0.strike(&impact).map(Ticket::new).map_err(raised)
    }

    /// Finds the first hit of the ray from ``origin`` along ``direction`` on the object, or on ``fragment``: the handle of a kept result
    /// and the id of its fragment. Waits for the service.
    #[pyo3(signature = (origin, direction, *, fragment = None, timeout_s = 5.0))]
    fn aim(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::ray_origin)] origin: [f64; 3],
        #[pyo3(from_py_with = argument::direction)] direction: [f64; 3],
        #[pyo3(from_py_with = argument::aimed_fragment)] fragment: Option<FragmentOfResult>,
        #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    ) -> PyResult<Hit> {
        let aim = Impact::aim(Ray { origin_m: origin, direction });
        let aim = fragment.map_or(aim.clone(), |(handle, fragment)| aim.from(handle, fragment));
        let ticket = self.0.strike(&aim).map(Ticket::new).map_err(raised)?;
        let hit = ticket.wait(py, timeout_s)?.hit()?;
        hit.ok_or_else(|| raised(Error::new(ErrorKind::BadResult, "hit", "the service sent no hit for a ray")))
    }

    /// Divides the whole object evenly without an impact; asks the service where the bodies are first, if there are several.
    #[pyo3(signature = (pieces, *, seed = 0, timeout_s = 60.0))]
    fn even(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::pieces)] pieces: u32,
        #[pyo3(from_py_with = argument::seed)] seed: u64,
        #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    ) -> PyResult<Ticket> {
        let deadline = Deadline::after(argument::duration(timeout_s));
        let impact = py.detach(|| self.0.even(pieces, deadline)).map_err(raised)?;
        self.0.strike(&impact.seed(seed)).map(Ticket::new).map_err(raised)
    }

    /// Factor on these impulses at which the object just breaks; waits for the service.
    #[pyo3(signature = (*contacts, timeout_s = 60.0))]
    fn threshold_factor(
        &self,
        py: Python<'_>,
        contacts: Vec<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::timeout_s)] timeout_s: f64,
    ) -> PyResult<f64> {
        let impact = impact::at(&contacts)?.threshold_only();
        let ticket = self.0.strike(&impact).map(Ticket::new).map_err(raised)?;
        Ok(ticket.wait(py, timeout_s)?.summary()?.threshold_impulse_factor)
    }
}
