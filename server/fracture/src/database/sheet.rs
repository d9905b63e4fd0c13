//! Sheets that are too thin for regular lattices: their cells are stretched along the sheet.
//!
//! A lattice is limited by its number of nodes, and a regular one needs cells as short as the sheet is thick in all
//! directions. Everything that makes a lattice is done on a copy of the surface that is thicker by a factor. Its nodes are
//! then moved back. Affine maps keep what is inside, and what is connected. Ours.

use super::bake_error::BakeError;
use super::bake_request::BakeRequest;
use super::hash::input_hash;
use super::wall_limits::{SHEET_NODES, STRETCH_MAX, STRETCHES};
use crate::lattice::{LatticeLevels, LatticeStretch};
use crate::pipeline::{BakeParameters, BakeReport};
use crate::surface::Surface;

/// Largest ratio of the least side of a sheet's box to the thickness of its walls: curved sheets have thicker boxes.
const BOX_MAX: f64 = 2.0;

/// Parameters, lattices and report of a bake.
type Stuffed = (BakeParameters, LatticeLevels, BakeReport);

/// Lattices of a surface that regular lattices lose for the reason `error`, on stretched cells; `stuff` makes regular ones.
///
/// # Errors
/// `error` if the surface is no sheet, or the request names spacings or existing cracks. If the sheet is too thin even so,
/// the error names the thickness of what is not.
pub(super) fn stretched(
    request: &BakeRequest,
    surface: &Surface,
    error: BakeError,
    mut stuff: impl FnMut(&Surface) -> Result<Stuffed, BakeError>,
) -> Result<Stuffed, BakeError> {
    let BakeError::TooThin { thickness_m, spacing, spacing_needed, thickness_needed_m: Some(needed_m) } = error else {
        return Err(error);
    };
    let is_free = request.cracks.is_none() && request.elastic_spacing.is_none() && request.crack_spacing.is_none();
    let Some(axis) = is_free.then(|| surface.axis_of_sheet(STRETCH_MAX, BOX_MAX * thickness_m)).flatten() else {
        return Err(error);
    };
    let thinner = |needed_m: f64| BakeError::TooThin {
        thickness_m,
        spacing,
        spacing_needed,
        thickness_needed_m: Some(needed_m / STRETCH_MAX),
    };
    if thickness_m * STRETCH_MAX < needed_m {
        return Err(thinner(needed_m));
    }
    let mut made = |factor: f64| {
        let stretch = LatticeStretch { axis: axis.into(), factor };
        let mut thick = surface.clone();
        thick.positions.iter_mut().for_each(|place| stretch.apply(place));
        stuff(&thick).map(|made| moved_back(surface, stretch, made))
    };
    let longest = match made(STRETCH_MAX) {
        Err(BakeError::TooThin { .. }) => return Err(error),
        longest => longest?,
    };
    // A sheet has as many nodes as its area has squares of the length of a cell.
    let nodes = longest.1.bodies.iter().map(|body| body.elastic.nodes.len()).sum::<usize>();
    let least = STRETCH_MAX * (nodes as f64 / SHEET_NODES as f64).sqrt();
    match STRETCHES.into_iter().find(|factor| *factor >= least) {
        Some(factor) if factor < STRETCH_MAX => made(factor),
        _ => Ok(longest),
    }
}

