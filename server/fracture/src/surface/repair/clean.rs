//! Welding of equal vertices, and removal of degenerate and duplicate triangles.

use super::super::defect::DefectTally;
use super::super::tree::BoundingBox;
use super::super::{DIAGONAL_RANGE_M, Defect, DefectKind, LocalFrame, RawMesh, SurfaceError};
use super::edges::Edges;
use super::given_windings::separates_inverted;
use super::inverted_parts::turn_inverted_parts;
use super::orient::area_vector;
use crate::scene::counted;
use nalgebra::Point3;
use robust::{Coord, orient2d};
use std::collections::{BTreeSet, HashMap};

/// Largest accepted rounding of coordinates, relative to the diagonal. Beyond it, details of the shape are lost.
const VISIBLE_ROUNDING: f64 = 1e-5;

/// Passes over degenerate triangles: dropping one can give its neighbor an open edge.
const PEELS_MAX: usize = 8;

/// Welded mesh in local coordinates.
pub(super) struct CleanMesh {
    /// Transform between the object's coordinates and local ones.
    pub frame: LocalFrame,
    /// Vertex positions, local.
    pub positions: Vec<Point3<f64>>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Triangle of the raw mesh that each triangle came from.
    pub source: Vec<u32>,
    /// Whether the winding of each triangle is not that of the raw mesh.
    pub is_turned: Vec<bool>,
    /// Parts that were turned outward.
    pub turned_parts: DefectTally,
    /// Triangles that were dropped because others have the same corners.
    pub duplicates: Duplicates,
}

/// Triangles that were dropped because others have the same corners; local.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Duplicates {
    /// A corner of each.
    pub places: Vec<Point3<f64>>,
    /// Their area.
    pub area: f64,
}

/// Welds equal positions and drops triangles that repeat a vertex, have no area or duplicate another triangle.
///
/// Turns inverted parts first, because triangles that they share with others would be taken for duplicates.
pub(super) fn clean(raw: &RawMesh, defects: &mut Vec<Defect>) -> Result<CleanMesh, SurfaceError> {
    let flat: Vec<bool> = raw.triangles.iter().map(|corners| is_flat(&raw.positions_m, corners)).collect();
    let frame = frame(raw, &flat)?;
    report_precision(raw, &frame, defects);
    let (positions, welded) = weld(raw, &frame, defects);
    let mut clean = CleanMesh::new(frame, positions);
    let mut degenerate = DefectTally::default();
    for (triangle, corners) in raw.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|vertex| welded[vertex as usize]);
        if a == b || b == c || c == a {
            degenerate.note(raw.face(triangle));
        } else {
            clean.triangles.push([a, b, c]);
            clean.source.push(triangle as u32);
        }
    }
    let repeated = degenerate.count() > 0;
    clean.turn_inverted_parts(raw);
    clean.drop_duplicates(raw, defects);
    let sewn = clean.drop_flat(&flat, raw, &mut degenerate);
    let action = match (repeated || degenerate.count() > sewn, sewn) {
        (true, 0) => "dropped".to_owned(),
        (true, _) => format!("dropped, except {sewn} that close the surface"),
        (false, _) => "kept: they close the surface".to_owned(),
    };
    degenerate.report(DefectKind::DegenerateTriangles, action, defects);
    clean.compact();
    if clean.triangles.iter().all(|corners| is_flat(&clean.positions, corners)) {
        // Triangles with an area were left out as pairs that face each other.
        let vertices: BTreeSet<u32> = raw.triangles.iter().flatten().copied().collect();
        let points: Vec<Point3<f64>> = vertices.iter().map(|&vertex| raw.positions_m[vertex as usize]).collect();
        return Err(SurfaceError::flat(&points, false).unwrap_or(SurfaceError::NothingInside));
    }
    Ok(clean)
}

/// Returns true if the corners lie exactly on a line.
pub(in crate::surface) fn is_flat(positions: &[Point3<f64>], corners: &[u32; 3]) -> bool {
    let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
    (0..3).all(|axis| {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let [a, b, c] = [a, b, c].map(|p| Coord { x: p[u], y: p[v] });
        orient2d(a, b, c) == 0.0
    })
}

