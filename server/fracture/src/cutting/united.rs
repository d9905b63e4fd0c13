//! Unites the parts of a closed surface that intersect or contain one another: what is left has an outside and an inside.
//!
//! Crossing triangles are divided along their intersections. A piece stays if the winding number is at least 1 behind it and
//! at most 0 in front of it. `manifold-rust` computes the arrangement and its winding numbers, exactly; positions are
//! rounded at the end.
//!
//! Based on: Q. Zhou, E. Grinspun, D. Zorin, A. Jacobson, *Mesh arrangements for solid geometry* (2016).

use super::build::CuttingError;
use super::meshed_surface::MeshedSurface;
use super::separated::separated;
use crate::cancel_token::CancelToken;
use crate::skin::{PointAttributes, blended};
use crate::surface::{barycentric, crossings, meeting_point};
use manifold_rust::linalg::Vec3;
use manifold_rust::robust::cells::{VertTables, build_cells, extract, windings};
use manifold_rust::robust::intersection_graph::{Piece, build_graph};
use manifold_rust::robust::pairing::plan_vertex_splits;
use manifold_rust::types::{OpType, WindingRule};
use nalgebra::Point3;

/// Largest number of crossing pairs of triangles that are resolved. Each takes exact arithmetic.
pub(super) const PAIRS_MAX: usize = 5_000;

/// Steps per unit of the grid on which the arrangement is computed: exact arithmetic is fast on small integers.
const GRID: f64 = (1_u64 << 40) as f64;

/// A united surface, and what was done.
pub(super) struct UnitedSurface {
    /// The surface.
    pub meshed: MeshedSurface,
    /// A point on the crossing of each triangle that crosses one with a higher number, local.
    pub crossings: Vec<Point3<f64>>,
    /// Triangles inside the solid.
    pub hidden: Vec<HiddenTriangle>,
    /// Vertices where parts touched, which are now apart; local.
    pub divided: Vec<Point3<f64>>,
}

/// Triangle inside the solid; local.
pub(super) struct HiddenTriangle {
    /// Its source.
    pub source: u32,
    /// One of its vertices.
    pub place: Point3<f64>,
    /// Its area.
    pub area: f64,
}

/// The boundary of the solid that `surface` encloses.
///
/// # Errors
/// [`CuttingError::Crossings`] if too many triangles cross, and [`CuttingError::Canceled`].
pub(super) fn united(surface: &MeshedSurface, token: &CancelToken) -> Result<UnitedSurface, CuttingError> {
    let all: Vec<u32> = (0..surface.triangles.len() as u32).collect();
    let pairs = crossings(&surface.positions, &surface.triangles, &all);
    if pairs.len() / 2 > PAIRS_MAX {
        return Err(CuttingError::Crossings { pairs: pairs.len() / 2 });
    }
    token.check()?;
    let on_grid = |vertex: u32| {
        let at = (surface.positions[vertex as usize] * GRID).map(f64::round);
        Vec3::new(at.x, at.y, at.z)
    };
    let triangles: Vec<[Vec3; 3]> = surface.triangles.iter().map(|own| own.map(on_grid)).collect();
    let graph = build_graph(&triangles, &[]);
    token.check()?;
    let complex = build_cells(&graph);
    let windings = windings(&graph, &complex, [&triangles, &[]]);
    token.check()?;
    let pieces = extract(&graph, &complex, &windings, OpType::Add, WindingRule::Positive);
    let corners: Vec<[u32; 3]> = pieces.iter().map(|piece| piece.vi).collect();
    let tables = VertTables { verts: &graph.verts, verts_f64: &graph.verts_f64 };
    let copies = plan_vertex_splits(&corners, tables);
    let mut positions: Vec<Point3<f64>> =
        graph.verts_f64.iter().map(|at| Point3::new(at.x, at.y, at.z) / GRID).collect();
    // Vertices of the input keep their places.
    for piece in &pieces {
        for vertex in surface.triangles[piece.tri] {
            let at = on_grid(vertex);
            let known = piece.vi.iter().find(|own| graph.verts_f64[**own as usize] == at);
            known.iter().for_each(|own| positions[**own as usize] = surface.positions[vertex as usize]);
        }
    }
    let attributes = match surface.corners.is_empty() {
        true => Vec::new(),
        false => pieces.iter().map(|piece| attributes(surface, piece, &positions)).collect(),
    };
    let meshed = MeshedSurface {
        positions,
        triangles: corners,
        corners: attributes,
        sources: pieces.iter().map(|piece| surface.sources[piece.tri]).collect(),
    };
    let (meshed, divided) = separated(meshed, copies.as_deref());
    let hidden_triangle = |own: u32| {
        let [a, b, c] = surface.triangles[own as usize].map(|vertex| surface.positions[vertex as usize]);
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        HiddenTriangle { source: surface.sources[own as usize], place: a, area }
    };
    let mut is_left = vec![false; surface.triangles.len()];
    pieces.iter().for_each(|piece| is_left[piece.tri] = true);
    let hidden = (0..surface.triangles.len() as u32).filter(|own| !is_left[*own as usize]);
    Ok(UnitedSurface {
        meshed: meshed.compact(),
        crossings: crossing_points(surface, &pairs),
        hidden: hidden.map(hidden_triangle).collect(),
        divided,
    })
}

/// A point on the crossing of each triangle with the first of those with a higher number.
fn crossing_points(surface: &MeshedSurface, pairs: &[[u32; 2]]) -> Vec<Point3<f64>> {
    let mut ordered: Vec<[u32; 2]> = pairs.iter().map(|[own, other]| [*own.min(other), *own.max(other)]).collect();
    ordered.sort_unstable();
    ordered.dedup_by_key(|[own, _]| *own);
    let corners = |triangle: u32| {
        let own = surface.triangles[triangle as usize];
        (own, own.map(|vertex| surface.positions[vertex as usize]))
    };
    ordered.iter().filter_map(|[own, other]| meeting_point(corners(*own), corners(*other))).collect()
}

/// Attributes at the corners of a piece of a triangle.
fn attributes(surface: &MeshedSurface, piece: &Piece, positions: &[Point3<f64>]) -> [PointAttributes; 3] {
    let (vertices, corners) = (surface.triangles[piece.tri], surface.corners[piece.tri]);
    let at = vertices.map(|vertex| surface.positions[vertex as usize]);
    piece.vi.map(|vertex| {
        let place = positions[vertex as usize];
        let known = at.iter().position(|corner| *corner == place);
        known.map_or_else(|| blended(corners, barycentric(&at, &place)), |corner| corners[corner])
    })
}
