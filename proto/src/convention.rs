//! Coordinates of a host: the axis that points up, handedness, winding and unit of length.
//!
//! The default is that of glTF: right-handed, +Y up, counter-clockwise seen from outside, meters. Another convention is a signed
//! permutation of the axes and a unit of length. The object is never mirrored: left-handed coordinates are other numbers for the
//! same points. Winding is therefore an independent choice, and outward normals stay outward.
//!
//! | up, hand | the default's (x, y, z) becomes | used by |
//! |---|---|---|
//! | +Y, right | (x, y, z) | glTF, Bevy, Rapier, Godot |
//! | +Y, left | (−x, y, z) | Unity, by its importers: +Z stays forward |
//! | +Z, right | (x, −z, y) | Blender, MuJoCo; mesh files baked with `--up z` |
//! | +Z, left | (x, z, y) | Unreal, by its importers |
//!
//! Mass is in kilograms and time in seconds in every convention. Quantities derived from lengths use the host's unit: velocities in
//! units/s, impulses in kg·unit/s (N·s for a meter), areas in unit², volumes in unit³, moments of inertia in kg·unit².
//!
//! Three quantities always keep the default: γ and energies (J·m²), texture coordinates of cracks (m), and the control service's
//! facts about objects.

use crate::name::suggestion;
use crate::request::RequestWire;
use crate::text::quoted;
use crate::{Error, ErrorKind};
use std::ops::Neg;

/// Shortest and longest unit of length, m.
pub const METERS_PER_UNIT: [f64; 2] = [1e-6, 1e6];

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// +Y.
    #[default]
    Y,
    /// +Z.
    Z,
}

/// Handedness of the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hand {
    /// Right-handed.
    #[default]
    Right,
    /// Left-handed. Angular velocities then follow the left-hand rule, so that v = ω × r holds in numbers.
    Left,
}

/// Order of the corners of a triangle, seen from outside the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Winding {
    /// The sum of det(a, b, c) over all triangles is positive in right-handed coordinates, negative in left-handed ones.
    #[default]
    CounterClockwise,
    /// The opposite order.
    Clockwise,
}

/// Coordinates of a host: requests are read and their results written in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convention {
    /// Which axis points up.
    pub up: Up,
    /// Handedness.
    pub hand: Hand,
    /// Winding of triangles.
    pub winding: Winding,
    /// Length of the host's unit, m, within [`METERS_PER_UNIT`].
    pub meters_per_unit: f64,
}

impl Default for Convention {
    fn default() -> Self {
        Self::GLTF
    }
}

impl Convention {
    /// glTF, Bevy, Rapier: the default.
    pub const GLTF: Self =
        Self { up: Up::Y, hand: Hand::Right, winding: Winding::CounterClockwise, meters_per_unit: 1.0 };

    /// Godot 4: front faces are clockwise.
    pub const GODOT: Self = Self { winding: Winding::Clockwise, ..Self::GLTF };

    /// Unity.
    pub const UNITY: Self = Self { hand: Hand::Left, winding: Winding::Clockwise, ..Self::GLTF };

    /// Unreal Engine: centimeters, and front faces are counter-clockwise although its axes are left-handed, so that its own normals
    /// are (c − a) × (b − a).
    pub const UNREAL: Self = Self { up: Up::Z, hand: Hand::Left, meters_per_unit: 0.01, ..Self::GLTF };

    /// Blender.
    pub const BLENDER: Self = Self { up: Up::Z, ..Self::GLTF };

    /// MuJoCo.
    pub const MUJOCO: Self = Self::BLENDER;

