//! Lattices of a bake: volume, spacings, preserved parts of the surface, and the report about them.

use super::bake_error::{BakeError, GONE_MAX};
use super::bake_request::{BakeRequest, parameters};
use super::bake_step::BakeStep;
use super::cells::Cells;
use super::cracks::{UncrackedShape, elastic_spacing};
use super::hash::input_hash;
use super::lost_parts;
use super::sheet;
use super::thin::{self, ThinShape};
use super::wall_limits::WIDTH_MAX;
use crate::cancel_token::CancelToken;
use crate::lattice::{self, LatticeError, LatticeLevels, Spacings};
use crate::pipeline::{BakeParameters, BakeReport, Preset, SurfaceReport};
use crate::surface::{CrackSheets, InsideTest, Surface, SurfaceError, WidthSide};

/// Parameters, lattices and report of a bake.
///
/// If nothing is inside, or too little is preserved, the error names a needle, a flat surface or a distant vertex as the cause.
pub(super) fn lattices(
    request: &BakeRequest,
    surface: &Surface,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<(BakeParameters, LatticeLevels, BakeReport), BakeError> {
    let made = stuffed(request, surface, token, progress);
    let made = made
        .or_else(|error| sheet::stretched(request, surface, error, |thick| stuffed(request, thick, token, progress)));
    made.map_err(|error| {
        let reason = match &error {
            BakeError::Surface(SurfaceError::NothingInside)
            | BakeError::Lattice(LatticeError::NothingInside { .. })
            | BakeError::TooThin { .. }
            | BakeError::TooSmall { .. } => surface.nothing_inside(thin::THICKNESS_MIN),
            _ => None,
        };
        reason.map_or(error, BakeError::Surface)
    })
}

fn stuffed(
    request: &BakeRequest,
    surface: &Surface,
    token: &CancelToken,
    progress: &mut dyn FnMut(BakeStep),
) -> Result<(BakeParameters, LatticeLevels, BakeReport), BakeError> {
    let sheets = request.cracks.as_ref().map(|raw| CrackSheets::new(raw, &surface.frame)).transpose();
    let sheets = sheets.map_err(BakeError::Cracks)?;
    progress(BakeStep::Volume);
    let inside = InsideTest::new(surface);
    let volume = inside.input_volume(token)?;
    progress(BakeStep::Lattices);
    let walls = inside.widths(WidthSide::Wall, WIDTH_MAX, token)?;
    let shape = ThinShape { inside: &inside, diagonal_m: surface.frame.diagonal_m };
    let spacings = thin::spacings(request, volume, lost_parts::area(surface), &walls, &shape)?;
    let mut parameters = parameters(request, surface, spacings);
    let mut spacings = Spacings {
        elastic: parameters.elastic_spacing,
        crack: parameters.crack_spacing,
        refine: request.elastic_spacing.is_none(),
        fits_elastic: false,
    };
    let cells = Cells::measure(&inside, spacings.elastic, token)?;
    spacings.fits_elastic = cells.are_few(request.elements, spacings.elastic);
    let stuffed = |quality: Preset, spacings, volume| {
        let levels = if quality.lattices().fitted { lattice::fitted_levels } else { lattice::levels };
        levels(&inside, spacings, volume, token).map_err(|error| thin::explain(error, &walls, &shape))
    };
    let stuffed_by = |quality: Preset| {
        let request = BakeRequest { quality, ..request.without_cracks() };
        let [elastic, crack] = thin::spacings(&request, volume, lost_parts::area(surface), &walls, &shape)?;
        let refine = request.elastic_spacing.is_none();
        let spacings = Spacings { elastic, crack, refine, fits_elastic: false };
        lost_parts::keeps(surface, spacings, &|spacings| stuffed(quality, spacings, volume))
    };
    let follows = request.crack_spacing.is_none();
    let mut levels = lost_parts::refine_until_connected(surface, &mut spacings, follows, &|spacings| {
        stuffed(request.quality, spacings, volume)
    })?;
    parameters.crack_spacing = spacings.crack;
    let mut dropped_components = lost_parts::dropped_components(surface, &levels, volume);
    if dropped_components.volume > GONE_MAX * volume {
        let percent = 100.0 * (dropped_components.volume / volume).min(1.0);
        return Err(BakeError::TooSmall {
            count: dropped_components.count,
            percent,
            spacing: parameters.crack_spacing,
        });
    }
    let mut kept = volume;
    if dropped_components.volume > lattice::VOLUME_TOLERANCE * volume {
        // The lattice of the kept parts must not swell to replace the volume of the lost ones.
        kept = volume - dropped_components.volume;
        levels = stuffed(request.quality, spacings, kept)?;
        dropped_components = lost_parts::dropped_components(surface, &levels, volume);
    }
    let mut lost = thin::lost(&inside, &walls, &levels, shape.diagonal_m, token)?;
    let preset = request.crack_spacing.is_none().then_some(request.quality);
    if let Some(severed) = lost_parts::severed(surface, &inside, (&levels, volume), preset, &stuffed_by)? {
        if preset.is_some() && !request.allows_severed {
            return Err(BakeError::Severed(Box::new(severed)));
        }
        lost.push(severed.defect());
    }
    let mut report = report(surface, sheets.as_ref(), &inside, volume, &levels);
    if let Some(sheets) = &sheets {
        let intact = UncrackedShape { surface, inside: &inside, levels: &levels, volume: kept, spacings };
        levels = intact.slotted(sheets, &mut report, token)?;
    }
    parameters.elastic_spacing = elastic_spacing(&levels);
    report.elastic = cells.elastic(request.elements, &levels);
    lost.extend(lost_parts::far(&inside, &levels));
    lost.extend(dropped_components.defect(&inside, surface, volume));
    report.defects.extend(lost);
    Ok((parameters, levels, report))
}

fn report(
    surface: &Surface,
    sheets: Option<&CrackSheets>,
    inside: &InsideTest,
    volume: f64,
    levels: &LatticeLevels,
) -> BakeReport {
    let cubed = surface.frame.diagonal_m.powi(3);
    let lattice_volume: f64 = levels.bodies.iter().map(|body| body.crack.volume()).sum();
    let deviation = levels
        .bodies
        .iter()
        .map(|body| body.crack.deviation(&|point| inside.signed_distance(point).abs()))
        .fold(0.0, f64::max);
    let mut defects = surface.defects.clone();
    defects.extend(inside.ambiguous(&boundary_samples(levels)));
    BakeReport {
        input_hash: input_hash(surface, sheets),
        input_volume_m3: volume * cubed,
        lattice_volume_m3: lattice_volume * cubed,
        surface_deviation: deviation,
        defects,
        materials: surface.attributes.names.clone(),
        cracks: None,
        unprepared: Vec::new(),
        surface: SurfaceReport::default(),
        elastic: Vec::new(),
        stretch: None,
    }
}

fn boundary_samples(levels: &LatticeLevels) -> Vec<nalgebra::Point3<f64>> {
    levels.bodies.iter().flat_map(|body| body.crack.nodes.iter().copied()).collect()
}
