//! Settings of accuracy and time, as they travel.

use super::{Request, RequestWire, given};
use crate::name::suggestion;
use crate::text::quoted;
use crate::{Error, ErrorKind};

/// Largest relative error that a request may allow.
pub const ERROR_MAX: f64 = 1.0;

/// Longest time that a request may allow, ms: an hour.
pub const TIME_MS_MAX: f64 = 3.6e6;

/// Most iterations that a request may allow.
pub const ITERATIONS_MAX: u32 = 10_000;

/// Which lift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lift {
    /// X = x.
    Euclidean,
    /// The augmented interior lift.
    Interior,
    /// Diffusion on the surface, carried inside.
    SurfaceDiffusion,
}

/// Rule that decides whether an object breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestedCriterion {
    /// That of the paper: the first moment of the energy exceeds γ.
    Paper,
    /// The stress reaches the strength, and the energy is that of a crack.
    Strength,
}

impl RequestedCriterion {
    /// All of them; the wire counts them from 1.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Strength];

    /// The name used on command lines and in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Strength => "strength",
        }
    }
}

/// Outer surface that the fragments of a request get.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RequestedSurface {
    /// The input surface itself, if the object has a mesh of it; else that of the lattice.
    #[default]
    Exact,
    /// That of the lattice, which has fewer triangles.
    Lattice,
}

impl RequestedSurface {
    /// All of them; the wire counts them from 0.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Lattice];

    /// The name used on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Lattice => "lattice",
        }
    }
}

/// A preset: a bundle of numbers, which the result reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// To try things out.
    Draft,
    /// A result within a frame.
    #[default]
    Game,
    /// As fine as cracks are seen close up.
    Film,
    /// The reference for the accuracy of the others.
    Reference,
}

impl Quality {
    /// All of them, from fast to accurate; the wire counts them from 1.
    pub const ALL: [Self; 4] = [Self::Draft, Self::Game, Self::Film, Self::Reference];

    /// The name used on command lines, in scenes and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Game => "game",
            Self::Film => "film",
            Self::Reference => "reference",
        }
    }

    /// The preset of that name.
    ///
    /// # Errors
    /// [`ErrorKind::Budget`] if there is none.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let unknown = || {
            let known = suggestion(name, &Self::ALL.map(Self::name));
            let message = format!("there is no quality `{}`; {known}", quoted(name));
            Error::new(ErrorKind::Budget, "quality", message)
        };
        Self::ALL.into_iter().find(|quality| quality.name() == name).ok_or_else(unknown)
    }

    /// Its number on the wire.
    pub fn number(self) -> u32 {
        1 + self as u32
    }

    /// The preset of that number; `None` of 0 and of others.
    pub fn by_number(number: u32) -> Option<Self> {
        Self::ALL.get((number as usize).checked_sub(1)?).copied()
    }
}

impl RequestWire {
    /// Writes the settings of `request`.
    ///
    /// # Errors
    /// `budget`.
    pub(super) fn set_settings(&mut self, request: &Request) -> Result<(), Error> {
        self.lift = match request.lift {
            None => 0,
            Some(Lift::Euclidean) => 1,
            Some(Lift::Interior) => 2,
            Some(Lift::SurfaceDiffusion) => 3,
        };
        self.criterion = request.criterion.map_or(0, |own| 1 + own as u64);
        self.surface = request.surface as u64;
        self.quality = request.quality.map_or(0, Quality::number);
        self.error_max = given(request.error_max, error)?;
        self.time_ms_max = given(request.time_ms_max, time)?;
        self.iterations = match request.iterations_max {
            Some(count) if count > ITERATIONS_MAX => return Err(iterations(count)),
            count => count.map_or(0, |count| count + 1),
        };
        Ok(())
    }

    pub(super) fn lift(&self) -> Result<Option<Lift>, Error> {
        match self.lift {
            0 => Ok(None),
            1 => Ok(Some(Lift::Euclidean)),
            2 => Ok(Some(Lift::Interior)),
            3 => Ok(Some(Lift::SurfaceDiffusion)),
            other => Err(Error::new(ErrorKind::Lift, other.to_string(), "lift must be 0 to 3")),
        }
    }

    pub(super) fn criterion(&self) -> Result<Option<RequestedCriterion>, Error> {
        let unknown = || {
            let message = format!("criterion {}: must be 0 to {}", self.criterion, RequestedCriterion::ALL.len());
            Error::new(ErrorKind::Budget, "criterion", message)
        };
        let named = |own: &RequestedCriterion| 1 + *own as u64 == self.criterion;
        let found = || RequestedCriterion::ALL.into_iter().find(named).ok_or_else(unknown);
        (self.criterion > 0).then(found).transpose()
    }

    pub(super) fn surface(&self) -> Result<RequestedSurface, Error> {
        let unknown = || Error::new(ErrorKind::Budget, "surface", format!("surface {}: must be 0 or 1", self.surface));
        RequestedSurface::ALL.into_iter().find(|own| *own as u64 == self.surface).ok_or_else(unknown)
    }

    pub(super) fn quality(&self) -> Result<Option<Quality>, Error> {
        let unknown = || Error::new(ErrorKind::Budget, "quality", format!("quality {}: must be 0 to 4", self.quality));
        let named = || Quality::by_number(self.quality).ok_or_else(unknown);
        (self.quality > 0).then(named).transpose()
    }

    pub(super) fn error_max(&self) -> Result<Option<f64>, Error> {
        within(self.error_max, ERROR_MAX, error)
    }

    pub(super) fn time_ms_max(&self) -> Result<Option<f64>, Error> {
        within(self.time_ms_max, TIME_MS_MAX, time)
    }

    pub(super) fn iterations_max(&self) -> Result<Option<u32>, Error> {
        match self.iterations.checked_sub(1) {
            Some(count) if count > ITERATIONS_MAX => Err(iterations(count)),
            count => Ok(count),
        }
    }
}

/// Zero: not given. Otherwise above it, and at most `most`.
fn within(value: f64, most: f64, refuse: impl Fn(f64) -> Error) -> Result<Option<f64>, Error> {
    match value {
        0.0 => Ok(None),
        value if value > 0.0 && value <= most => Ok(Some(value)),
        value => Err(refuse(value)),
    }
}

fn iterations(count: u32) -> Error {
    Error::new(
        ErrorKind::Budget,
        "iterations_max",
        format!("the request has {count} iterations; they must be at most {ITERATIONS_MAX}"),
    )
}

fn error(value: f64) -> Error {
    let message =
        format!("the largest error of the request is {value:?}; it must be above zero and at most {ERROR_MAX}");
    Error::new(ErrorKind::Budget, "error_max", message)
}

fn time(value: f64) -> Error {
    let message = format!("the time of the request is {value:?} ms; it must be above zero and at most {TIME_MS_MAX}");
    Error::new(ErrorKind::Budget, "time_ms_max", message)
}