/// Lattices of the thicker sheet, and what is reported of them, at the places and lengths of the sheet itself.
fn moved_back(surface: &Surface, stretch: LatticeStretch, (parameters, mut levels, mut report): Stuffed) -> Stuffed {
    stretch.revert_levels(&mut levels);
    report.input_hash = input_hash(surface, None);
    report.input_volume_m3 /= stretch.factor;
    report.lattice_volume_m3 /= stretch.factor;
    report.stretch = Some(stretch);
    (parameters, levels, report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cancel_token::CancelToken;
    use crate::database::{Tables, bake, load, save};
    use crate::pipeline::{DisplacementMethod, ElementChoice, SurfaceKind};
    use crate::scene::Material;
    use crate::surface::{RawMesh, shapes};
    use nalgebra::{Point3, Rotation3};

    fn request() -> BakeRequest {
        let tables = Tables { elastic: true, ..Tables::NONE };
        let elastic = DisplacementMethod::Solve;
        BakeRequest { tables, elastic, ..BakeRequest::new("sheet", "glass", Material::named("glass").unwrap()) }
    }

    fn turned(mut mesh: RawMesh) -> RawMesh {
        let turn = Rotation3::from_euler_angles(0.4, 1.1, -0.7);
        mesh.positions_m.iter_mut().for_each(|place| *place = turn * *place);
        mesh
    }

    /// A pane of 1 m × 0.6 m whose middle is `rise` higher than two of its sides.
    fn bent(thick: f64, rise: f64) -> RawMesh {
        let mut mesh = shapes::cuboid([1.0, 0.6, thick]);
        let count = 24;
        let at = |index: usize, side: f64, top: f64| {
            let x = index as f64 / count as f64 - 0.5;
            Point3::new(x, 0.3 * side, rise * (0.25 - x * x) * 4.0 + 0.5 * thick * top)
        };
        mesh.positions_m = (0..=count)
            .flat_map(|index| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| at(index, s, t)))
            .collect();
        let ring = |index: usize| {
            (0..4).flat_map(move |corner| {
                let [a, b] = [corner, (corner + 1) % 4].map(|corner| (4 * index + corner) as u32);
                [[a, a + 4, b + 4], [a, b + 4, b]]
            })
        };
        let last = 4 * count as u32;
        mesh.triangles = (0..count).flat_map(ring).collect();
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3], [last, last + 2, last + 1], [last, last + 3, last + 2]]);
        mesh
    }

    #[test]
    fn sheets_have_stretched_lattices_of_their_own_volume() {
        let request = BakeRequest { elements: ElementChoice::Linear, surface: SurfaceKind::Lattice, ..request() };
        for mesh in [turned(shapes::cuboid([1.0, 0.6, 0.004])), bent(0.005, 0.004)] {
            let mut own = bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap();
            let (report, stretch) = (&own.report, own.report.stretch.unwrap());
            println!(
                "{} nodes, volume {:.4}, deviation {:.5}",
                own.crack_nodes(),
                report.volume_error() + 1.0,
                report.surface_deviation
            );
            let nodes = own.crack_nodes();
            assert!(stretch.factor < STRETCH_MAX && (10_000..=SHEET_NODES).contains(&nodes), "{stretch:?}, {nodes}");
            assert!(report.volume_error().abs() < 0.01, "{report:?}");
            assert!(report.input_volume_m3 < 0.0031, "{report:?}");
            let heights = own.bodies[0].crack.volume() * own.frame.diagonal_m.powi(3) / report.input_volume_m3;
            assert!((heights - 1.0).abs() < 0.01, "the nodes are moved back: {heights}");
            let path = std::env::temp_dir().join(format!("sheet-{}.shatter", std::process::id()));
            let mut written = |stretch: Option<LatticeStretch>| {
                own.report.stretch = stretch;
                save(&own, &path).unwrap();
                load(&path)
            };
            assert_eq!(written(Some(stretch)).unwrap().report.stretch, Some(stretch));
            // Without its stretch, the angles of the lattice are none that a bake makes.
            let altered = [
                None,
                Some(LatticeStretch { factor: 100.0, ..stretch }),
                Some(LatticeStretch { axis: [1.0; 3], ..stretch }),
            ];
            altered.into_iter().for_each(|own| assert!(written(own).is_err(), "{own:?}"));
            std::fs::remove_file(&path).unwrap();
        }
    }

    #[test]
    fn what_is_no_sheet_or_names_a_spacing_is_refused_as_before() {
        let sheet = || shapes::cuboid([1.0, 1.0, 0.004]);
        let refused = |mesh: RawMesh, request: BakeRequest| match bake(
            mesh,
            &request,
            &CancelToken::default(),
            &mut |_| (),
        )
        .err()
        {
            Some(BakeError::TooThin { .. }) => {}
            other => panic!("{other:?}"),
        };
        refused(bent(0.004, 0.1), request());
        refused(sheet(), BakeRequest { crack_spacing: Some(0.01), ..request() });
        refused(sheet(), BakeRequest { elastic_spacing: Some(0.01), ..request() });
    }
}
