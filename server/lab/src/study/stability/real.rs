//! Real meshes, as users have them; not part of the project.

use super::case::compare;
use super::portrait::portrait;
use super::trial::{at, baked, fine, sound, struck};
use super::{CaseRow, Expect};
use crate::report::ReportFigure;
use shatter_fracture::database::BakeRequest;
use shatter_fracture::pipeline::DisplacementMethod;
use shatter_fracture::surface::{self, LengthUnit, UpAxis};
use shatter_proto::text::counted;
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

/// Bakes and strikes a file at default spacings; the picture shows its fragments, if `is_drawn`.
pub fn real(folder: &Path, file: &str, is_drawn: bool) -> (CaseRow, Option<ReportFigure>) {
    let why = "sum of the fragments' volumes against the lattice, baked at default spacings";
    let mut picture = None;
    let row = compare(file, "real meshes", Expect::AtMost(1e-9), why, || {
        // A basis, which takes most of a bake, would change no volume.
        let request = BakeRequest { elastic: DisplacementMethod::Solve, ..fine()? };
        let prepared = baked(surface::read(&folder.join(file), LengthUnit::M, UpAxis::Y)?, &request)?;
        let result = struck(&prepared, &at(&prepared, [1.0, 0.4, 0.3]))?;
        let figure = sound(&prepared, &result)?;
        if is_drawn {
            picture = Some(portrait(
                &prepared,
                &result,
                format!("{file}, {}", counted(result.rows.len() as u64, "fragment")),
            )?);
        }
        Ok(figure)
    });
    (row, picture)
}