    /// Conventions with a name, as command lines write it.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("gltf", Self::GLTF),
        ("godot", Self::GODOT),
        ("unity", Self::UNITY),
        ("unreal", Self::UNREAL),
        ("blender", Self::BLENDER),
        ("mujoco", Self::MUJOCO),
    ];

    /// The convention of that name.
    ///
    /// # Errors
    /// [`ErrorKind::Convention`] if there is none.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let found = Self::NAMED.into_iter().find(|(own, _)| *own == name);
        found.map(|(_, convention)| convention).ok_or_else(|| {
            let names = Self::NAMED.map(|(own, _)| own);
            let message = format!("there is no convention `{}`; {}", quoted(name), suggestion(name, &names));
            Error::new(ErrorKind::Convention, "convention", message)
        })
    }

    /// The convention of these numbers, as they travel: [`Up`], [`Hand`] and [`Winding`] by position, a unit of zero is a meter.
    ///
    /// # Errors
    /// [`ErrorKind::Convention`] at the key of an invalid number.
    pub fn of_numbers(up: u32, hand: u32, winding: u32, meters_per_unit: f64) -> Result<Self, Error> {
        let none = |key: &str, number: u32| {
            let message = format!("convention.{key} is {number}: must be 0 or 1");
            Error::new(ErrorKind::Convention, format!("convention.{key}"), message)
        };
        Ok(Self {
            up: match up {
                0 => Up::Y,
                1 => Up::Z,
                other => return Err(none("up", other)),
            },
            hand: match hand {
                0 => Hand::Right,
                1 => Hand::Left,
                other => return Err(none("hand", other)),
            },
            winding: match winding {
                0 => Winding::CounterClockwise,
                1 => Winding::Clockwise,
                other => return Err(none("winding", other)),
            },
            meters_per_unit: match meters_per_unit {
                0.0 => 1.0,
                meters => unit(meters)?,
            },
        })
    }

    /// Whether it is [`Self::GLTF`].
    pub fn is_default(&self) -> bool {
        *self == Self::GLTF
    }

    /// Whether its triangles have the opposite order to ours.
    pub fn is_clockwise(&self) -> bool {
        self.winding == Winding::Clockwise
    }

    /// A direction of ours, a normal for instance, along the host's axes.
    #[inline]
    pub fn direction<T: Neg<Output = T>>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        match (self.up, self.hand) {
            (Up::Y, Hand::Right) => [x, y, z],
            (Up::Y, Hand::Left) => [-x, y, z],
            (Up::Z, Hand::Right) => [x, -z, y],
            (Up::Z, Hand::Left) => [x, z, y],
        }
    }

    /// A direction of the host's along our axes: the inverse of [`Self::direction`].
    #[inline]
    pub fn our_direction<T: Neg<Output = T>>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        match (self.up, self.hand) {
            (Up::Y, Hand::Right) => [x, y, z],
            (Up::Y, Hand::Left) => [-x, y, z],
            (Up::Z, Hand::Right) => [x, z, -y],
            (Up::Z, Hand::Left) => [x, z, y],
        }
    }

    /// A length, m, in the host's unit.
    #[inline]
    pub fn length(&self, meters: f64) -> f64 {
        meters / self.meters_per_unit
    }

    /// A length in the host's unit, m.
    #[inline]
    pub fn meters(&self, units: f64) -> f64 {
        units * self.meters_per_unit
    }

    /// A point, an offset or a velocity, in meters along our axes, in the host's unit along its axes.
    #[inline]
    pub fn vector(&self, meters: [f64; 3]) -> [f64; 3] {
        let turned = self.direction(meters);
        if self.meters_per_unit == 1.0 { turned } else { turned.map(|x| self.length(x)) }
    }

    /// The inverse of [`Self::vector`]; of impulses in kg·unit/s it makes N·s.
    #[inline]
    pub fn our_vector(&self, units: [f64; 3]) -> [f64; 3] {
        let turned = self.our_direction(units);
        if self.meters_per_unit == 1.0 { turned } else { turned.map(|x| self.meters(x)) }
    }

    /// [`Self::vector`] in single precision, rounded once.
    #[inline]
    pub fn vector_f32(&self, meters: [f32; 3]) -> [f32; 3] {
        let turned = self.direction(meters);
        if self.meters_per_unit == 1.0 { turned } else { turned.map(|x| self.length(f64::from(x)) as f32) }
    }

    /// [`Self::our_vector`] in single precision, rounded once.
    #[inline]
    pub fn our_vector_f32(&self, units: [f32; 3]) -> [f32; 3] {
        let turned = self.our_direction(units);
        if self.meters_per_unit == 1.0 { turned } else { turned.map(|x| self.meters(f64::from(x)) as f32) }
    }

    /// An angular velocity, rad/s: an axial vector, which a reflection of the axes turns round besides.
    pub fn axial(&self, ours: [f64; 3]) -> [f64; 3] {
        self.reflected(self.direction(ours))
    }

    /// The inverse of [`Self::axial`].
    pub fn our_axial(&self, own: [f64; 3]) -> [f64; 3] {
        self.our_direction(self.reflected(own))
    }

    fn reflected(&self, axial: [f64; 3]) -> [f64; 3] {
        match self.hand {
            Hand::Right => axial,
            Hand::Left => axial.map(Neg::neg),
        }
    }

    /// A moment of inertia, kg·m², in kg·unit²; like [`Self::length`] twice, of areas too.
    pub fn square(&self, meters2: f64) -> f64 {
        self.length(self.length(meters2))
    }

    /// The inverse of [`Self::square`].
    pub fn meters2(&self, units2: f64) -> f64 {
        self.meters(self.meters(units2))
    }

    /// A volume, m³, in unit³.
    pub fn cube(&self, meters3: f64) -> f64 {
        self.length(self.square(meters3))
    }

    /// The inverse of [`Self::cube`].
    pub fn meters3(&self, units3: f64) -> f64 {
        self.meters(self.meters2(units3))
    }

    /// An inertia tensor, kg·m², in kg·unit² along the host's axes: xx, yy, zz, xy, xz, yz, before and after.
    pub fn inertia(&self, ours: [f64; 6]) -> [f64; 6] {
        turned(ours, |vector| self.direction(vector)).map(|entry| self.square(entry))
    }

    /// The inverse of [`Self::inertia`].
    pub fn our_inertia(&self, own: [f64; 6]) -> [f64; 6] {
        turned(own, |vector| self.our_direction(vector)).map(|entry| self.meters2(entry))
    }
}