/// Frame of the bounding box of all triangles that have an area.
fn frame(raw: &RawMesh, flat: &[bool]) -> Result<LocalFrame, SurfaceError> {
    let corners = |triangle: &'_ [u32; 3]| triangle.map(|vertex| &raw.positions_m[vertex as usize]);
    let all = BoundingBox::of(raw.triangles.iter().flat_map(corners));
    if all.low == all.high {
        return Err(SurfaceError::ZeroExtent);
    }
    let solid = raw.triangles.iter().zip(flat).filter(|(_, flat)| !**flat).map(|(triangle, _)| triangle);
    let bounds = BoundingBox::of(solid.flat_map(corners));
    if bounds.low.x > bounds.high.x {
        return Err(SurfaceError::AllDegenerate);
    }
    let diagonal_m = bounds.diagonal().norm();
    if !DIAGONAL_RANGE_M.contains(&diagonal_m) {
        return Err(SurfaceError::ExtentOutOfRange { diagonal_m });
    }
    Ok(LocalFrame { center_m: bounds.low + bounds.diagonal() * 0.5, diagonal_m })
}

fn report_precision(raw: &RawMesh, frame: &LocalFrame, defects: &mut Vec<Defect>) {
    let limit = VISIBLE_ROUNDING * frame.diagonal_m / raw.rounding;
    let mut far = DefectTally::default();
    for (vertex, point) in raw.positions_m.iter().enumerate() {
        if point.coords.amax() > limit {
            far.note(vertex as u64);
        }
    }
    far.report(DefectKind::LostPrecision, "not repaired: move the object near the origin or store doubles", defects);
}

/// Merges equal local positions.
///
/// Returns the merged positions, and the merged index of each raw vertex: `u32::MAX` for vertices of no triangle.
fn weld(raw: &RawMesh, frame: &LocalFrame, defects: &mut Vec<Defect>) -> (Vec<Point3<f64>>, Vec<u32>) {
    let mut used = vec![false; raw.positions_m.len()];
    raw.triangles.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
    let mut positions = Vec::with_capacity(raw.positions_m.len());
    let mut welded = vec![u32::MAX; raw.positions_m.len()];
    let mut places = HashMap::with_capacity(raw.positions_m.len());
    let (mut unreferenced, mut duplicate) = (DefectTally::default(), DefectTally::default());
    for (vertex, point_m) in raw.positions_m.iter().enumerate() {
        if !used[vertex] {
            unreferenced.note(vertex as u64);
            continue;
        }
        let local = frame.to_local(point_m);
        // Adding 0 turns −0 into 0, so that equal positions have equal bits.
        let key: [u64; 3] = [0, 1, 2].map(|k| (local[k] + 0.0).to_bits());
        let next = positions.len() as u32;
        let place = *places.entry(key).or_insert(next);
        if place == next {
            positions.push(local);
        } else {
            duplicate.note(vertex as u64);
        }
        welded[vertex] = place;
    }
    unreferenced.report(DefectKind::UnreferencedVertices, "left out", defects);
    duplicate.report(DefectKind::DuplicateVertices, "welded", defects);
    (positions, welded)
}

/// Action for equal triangles of which pairs that face opposite ways were dropped, and others kept if they are shared.
fn pairs_action(pairs: u64, is_shared: bool) -> String {
    let dropped = format!("{} that face opposite ways dropped: they enclose nothing", counted(pairs, "pair"));
    match (pairs, is_shared) {
        (0, _) => "kept: solids that overlap share them".to_owned(),
        (_, true) => format!("kept: solids that overlap share them; {dropped}"),
        (_, false) => dropped,
    }
}

/// Action for groups of equal triangles of which one was kept, but none in as many as form walls.
fn walls_action(walls: usize, groups: usize) -> String {
    match walls {
        0 => "one copy kept".to_owned(),
        _ if walls == groups => "no copy kept: the surface is closed there without them".to_owned(),
        _ => format!("one copy kept, but no copy of {walls}: the surface is closed there without them"),
    }
}

/// Choice of one triangle from each group of equal ones.
struct OneOfEach {
    /// Whether each triangle is kept.
    keep: Vec<bool>,
    /// Number of triangles that form walls, of which none is kept.
    walls: usize,
}

