//! Pictures of the results of hard cases.

use super::TrialFault;
use super::trial::{TrialResult, at, baked, coarse, sound, struck};
use crate::picture::{Backdrop, Camera, PictureError, PictureSize, Projection, RenderStyle, Spread, draw};
use crate::report::ReportFigure;
use crate::study::exploded::exploded;
use crate::study::mesh_fuzz::{FuzzDefect, MeshSize, generated};
use nalgebra::Vector3;
use shatter_fracture::pipeline::PreparedObject;
use shatter_proto::text::counted;

const SIZE: PictureSize = PictureSize { width: 520, height: 420 };

/// Direction from the object to the camera.
const FROM: [f32; 3] = [0.6, 0.5, 1.0];

const LENS: Projection = Projection::Perspective { fov_deg: 24.0 };

/// Displacement of fragments over their distance from the center.
const SPREAD: f64 = 0.35;

impl From<PictureError> for TrialFault {
    fn from(error: PictureError) -> Self {
        Self::ours("picture", error.to_string())
    }
}

/// Picture of the fragments of `result`, moved apart.
pub fn portrait(prepared: &PreparedObject, result: &TrialResult, caption: String) -> Result<ReportFigure, TrialFault> {
    let spread = Spread { hub_m: prepared.frame.center_m.coords.into(), factor: SPREAD };
    let mesh = exploded(&result.rows, &result.runs, &result.positions, &result.indices, spread);
    let camera = Camera::fit(&mesh.positions, Vector3::from(FROM), LENS, SIZE.width as f32 / SIZE.height as f32);
    let ground = mesh.bounds().0.y;
    let png = draw(&mesh, &camera, SIZE, RenderStyle::STUDIO, Some(ground), Backdrop::Clear).png()?;
    Ok(ReportFigure { png, caption, scale: None })
}

/// Pictures of the statue under every defect that must be accepted, each with the same impact.
pub fn damaged_statues() -> Result<Vec<ReportFigure>, TrialFault> {
    let bases = generated(MeshSize::Small);
    let statue = bases.iter().find(|base| base.name == "statue");
    let statue = statue.ok_or_else(|| TrialFault::ours("picture", "there is no mesh `statue`"))?;
    let defects = FuzzDefect::ALL.iter().filter(|defect| defect.must_accept());
    defects
        .map(|defect| {
            let prepared = baked(defect.apply(&statue.mesh, 1), &coarse()?)?;
            let result = struck(&prepared, &at(&prepared, [1.0, 0.4, 0.3]))?;
            sound(&prepared, &result)?;
            let found = prepared.report.defects.len();
            let named = if found == 1 { "one line of defects" } else { "lines of defects" };
            let fragments = counted(result.rows.len() as u64, "fragment");
            let caption = match found {
                0 => format!("{defect}: harmless, nothing to repair; {fragments}"),
                1 => format!("{defect}: {named}, {fragments}"),
                _ => format!("{defect}: {found} {named}, {fragments}"),
            };
            portrait(&prepared, &result, caption)
        })
        .collect()
}
