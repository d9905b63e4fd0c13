//! Repair rounds: tetrahedralization and recovery, repeated with more points on the surface.
//!
//! The first round recovers the surface in a copy of the Delaunay tetrahedralization. While each round leaves fewer edges missing
//! than the one before, the next one divides tetrahedra at its points and keeps what was recovered. Otherwise, and where
//! triangles are missing, it inserts all points so far into the Delaunay tetrahedralization and recovers the surface anew.

use super::error::ConformingError;
use super::facets::{constrain_facets, recover_facets};
use super::flat_tets::remove_flat_tets;
use super::inside::extract;
use super::search::Search;
use super::segment_set::SegmentSet;
use super::segments::{missing_segments, recover_segments};
use super::split_surface::{SplitSurface, ascending};
use super::tetrahedralization::Tetrahedralization;
use super::work_limit::WorkLimit;
use super::{ConformingMesh, ConformingOptions, ConformingStep, ConstraintKind};
use crate::cancel_token::CancelToken;
use nalgebra::Point3;

/// Constraints that a round did not recover.
struct Missing {
    segments: Vec<[u32; 2]>,
    facets: Vec<[u32; 3]>,
}

/// Tetrahedralizes the inside of a surface. Splits the constraints that local changes cannot recover.
///
/// # Errors
/// [`ConformingError`] if constraints stay missing, a limit is exceeded, or the work is canceled.
pub(super) fn mesh_surface(
    mut surface: SplitSurface,
    interior: &[Point3<f64>],
    options: &ConformingOptions,
    token: &CancelToken,
    progress: &mut dyn FnMut(ConformingStep),
) -> Result<ConformingMesh, ConformingError> {
    let count = surface.positions.len();
    let mut limit = WorkLimit::new(options.points_max, options.steps_max, token);
    let mut delaunay = {
        let all: Vec<Point3<f64>> = surface.positions.iter().chain(interior).copied().collect();
        let total = all.len();
        check_points(total, options)?;
        let insert = &mut |done| progress(ConformingStep::Insert { round: 0, done, total });
        Tetrahedralization::delaunay(all, &mut limit, insert)?
    };
    let (mut round, mut delaunay_count) = (0, count);
    let mut mesh = delaunay.clone();
    let mut missing_before = usize::MAX;
    loop {
        limit.check(&mesh)?;
        limit.begin_round();
        let missing = recover(&mut mesh, &surface, round, &mut limit, progress)?;
        if missing.segments.is_empty() && missing.facets.is_empty() {
            progress(ConformingStep::Extract);
            token.check()?;
            let steiner_count = surface.positions.len() - count;
            return Ok(ConformingMesh { steiner_count, steps: limit.steps(), ..extract(&mesh, surface, round)? });
        }
        let first = surface.positions.len();
        if round == options.rounds_max || !split_missing(&mut surface, &missing) {
            return Err(unrecovered(&surface, &missing, round));
        }
        round += 1;
        check_points(surface.positions.len() + interior.len(), options)?;
        if missing.facets.is_empty() && missing.segments.len() < missing_before {
            missing_before = missing.segments.len();
            mesh.divide_at_points(first as u32, &surface.positions[first..], &mut limit)?;
            continue;
        }
        missing_before = usize::MAX;
        let added = &surface.positions[delaunay_count..];
        let insert = &mut |done| progress(ConformingStep::Insert { round, done, total: added.len() });
        delaunay.insert_points(delaunay_count as u32, added, &mut limit, insert)?;
        delaunay_count = surface.positions.len();
        mesh = delaunay.clone();
    }
}

fn check_points(points: usize, options: &ConformingOptions) -> Result<(), ConformingError> {
    if points > options.points_max {
        return Err(ConformingError::TooManyPoints { points, points_max: options.points_max });
    }
    Ok(())
}

/// Recovers the surface's edges and then, if none is missing, its triangles; with all of them, removes flat tetrahedra.
fn recover(
    mesh: &mut Tetrahedralization,
    surface: &SplitSurface,
    round: u32,
    limit: &mut WorkLimit,
    progress: &mut dyn FnMut(ConformingStep),
) -> Result<Missing, ConformingError> {
    let count = surface.positions.len();
    let segments = SegmentSet::new(count, &surface.triangles);
    let missing = missing_segments(mesh, &segments, count);
    progress(ConformingStep::Segments { round, missing: missing.len() });
    let mut search = Search { mesh, segments: &segments, limit };
    let missing = recover_segments(&mut search, missing)?;
    if !missing.is_empty() {
        return Ok(Missing { segments: missing, facets: Vec::new() });
    }
    let facets = constrain_facets(&mut search, &surface.triangles)?;
    progress(ConformingStep::Facets { round, missing: facets.len() });
    let facets = recover_facets(&mut search, facets)?;
    if facets.is_empty() {
        remove_flat_tets(&mut search)?;
    }
    Ok(Missing { segments: Vec::new(), facets })
}

/// Splits missing edges, and the longest edge of each missing triangle. Returns false if all are too short.
fn split_missing(surface: &mut SplitSurface, missing: &Missing) -> bool {
    let count = surface.positions.len();
    let facets = missing.facets.iter().map(|facet| surface.longest_edge(facet).1);
    let edges: Vec<([u32; 2], f64)> =
        missing.segments.iter().copied().map(ascending).chain(facets).map(|edge| (edge, 0.5)).collect();
    surface.split_edges(&edges);
    surface.flip_inside_triangles();
    surface.positions.len() > count
}

fn unrecovered(surface: &SplitSurface, missing: &Missing, rounds: u32) -> ConformingError {
    let center = |vertices: &[u32]| {
        let sum = vertices.iter().fold(nalgebra::Vector3::zeros(), |sum, &vertex| {
            sum + surface.positions[vertex as usize].coords / vertices.len() as f64
        });
        Point3::from(sum)
    };
    let (kind, at) = match (missing.segments.first(), missing.facets.first()) {
        (Some(segment), _) => (ConstraintKind::Segment, center(segment)),
        (None, Some(facet)) => (ConstraintKind::Facet, center(facet)),
        (None, None) => (ConstraintKind::Facet, Point3::origin()),
    };
    ConformingError::Unrecovered { kind, at, rounds, missing: missing.segments.len() + missing.facets.len() }
}
