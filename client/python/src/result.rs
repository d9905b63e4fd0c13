//! Results.

use crate::argument;
use crate::array::rows;
use crate::error::{raised, wrong};
use crate::fragment::Fragment;
use numpy::PyArray2;
use pyo3::exceptions::{PyBufferError, PyIndexError};
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyTuple};
use shatter_client::ErrorKind;
use shatter_proto::text::quoted;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A fragment by the handle of a kept result, and its id.
pub type FragmentOfResult = (u64, u32);

/// A result that arrays may borrow from.
pub struct Held(Mutex<shatter_client::FractureResult>);

impl Held {
    /// Calls `look` with the result.
    ///
    /// `look` must not call Python, which can pass the interpreter's lock to a thread that waits for the result.
    pub fn with<T>(&self, look: impl FnOnce(&shatter_client::FractureResult) -> T) -> T {
        look(&self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The result of a request.
#[pyclass(frozen, module = "shatter")]
pub struct FractureResult(Mutex<Option<Arc<Held>>>);

impl FractureResult {
    pub fn new(result: shatter_client::FractureResult) -> Self {
        Self(Mutex::new(Some(Arc::new(Held(Mutex::new(result))))))
    }

    fn held(&self) -> PyResult<Arc<Held>> {
        let place = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        place.clone().ok_or_else(|| wrong("the result was released; copy what you need before"))
    }

    fn write(
        &self,
        py: Python<'_>,
        write: impl FnOnce(&shatter_client::FractureResult) -> Result<(), shatter_client::Error> + Send,
    ) -> PyResult<()> {
        let held = self.held()?;
        py.detach(|| held.with(write)).map_err(raised)
    }
}

#[pymethods]
impl FractureResult {
    #[getter]
    pub fn summary(&self) -> PyResult<Summary> {
        Ok(self.held()?.with(Summary::of))
    }

    #[getter]
    fn is_whole(&self) -> PyResult<bool> {
        Ok(self.held()?.with(shatter_client::FractureResult::is_whole))
    }

    /// First hit of the request's ray on the object; ``None`` if it had no ray.
    #[getter]
    pub fn hit(&self) -> PyResult<Option<Hit>> {
        Ok(self.held()?.with(|result| result.hit().map(Hit::from)))
    }

    /// Handle of this result for later requests (``origin``); ``None`` if the service does not keep it.
    #[getter]
    fn handle(&self) -> PyResult<Option<u64>> {
        Ok(self.held()?.with(shatter_client::FractureResult::handle))
    }

    /// Content hash: equal for identical results.
    #[getter]
    fn output_hash(&self, py: Python<'_>) -> PyResult<String> {
        let held = self.held()?;
        Ok(py.detach(|| held.with(|result| result.digest().output_hash.to_string())))
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.held()?.with(|result| result.fragments().len()))
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        let held = self.held()?;
        let count = held.with(|result| result.fragments().len()) as u32;
        let all = PyTuple::new(py, (0..count).map(|id| Fragment::new(held.clone(), id)).collect::<Vec<_>>())?;
        all.try_iter()
    }

    fn __getitem__(&self, index: isize) -> PyResult<Fragment> {
        let held = self.held()?;
        let count = held.with(|result| result.fragments().len());
        let id = if index < 0 { index.checked_add_unsigned(count) } else { Some(index) };
        let id = id.and_then(|id| usize::try_from(id).ok()).filter(|id| *id < count);
        let id = id.ok_or_else(|| PyIndexError::new_err(format!("no fragment {index}: the result has {count}")))?;
        Ok(Fragment::new(held, id as u32))
    }

    /// Contact areas between fragments; empty unless ``bonds`` is on.
    #[getter]
    fn bonds(&self) -> PyResult<Vec<Bond>> {
        let bond = |own: shatter_client::Bond| Bond {
            fragments: (own.fragment, own.neighbor),
            area_m2: own.area_m2,
            normal: own.normal,
            centroid_m: own.centroid_m,
        };
        Ok(self.held()?.with(|result| result.bonds().map(bond).collect()))
    }

    /// Points on cracks from which dust and chips come; empty unless ``debris`` is on.
    #[getter]
    fn debris(&self) -> PyResult<Vec<Debris>> {
        let debris = |own: shatter_client::DebrisPoint| Debris {
            fragment: own.fragment,
            neighbor: own.neighbor,
            position_m: own.position_m,
            normal: own.normal,
            size_m: own.size_m,
        };
        Ok(self.held()?.with(|result| result.debris().map(debris).collect()))
    }

    /// (all vertices, 3): the vertices of all fragments one after another, each relative to the center of its fragment.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, &self.held()?, |result| Some(result.positions()))
    }

    /// Writes a binary glTF file (.glb), whole or not at all; with the materials and textures of the mesh file ``materials`` (.glb,
    /// .gltf) that the object was baked from. They need the effect ``attributes``.
    #[pyo3(signature = (path, materials = None))]
    fn write_glb(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::output_file)] path: PathBuf,
        #[pyo3(from_py_with = argument::materials_file)] materials: Option<PathBuf>,
    ) -> PyResult<()> {
        if !has_ending(&path, &["glb"]) {
            return Err(wrong(format!(
                "path: write_glb writes .glb files, not `{}`; see also write_obj and write_mjcf",
                shown(&path)
            )));
        }
        self.write(py, |result| match &materials {
            Some(file) => result.write_glb_with(&path, &shatter_client::read_materials(file)?).map(|_| ()),
            None => result.write_glb(&path).map(|_| ()),
        })
    }

    /// Writes a folder of OBJ files with a table.
    fn write_obj(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = argument::output_folder)] folder: PathBuf,
    ) -> PyResult<()> {
        if !folder.is_dir() && has_ending(&folder, &["obj", "glb", "gltf", "xml", "zip"]) {
            return Err(wrong(format!(
                "folder: write_obj writes a folder of .obj files, and `{}` is the name of a file; pass the name of a folder",
                shown(&folder)
            )));
        }
        self.write(py, |result| result.write_obj(&folder).map(|_| ()))
    }

    /// Writes a MuJoCo model, with its meshes in a folder beside it; ``bonds`` and ``hulls`` make it hold together and collide.
    fn write_mjcf(&self, py: Python<'_>, #[pyo3(from_py_with = argument::output_file)] path: PathBuf) -> PyResult<()> {
        if !has_ending(&path, &["xml"]) {
            return Err(wrong(format!(
                "path: write_mjcf writes .xml files, not `{}`; see also write_glb and write_obj",
                shown(&path)
            )));
        }
        self.write(py, |result| result.write_mjcf(&path).map(|_| ()))
    }

    /// Releases the memory now; ``BufferError`` while fragments or arrays refer to it.
    fn release(&self) -> PyResult<()> {
        let mut place = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let others = place.as_ref().map_or(0, |held| Arc::strong_count(held) - 1);
        if others > 0 {
            return Err(PyBufferError::new_err(format!(
                "{} to the result; delete {} first",
                if others == 1 {
                    "a fragment or an array refers".to_owned()
                } else {
                    format!("{others} fragments or arrays refer")
                },
                if others == 1 { "it" } else { "them" }
            )));
        }
        *place = None;
        Ok(())
    }

    fn __enter__(this: Bound<'_, Self>) -> PyResult<Bound<'_, Self>> {
        this.get().held()?;
        Ok(this)
    }

    /// Releases the result; its memory is freed with the last array that refers to it.
    #[pyo3(signature = (*_error))]
    fn __exit__(&self, _error: &Bound<'_, PyTuple>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Summary of a result.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Summary {
    object: String,
    sites: u32,
    fracture_degree: u32,
    degree_source: &'static str,
    capped: bool,
    stop_reason: &'static str,
    elastic: &'static str,
    quality: &'static str,
    iterations: u32,
    gamma_j_m2: f64,
    e1_over_gamma: f64,
    pub threshold_impulse_factor: f64,
    strain_j: Option<f64>,
    criterion: &'static str,
    stress_over_strength: Option<f64>,
    surface_j: Option<f64>,
    released_j: Option<f64>,
    deficit_j: Option<f64>,
    impactor_j: Option<f64>,
    remainder_j: Option<f64>,
    load_factor: Option<f64>,
    confidence: f64,
    radius_m: f64,
    energy_error: f64,
    cvd_gap: f64,
    seed: u64,
    time_s: f64,
    overrun_s: f64,
    overrun_reason: Option<&'static str>,
    surface: &'static str,
    round_trip_s: f64,
    bytes: u64,
}

impl Summary {
    fn of(result: &shatter_client::FractureResult) -> Self {
        let facts = result.summary();
        Self {
            object: facts.object,
            sites: facts.sites,
            fracture_degree: facts.fracture_degree,
            degree_source: facts.degree_origin.name(),
            capped: facts.is_capped,
            stop_reason: facts.stop_criterion.name(),
            elastic: facts.energy_source.name(),
            quality: facts.quality.map_or("unknown", shatter_client::Quality::name),
            iterations: facts.iterations,
            gamma_j_m2: facts.gamma_j_m2,
            e1_over_gamma: facts.e1_over_gamma,
            threshold_impulse_factor: facts.threshold_impulse_factor,
            strain_j: facts.strain_j,
            criterion: facts.criterion.name(),
            stress_over_strength: facts.stress_over_strength,
            surface_j: facts.surface_j,
            released_j: facts.released_j,
            deficit_j: facts.deficit_j,
            impactor_j: facts.impactor_j,
            remainder_j: facts.remainder_j,
            load_factor: facts.load_factor,
            confidence: facts.confidence,
            radius_m: facts.radius_m,
            energy_error: facts.energy_error,
            cvd_gap: facts.cvd_gap,
            seed: facts.seed,
            time_s: facts.time.as_secs_f64(),
            overrun_s: facts.missed_time.map_or(0.0, |missed| missed.by.as_secs_f64()),
            overrun_reason: facts.missed_time.map(|missed| missed.cause.name()),
            surface: facts.surface.name(),
            round_trip_s: result.round_trip().as_secs_f64(),
            bytes: result.bytes(),
        }
    }
}

/// A contact between two fragments, or between a fragment and the world.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Bond {
    fragments: (u32, Option<u32>),
    area_m2: f64,
    normal: [f64; 3],
    centroid_m: [f64; 3],
}

/// A point on a crack from which dust and chips come.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Debris {
    fragment: u32,
    neighbor: u32,
    position_m: [f32; 3],
    normal: [f32; 3],
    size_m: f32,
}

/// Error for a fragment that does not exist.
pub fn unknown(id: u32) -> PyErr {
    raised(shatter_client::Error::new(
        ErrorKind::UnknownFragment,
        id.to_string(),
        format!("the result has no fragment {id}"),
    ))
}

/// First hit of a ray on an object.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Hit {
    point: [f64; 3],
    normal: [f64; 3],
    distance: f64,
    body: u32,
}

impl From<shatter_client::Hit> for Hit {
    fn from(hit: shatter_client::Hit) -> Self {
        let shatter_client::Hit { point_m, normal, distance_m, body, .. } = hit;
        Self { point: point_m, normal, distance: distance_m, body }
    }
}

/// Whether the name of a file ends with one of these, in any case.
fn has_ending(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|own| endings.iter().any(|ending| own.eq_ignore_ascii_case(ending)))
}

fn shown(path: &Path) -> String {
    quoted(&path.display().to_string())
}
