//! Real meshes, which the project does not contain: what users bring.

use super::case::compare;
use super::trial::{at, baked, fine, sound, struck};
use super::{Expect, Fault, Row};
use shatter_fracture::surface::{self, Unit, Up};
use std::path::Path;

/// Files of the usual test collection that must bake and break.
pub const REAL: &[&str] = &[
    "horse.ply",
    "stanford-bunny.obj",
    "teapot.obj",
    "suzanne.obj",
    "spot.obj",
    "cow.obj",
    "cheburashka.obj",
    "fandisk.obj",
    "beetle.obj",
];

/// Bakes and strikes a file at default spacings.
pub fn real(folder: &Path, file: &str) -> Row {
    let why = "sum of the fragments' volumes against the lattice, baked at default spacings";
    compare(file, "real meshes", Expect::AtMost(1e-9), why, || whole_walk(&folder.join(file)))
}

fn whole_walk(path: &Path) -> Result<f64, Fault> {
    let prepared = baked(surface::read(path, Unit::M, Up::Y)?, &fine()?)?;
    sound(&prepared, &struck(&prepared, &at(&prepared, [1.0, 0.4, 0.3]))?)
}