impl OneOfEach {
    /// The kept triangles of `mesh`.
    fn triangles(&self, mesh: &CleanMesh) -> Vec<[u32; 3]> {
        mesh.triangles.iter().zip(&self.keep).filter(|(_, keep)| **keep).map(|(own, _)| *own).collect()
    }
}

impl CleanMesh {
    /// A mesh without triangles.
    fn new(frame: LocalFrame, positions: Vec<Point3<f64>>) -> Self {
        let (triangles, source, is_turned) = (Vec::new(), Vec::new(), Vec::new());
        let (turned_parts, duplicates) = (DefectTally::default(), Duplicates::default());
        Self { frame, positions, triangles, source, is_turned, turned_parts, duplicates }
    }

    /// Turns parts that are inside out beside others.
    fn turn_inverted_parts(&mut self, raw: &RawMesh) {
        let turned = turn_inverted_parts(&self.positions, &mut self.triangles);
        for triangle in turned.parts {
            self.turned_parts.note(raw.face(self.source[triangle as usize] as usize));
        }
        self.is_turned = turned.is_turned;
        self.is_turned.resize(self.triangles.len(), false);
    }

    /// Keeps one of several triangles with the same corners.
    ///
    /// Keeps none of them where they form a wall between two sides that are closed without it, and all that face the same way
    /// where the surface is closed with them only: solids that overlap share them.
    fn drop_duplicates(&mut self, raw: &RawMesh, defects: &mut Vec<Defect>) {
        let mut sorted: Vec<([u32; 3], u32)> = Vec::with_capacity(self.triangles.len());
        for (triangle, corners) in self.triangles.iter().enumerate() {
            let mut key = *corners;
            key.sort_unstable();
            sorted.push((key, triangle as u32));
        }
        sorted.sort_unstable();
        let groups = || sorted.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1);
        let mut repeated = DefectTally::default();
        for (_, triangle) in groups().flat_map(|same| &same[1..]) {
            repeated.note(raw.face(self.source[*triangle as usize] as usize));
        }
        if repeated.count() == 0 {
            return;
        }
        let one_each = self.with_one_of_each(groups());
        let tried: Vec<u32> = groups().map(|same| same[0].1).collect();
        let is_needed = Edges::new(&self.triangles).balanced()
            && !Edges::new(&one_each.triangles(self)).balanced()
            && !separates_inverted(&self.positions, &self.triangles, &tried);
        let (keep, action) = match is_needed {
            true => {
                let keep = self.without_opposite_pairs(groups());
                let pairs = keep.iter().filter(|keep| !**keep).count() as u64 / 2;
                let kept_count = |same: &[([u32; 3], u32)]| same.iter().filter(|own| keep[own.1 as usize]).count();
                let action = pairs_action(pairs, groups().any(|same| kept_count(same) > 1));
                (keep, action)
            }
            false => {
                let action = walls_action(one_each.walls, groups().count());
                (one_each.keep, action)
            }
        };
        for (own, _) in self.triangles.iter().zip(&keep).filter(|(_, keep)| !**keep) {
            self.duplicates.places.push(self.positions[own[0] as usize]);
            self.duplicates.area += area_vector(&self.positions, own).norm();
        }
        self.retain(&keep);
        repeated.report(DefectKind::DuplicateTriangles, action, defects);
    }

    /// One triangle of each group of equal ones, and none of those that form walls.
    ///
    /// Of shells that are there in both directions, the outward one: a cavity and the solid that fills it give a solid.
    fn with_one_of_each<'a>(&self, groups: impl Iterator<Item = &'a [([u32; 3], u32)]>) -> OneOfEach {
        let mut keep = vec![true; self.triangles.len()];
        let mut doubled = vec![false; self.triangles.len()];
        let mut reverse: Vec<Option<usize>> = vec![None; self.triangles.len()];
        for same in groups {
            let all = || same.iter().map(|(_, triangle)| *triangle as usize);
            // A copy of a cavity's shell may have been turned as if it were the solid that fills it.
            let Some(first) = all().min_by_key(|&triangle| (self.is_turned[triangle], triangle)) else { continue };
            let is_reverse = |&other: &usize| self.is_forward(other) != self.is_forward(first);
            doubled[first] = true;
            reverse[first] = all().filter(is_reverse).find(|&other| self.is_turned[other] == self.is_turned[first]);
            all().filter(|&other| other != first).for_each(|other| keep[other] = false);
        }
        let kept: Vec<usize> = (0..keep.len()).filter(|&triangle| keep[triangle]).collect();
        let triangles: Vec<[u32; 3]> = kept.iter().map(|&triangle| self.triangles[triangle]).collect();
        let doubled: Vec<bool> = kept.iter().map(|&triangle| doubled[triangle]).collect();
        let edges = Edges::new(&triangles);
        let is_wall = edges.walls(&doubled);
        kept.iter().zip(&is_wall).filter(|(_, wall)| **wall).for_each(|(&triangle, _)| keep[triangle] = false);
        let is_inward = edges.inward_shells(&self.positions, &triangles, &doubled);
        for (&triangle, _) in kept.iter().zip(&is_inward).filter(|(_, inward)| **inward) {
            if let (true, Some(other)) = (keep[triangle], reverse[triangle]) {
                (keep[triangle], keep[other]) = (false, true);
            }
        }
        OneOfEach { keep, walls: is_wall.iter().filter(|wall| **wall).count() }
    }

    /// True if the corners of a triangle are an even permutation of ascending ones.
    fn is_forward(&self, triangle: usize) -> bool {
        let [a, b, c] = self.triangles[triangle];
        (a < b) ^ (b < c) ^ (c < a)
    }

    /// All triangles but pairs of equal ones that face opposite ways.
    fn without_opposite_pairs<'a>(&self, groups: impl Iterator<Item = &'a [([u32; 3], u32)]>) -> Vec<bool> {
        let mut keep = vec![true; self.triangles.len()];
        for same in groups {
            let (forward, backward): (Vec<u32>, Vec<u32>) =
                same.iter().map(|(_, triangle)| *triangle).partition(|&triangle| self.is_forward(triangle as usize));
            forward.iter().zip(&backward).flat_map(|(a, b)| [a, b]).for_each(|own| keep[*own as usize] = false);
        }
        keep
    }

    /// Drops triangles without area that have an open edge, and returns the number kept.
    ///
    /// The others are connected on all sides; dropping them would open the surface.
    fn drop_flat(&mut self, flat: &[bool], raw: &RawMesh, degenerate: &mut DefectTally) -> u64 {
        let is_flat =
            |clean: &Self, t: usize| flat[clean.source[t] as usize] || is_flat(&clean.positions, &clean.triangles[t]);
        let mut flat: Vec<bool> = (0..self.triangles.len()).map(|t| is_flat(self, t)).collect();
        for triangle in (0..flat.len()).filter(|&t| flat[t]) {
            degenerate.note(raw.face(self.source[triangle] as usize));
        }
        for _ in 0..PEELS_MAX {
            if !flat.contains(&true) {
                break;
            }
            let loose = Edges::new(&self.triangles).with_boundary(self.triangles.len());
            let keep: Vec<bool> = (0..flat.len()).map(|t| !(flat[t] && loose[t])).collect();
            self.retain(&keep);
            flat = (0..flat.len()).filter(|&t| keep[t]).map(|t| flat[t]).collect();
        }
        flat.iter().filter(|flat| **flat).count() as u64
    }

    fn retain(&mut self, keep: &[bool]) {
        retain(&mut self.triangles, keep);
        retain(&mut self.source, keep);
        retain(&mut self.is_turned, keep);
    }

    /// Removes vertices that no triangle uses.
    fn compact(&mut self) {
        let mut place = vec![u32::MAX; self.positions.len()];
        let mut positions = Vec::with_capacity(self.positions.len());
        for vertex in self.triangles.iter_mut().flatten() {
            let old = *vertex as usize;
            if place[old] == u32::MAX {
                place[old] = positions.len() as u32;
                positions.push(self.positions[old]);
            }
            *vertex = place[old];
        }
        self.positions = positions;
    }
}

/// Keeps the items that `keep` marks.
fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    items.retain(|_| kept.next().is_some_and(|keep| *keep));
}
