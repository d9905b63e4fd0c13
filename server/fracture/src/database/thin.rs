//! Walls and gaps that are thin relative to the lattice: the spacing adapts to walls, and losses are reported.

use super::BakeRequest;
use super::bake_error::BakeError;
use super::lost_parts::LEFT_OUT;
use super::wall_limits::{WALL_SPACINGS, WIDTH_MAX};
use crate::cancel_token::CancelToken;
use crate::lattice::{self, LatticeError, LatticeLevels, Locator};
use crate::pipeline::LatticeSettings;
use crate::surface::{Defect, DefectKind, InsideTest, Width, WidthSide, Widths};
use rayon::prelude::*;

/// Share of the surface with lost walls at which a bake fails.
///
/// The spacing follows the thickness that the walls of this share do not exceed. The report names smaller losses.
const SHARE: f64 = 0.25;

/// Smallest number of samples that is reported.
const SAMPLES_MIN: usize = 3;

/// Thickness that the finest lattice resolves, local.
pub(super) const THICKNESS_MIN: f64 = WALL_SPACINGS[1] * lattice::SPACING_RANGE[0];

/// Elastic and crack spacing, local: the given ones, or the defaults, refined where walls need it.
pub(super) fn spacings(
    request: &BakeRequest,
    volume: f64,
    area: f64,
    walls: &Widths,
    shape: &ThinShape<'_>,
) -> Result<[f64; 2], BakeError> {
    let LatticeSettings { elastic_nodes, crack_nodes, .. } = request.quality.lattices();
    let nodes = [elastic_nodes, crack_nodes];
    let chosen = lattice::spacings(volume, area, nodes, request.elastic_spacing, request.crack_spacing)?;
    let thickness = walls.quantile(SHARE);
    let finer =
        |asked: Option<f64>, chosen: f64, needed: f64| if asked.is_some() { chosen } else { chosen.min(needed) };
    let grid_finest = shape.inside.finest_grid_spacing(0.0);
    for factor in WALL_SPACINGS {
        let crack = finer(request.crack_spacing, chosen[1], thickness / factor);
        // The grid limits a default spacing as the number of nodes does.
        let limit = grid_finest.min(thickness / factor);
        let crack = if request.crack_spacing.is_none() { crack.max(limit) } else { crack };
        let elastic = finer(request.elastic_spacing, chosen[0], thickness / factor).max(crack);
        match lattice::spacings(volume, area, nodes, Some(elastic), Some(crack)) {
            Ok([_, crack]) if request.crack_spacing.is_none() && crack < grid_finest => {}
            Ok(spacings) => return Ok(spacings),
            Err(LatticeError::SpacingOutOfRange { .. } | LatticeError::TooManyNodes { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    let possible = possible_thickness(thickness, volume, area, walls, shape);
    Err(too_thin(thickness, chosen[1], Some(possible), shape))
}

/// Shape whose walls may be too thin.
pub(super) struct ThinShape<'a> {
    /// Inside test of the surface.
    pub inside: &'a InsideTest,
    /// Diagonal of its bounding box, m.
    pub diagonal_m: f64,
}

/// Smallest thickness, local, at which the shape can be baked if all its thinner walls are thickened to it.
fn possible_thickness(thickness: f64, volume: f64, area: f64, walls: &Widths, shape: &ThinShape<'_>) -> f64 {
    // Each side of a wall gains half of what the wall gains.
    let each = 0.5 * area / walls.samples.len().max(1) as f64;
    let grown = |thicker: f64| walls.samples.iter().map(|wall| each * (thicker - wall.width).max(0.0)).sum::<f64>();
    let possible = |thicker: &f64| {
        let spacing = Some(thicker / WALL_SPACINGS[1]);
        lattice::spacings(volume + grown(*thicker), area, [1; 2], spacing, spacing).is_ok()
            && grid_allows(*thicker, thickness, shape)
    };
    thicker(thickness, possible)
}

/// First thickness from `thickness` on, in steps of 2 %, that is `possible`. At a tenth of the diagonal, every shape can be baked.
fn thicker(thickness: f64, possible: impl Fn(&f64) -> bool) -> f64 {
    let mut thicker = (0..).map(|step| thickness * 1.02_f64.powi(step)).take_while(|thicker| *thicker < WIDTH_MAX);
    thicker.find(possible).unwrap_or(WIDTH_MAX)
}

/// True if a grid is small enough for walls that are thickened from `thickness` to `thicker`. Its box grows with them, by no more than
/// they do.
fn grid_allows(thicker: f64, thickness: f64, shape: &ThinShape<'_>) -> bool {
    shape.inside.finest_grid_spacing(thicker - thickness) <= thicker / WALL_SPACINGS[1]
}

/// The error for a lattice of this spacing without inside: walls that are too thin, if they have a measured thickness.
pub(super) fn explain(error: LatticeError, walls: &Widths, shape: &ThinShape<'_>) -> BakeError {
    match error {
        LatticeError::NothingInside { spacing } if walls.quantile(SHARE) < WIDTH_MAX => {
            too_thin(walls.quantile(SHARE), spacing, None, shape)
        }
        // No spacing between both limits: a coarser one would lose the walls.
        LatticeError::GridTooLarge { spacing, .. }
            if walls.quantile(SHARE) < WALL_SPACINGS[1] * shape.inside.finest_grid_spacing(0.0) =>
        {
            too_thin(walls.quantile(SHARE), spacing, None, shape)
        }
        error => error.into(),
    }
}

/// The error for walls of this thickness (local), which `spacing` loses. No smaller thickness is named than the grid allows.
fn too_thin(thickness: f64, spacing: f64, thickness_needed: Option<f64>, shape: &ThinShape<'_>) -> BakeError {
    let meters = |local: f64| local * shape.diagonal_m;
    let [spacing_needed, finest] = [thickness / WALL_SPACINGS[1], shape.inside.finest_grid_spacing(0.0)];
    let by_grid = (spacing_needed < finest).then(|| thicker(thickness, |own| grid_allows(*own, thickness, shape)));
    BakeError::TooThin {
        thickness_m: meters(thickness),
        spacing,
        spacing_needed,
        thickness_needed_m: thickness_needed.or(by_grid).map(meters),
    }
}

/// Beginning of the action for walls that the lattice lacks, and so do the fragments.
const LOST: &str = "lost: too thin for the lattice";

/// Beginning of the action for gaps that the lattice closes, as in the fragments.
const CLOSED: &str = "closed: too narrow for the lattice";

/// Reports the walls that the crack lattice lost and the gaps that it closed.
///
/// Fails if the walls of [`SHARE`] of the surface are lost.
pub(super) fn lost(
    inside: &InsideTest,
    walls: &Widths,
    levels: &LatticeLevels,
    diagonal_m: f64,
    token: &CancelToken,
) -> Result<Vec<Defect>, BakeError> {
    let locators: Vec<Locator> = levels.bodies.iter().map(|body| Locator::new(&body.crack)).collect();
    let filled = |sample: &Width| locators.iter().any(|locator| locator.containing(&sample.middle, None).is_some());
    let spacing = levels.crack.spacing;
    // Sharp edges are also thin, and only rounded. Near a lost wall there is no lattice at all.
    let near = |locator: &Locator, sample: &Width| {
        locator.nearest(&sample.middle).is_some_and(|nearest| nearest.distance < 0.5 * spacing)
    };
    let gone = pick(walls, |sample| {
        let thin = sample.width < WALL_SPACINGS[0] * spacing;
        thin && !filled(sample) && !locators.iter().any(|locator| near(locator, sample))
    });
    let share = gone.len() as f64 / walls.samples.len().max(1) as f64;
    if share >= SHARE {
        let thickness = walls.quantile(SHARE);
        return Err(too_thin(thickness, spacing, None, &ThinShape { inside, diagonal_m }));
    }
    let gaps = inside.widths(WidthSide::Gap, spacing, token)?;
    let closed = pick(&gaps, |sample| sample.width < spacing && filled(sample));
    let closed_share = closed.len() as f64 / gaps.samples.len().max(1) as f64;
    let named = |kind, samples: &[Width], share: f64, what: &str| {
        let first = samples.first().filter(|_| samples.len() >= SAMPLES_MIN)?;
        let (width_m, percent) = (first.width * diagonal_m, 100.0 * share);
        let action = format!("{what}: {percent:.2} % of the surface, {width_m:.3e} m at the narrowest");
        Some(Defect::new(kind, samples.len() as u64, first.face, action))
    };
    let walls = named(DefectKind::ThinWall, &gone, share, LOST);
    let gaps = named(DefectKind::NarrowGap, &closed, closed_share, CLOSED);
    Ok(walls.into_iter().chain(gaps).collect())
}

/// Says of the walls, gaps and parts that the lattice lacks that the exact surface keeps them, and of vertices in which parts touch, if
/// they were divided.
pub(super) fn report_exact(defects: &mut [Defect], is_divided: bool) {
    for defect in defects {
        let action = match defect.kind {
            DefectKind::NonManifoldVertex if is_divided => "divided for the exact surface".to_owned(),
            DefectKind::ThinWall => defect.action.replacen(LOST, "lost in the lattice, kept by the exact surface", 1),
            DefectKind::NarrowGap => {
                defect.action.replacen(CLOSED, "closed in the lattice, kept by the exact surface", 1)
            }
            DefectKind::DroppedComponent => {
                defect.action.replacen(LEFT_OUT, "lost in the lattice, kept by the exact surface", 1)
            }
            _ => continue,
        };
        defect.action = action;
    }
}

/// Says of the holes that they are the rims of sheets, whose films bound no part of the exact surface.
pub(super) fn report_loose_sheets(defects: &mut [Defect]) {
    for defect in defects.iter_mut().filter(|defect| defect.kind == DefectKind::Holes) {
        "of sheets without volume, which the exact surface leaves out".clone_into(&mut defect.action);
    }
}

/// The samples accepted by `choose`, narrowest first.
fn pick(widths: &Widths, choose: impl Fn(&Width) -> bool + Sync) -> Vec<Width> {
    let narrow = widths.samples.par_iter().filter(|sample| sample.width < WIDTH_MAX);
    narrow.filter(|sample| choose(sample)).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::database::{Tables, bake};
    use crate::pipeline::{PreparedObject, SurfaceKind};
    use crate::scene::Material;
    use crate::surface::{RawMesh, Surface, SurfaceError, shapes};

    /// Lattices alone: no table decides what they keep. The hard cases of the lab bake and strike a plate and a needle of 1:100 whole.
    fn request(crack_spacing: Option<f64>) -> BakeRequest {
        let material = Material { source: String::new(), ..Material::named("glass").unwrap() };
        let (tables, surface) = (Tables::NONE, SurfaceKind::Lattice);
        BakeRequest { crack_spacing, tables, surface, ..BakeRequest::new("thin", "glass", material) }
    }

    fn baked(mesh: RawMesh, crack_spacing: Option<f64>) -> Result<PreparedObject, BakeError> {
        bake(mesh, &request(crack_spacing), &CancelToken::default(), &mut |_| ())
    }

    /// Expects one body with the input's volume and without losses, at default spacings.
    fn check(mesh: RawMesh) {
        let prepared = baked(mesh, None).unwrap();
        let report = &prepared.report;
        println!(
            "{} crack nodes, {} elastic, spacing {:.5}, volume {:+.4}",
            prepared.crack_nodes(),
            prepared.elastic_nodes(),
            prepared.parameters.crack_spacing,
            report.volume_error()
        );
        assert_eq!(prepared.bodies.len(), 1);
        assert!(report.volume_error().abs() < 0.01 && report.defects.is_empty(), "{report:?}");
    }

    /// A mesh turned out of the axes, by the first or the second of two rotations.
    fn turned(mut mesh: RawMesh, which: usize) -> RawMesh {
        let [x, y, z] = [[0.4, 1.1, -0.7], [-1.3, 0.5, 0.25]][which];
        let rotation = nalgebra::Rotation3::from_euler_angles(x, y, z);
        mesh.positions_m.iter_mut().for_each(|point| *point = rotation * *point);
        mesh
    }

    /// The grid over its bounding box would have 40 to 100 times the nodes that are allowed.
    #[test]
    fn turned_bars_are_as_good_as_straight_ones() {
        let bar = || shapes::cuboid([1.0, 0.006, 0.006]);
        let straight = baked(bar(), None).unwrap();
        for which in [0, 1] {
            let own = baked(turned(bar(), which), None).unwrap();
            let meters = |own: &PreparedObject| own.parameters.crack_spacing * own.frame.diagonal_m;
            println!("spacing {} m, {} nodes", meters(&own), own.crack_nodes());
            assert!((meters(&own) / meters(&straight) - 1.0).abs() < 1e-3, "{} m", meters(&own));
            assert!(
                (own.report.elements_across().unwrap() / straight.report.elements_across().unwrap() - 1.0).abs() < 1e-3
            );
            assert_eq!((own.bodies.len(), own.report.defects.len()), (1, 0));
            assert!(own.report.volume_error().abs() < 2e-3, "{}", own.report.volume_error());
        }
        let coarse = baked(turned(bar(), 0), Some(0.02)).err().unwrap();
        assert!(matches!(coarse, BakeError::TooThin { thickness_needed_m: None, .. }), "{coarse}");
    }

    /// 1:250 as the issue of thin walls asks, and the remedy where that is too thin: a plate of 1 m needs 65,000 nodes at 1:100.
    #[test]
    fn limits_of_thinness_do_not_depend_on_the_direction() {
        let strip = |thick: f64| shapes::cuboid([1.0, 0.1, thick]);
        for mesh in [strip(0.004), turned(strip(0.004), 0)] {
            let own = baked(mesh, None).unwrap();
            println!(
                "strip of 1:250: {} elastic nodes, {:?} across",
                own.elastic_nodes(),
                own.report.elements_across()
            );
            assert_eq!(own.bodies.len(), 1);
        }
        let plate = |thick: f64| shapes::cuboid([1.0, 1.0, thick]);
        let own = baked(turned(plate(0.004), 0), None).unwrap();
        let cells = own.report.elements_across();
        println!("plate of 1:250: {} elastic nodes, {cells:?} across", own.elastic_nodes());
        assert!(own.report.stretch.is_some() && cells > Some(1.2) && own.bodies.len() == 1);
        let needed = |mesh| match baked(mesh, None).err() {
            Some(BakeError::TooThin { thickness_needed_m: Some(needed_m), .. }) => needed_m,
            other => panic!("{other:?}"),
        };
        let straight = needed(plate(0.0005));
        println!("a plate of 1 m needs {straight} m");
        assert!((0.125 / 112.0..0.125 / 105.0).contains(&straight), "{straight}");
        let own = needed(turned(plate(0.0005), 1));
        assert!((own / straight - 1.0).abs() < 0.03, "{own} m, straight {straight} m");
    }

    /// A pane of thickness `t`, m, in a row with a ball of half a cubic meter, or alone and turned.
    #[test]
    fn the_thickness_named_for_thin_walls_can_be_baked_and_a_smaller_one_cannot() {
        let with_ball = |t: f64| {
            let (mut all, pane) = (shapes::sphere(0.5, 3), shapes::cuboid([1.0, 1.0, t]));
            let first = all.positions_m.len() as u32;
            all.positions_m.extend(pane.positions_m.iter().map(|point| point + nalgebra::Vector3::x() * 1.2));
            all.triangles.extend(pane.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
            all
        };
        let alone = |t: f64| turned(shapes::cuboid([1.0, 0.5, t]), 0);
        let spacing = |mesh: RawMesh| {
            let surface = Surface::repair(mesh).unwrap();
            let token = CancelToken::default();
            let inside = InsideTest::new(&surface);
            let walls = inside.widths(WidthSide::Wall, WIDTH_MAX, &token).unwrap();
            let (volume, area) = (inside.input_volume(&token).unwrap(), super::super::lost_parts::area(&surface));
            let shape = ThinShape { inside: &inside, diagonal_m: surface.frame.diagonal_m };
            spacings(&request(None), volume, area, &walls, &shape)
        };
        for (shape, thin) in
            [(&with_ball as &dyn Fn(f64) -> RawMesh, [0.006, 0.012, 0.02]), (&alone, [0.001, 0.004, 0.006])]
        {
            for t in thin {
                let Err(BakeError::TooThin { thickness_needed_m: Some(needed_m), .. }) = spacing(shape(t)) else {
                    panic!("{t} is thick enough")
                };
                let possible = [0.94, 1.02].map(|factor| spacing(shape(factor * needed_m)).is_ok());
                assert_eq!(possible, [false, true], "{t} m: {needed_m} m");
            }
        }
    }

    #[test]
    fn plates_needles_and_vases_are_kept_whole() {
        check(shapes::cuboid([1.0, 0.5, 0.02]));
        check(shapes::cuboid([1.0, 0.01, 0.01]));
        check(shapes::vase());
    }

    #[test]
    fn walls_too_thin_for_any_lattice_are_rejected_with_their_thickness() {
        let sheet = baked(shapes::cuboid([1.0, 0.5, 0.0005]), None).err().unwrap();
        let BakeError::TooThin { thickness_m, thickness_needed_m: Some(needed_m), .. } = sheet else {
            panic!("{sheet}")
        };
        assert!((thickness_m / 5e-4 - 1.0).abs() < 0.02);
        check(shapes::cuboid([1.0, 0.5, 1.02 * needed_m]));
        let thinner = baked(shapes::cuboid([1.0, 0.5, 0.95 * needed_m]), None).err().unwrap();
        assert!(matches!(thinner, BakeError::TooThin { thickness_needed_m: Some(_), .. }), "{thinner}");
        let needle = baked(shapes::cuboid([1000.0, 1.0, 1.0]), None).err().unwrap();
        assert!(matches!(needle, BakeError::Surface(SurfaceError::Needle { .. })), "{needle}");
        let vase = baked(shapes::vase(), Some(0.035)).err().unwrap();
        let BakeError::TooThin { thickness_m, spacing, spacing_needed, thickness_needed_m: None, .. } = vase else {
            panic!("{vase}")
        };
        assert!((thickness_m / 0.006 - 1.0).abs() < 0.1 && spacing == 0.035 && spacing_needed < 0.02, "{thickness_m}");
    }

    #[test]
    fn the_exact_surface_keeps_a_gap_that_the_lattice_closes() {
        // A block with a slot of 0.004 in its top.
        let profile = [
            [-0.5, 0.0],
            [0.5, 0.0],
            [0.5, 1.0],
            [0.002, 1.0],
            [0.002, 0.4],
            [-0.002, 0.4],
            [-0.002, 1.0],
            [-0.5, 1.0],
        ];
        let positions = [0.5, -0.5].iter().flat_map(|z| profile.map(|[x, y]| nalgebra::Point3::new(x, y, *z)));
        let front = [[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7]];
        let back = front.map(|[a, b, c]: [u32; 3]| [a + 8, c + 8, b + 8]);
        let sides = (0..8).flat_map(|k| [[k, k + 8, (k + 1) % 8 + 8], [k, (k + 1) % 8 + 8, (k + 1) % 8]]);
        let block = RawMesh::new(positions.collect(), front.into_iter().chain(back).chain(sides).collect());
        for (surface, wanted) in [
            (SurfaceKind::Exact, "closed in the lattice, kept by the exact surface: "),
            (SurfaceKind::Lattice, "closed: too narrow for the lattice: "),
        ] {
            let request = BakeRequest { surface, ..request(None) };
            let report = bake(block.clone(), &request, &CancelToken::default(), &mut |_| ()).unwrap().report;
            assert_eq!(report.surface.kind, surface);
            let gap = report.defects.iter().find(|own| own.kind == DefectKind::NarrowGap).unwrap();
            let action = gap.action.strip_prefix(wanted).unwrap_or_else(|| panic!("{}", gap.action));
            assert!(action.ends_with(" m at the narrowest"), "{action}");
        }
    }

    #[test]
    fn a_closed_gap_and_a_lost_fin_are_named() {
        let mut two = shapes::cuboid([1.0; 3]);
        let fin = shapes::cuboid([0.01, 0.3, 0.3]);
        let (gap, beside) = (shapes::cuboid([1.0; 3]), [1.004, 0.0, 0.0]);
        for (other, offset) in [(gap, beside), (fin, [0.0, 0.6, 0.0])] {
            let first = two.positions_m.len() as u32;
            two.positions_m.extend(other.positions_m.iter().map(|p| p + nalgebra::Vector3::from(offset)));
            two.triangles.extend(other.triangles.iter().map(|corners| corners.map(|vertex| vertex + first)));
        }
        let prepared = baked(two, None).unwrap();
        let named = |kind| prepared.report.defects.iter().any(|defect| defect.kind == kind && defect.count > 3);
        assert!(named(DefectKind::NarrowGap) && named(DefectKind::ThinWall), "{:?}", prepared.report.defects);
    }
}