/// A I Aᵀ, where `turn` applies A: first to the rows of I, then to those of the transpose.
fn turned([xx, yy, zz, xy, xz, yz]: [f64; 6], turn: impl Fn([f64; 3]) -> [f64; 3]) -> [f64; 6] {
    let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(&turn);
    let columns = [0, 1, 2].map(|k| turn(rows.map(|row| row[k])));
    let [[xx, ..], [xy, yy, _], [xz, yz, zz]] = columns;
    [xx, yy, zz, xy, xz, yz]
}

impl RequestWire {
    /// Writes the convention.
    ///
    /// # Errors
    /// `convention`, as the daemon would.
    pub(crate) fn set_convention(&mut self, convention: &Convention) -> Result<(), Error> {
        self.convention_up = convention.up as u32;
        self.convention_hand = convention.hand as u32;
        self.convention_winding = convention.winding as u32;
        self.convention_meters_per_unit = unit(convention.meters_per_unit)?;
        Ok(())
    }

    /// The convention of the request.
    ///
    /// # Errors
    /// `convention`.
    pub(crate) fn convention(&self) -> Result<Convention, Error> {
        let [up, hand, winding] = [self.convention_up, self.convention_hand, self.convention_winding];
        Convention::of_numbers(up, hand, winding, self.convention_meters_per_unit)
    }
}

/// Checks the length of a unit, m.
///
/// # Errors
/// `convention`.
fn unit(meters: f64) -> Result<f64, Error> {
    let [least, most] = METERS_PER_UNIT;
    if (least..=most).contains(&meters) {
        return Ok(meters);
    }
    let message = format!("a unit of {meters} m: must be {least:e} to {most:e}");
    Err(Error::new(ErrorKind::Convention, "convention.meters_per_unit", message))
}

#[cfg(test)]
mod tests;
