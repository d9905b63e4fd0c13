//! Crack sheets: open triangle meshes along which an object is already cracked.

use super::closest;
use super::defect::DefectTally;
use super::open_edges::OpenEdges;
use super::repair::{DisjointSets, is_flat};
use super::tree::{BoundingBox, TriangleTree};
use super::{Defect, DefectKind, InsideTest, LocalFrame, RawMesh, SurfaceError};
use nalgebra::Point3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Largest local coordinate of a sheet's vertex. Distances to vertices farther away would lose their digits.
const FAR: f64 = 1e6;

/// Existing cracks of an object: triangles in its local frame.
///
/// Orientation does not matter: each triangle is stored once, with its corners in lexicographic order.
#[derive(Clone, Debug, Default)]
pub struct CrackSheets {
    tree: TriangleTree,
    /// Open edges of the sheets.
    pub(super) rim: OpenEdges,
    triangles: Vec<[Point3<f64>; 3]>,
    /// Face of the input file that each triangle was cut from.
    faces: Vec<u64>,
    /// Sheet of each triangle, named by its lowest triangle. Triangles that share a vertex belong to one sheet.
    sheets: Vec<u32>,
    /// Defects of the input.
    pub defects: Vec<Defect>,
}

/// Coordinates of a position as bit patterns, usable as a hash key.
fn bits(point: &Point3<f64>) -> [u64; 3] {
    [point.x, point.y, point.z].map(f64::to_bits)
}

impl CrackSheets {
    /// Builds the sheets from a mesh file, in the frame of the object. Drops degenerate and duplicate triangles.
    ///
    /// # Errors
    /// [`RawMesh::check`]'s, [`SurfaceError::FarVertex`], [`SurfaceError::AllDegenerate`].
    pub fn new(raw: &RawMesh, frame: &LocalFrame) -> Result<Self, SurfaceError> {
        raw.check()?;
        // Adding 0 turns −0 into 0, so that equal positions have equal bits.
        let local = |point: &Point3<f64>| frame.to_local(point).map(|x| x + 0.0);
        let places: Vec<Point3<f64>> = raw.positions_m.iter().map(local).collect();
        let near = |place: &Point3<f64>| place.coords.amax() <= FAR;
        if let Some(vertex) = places.iter().position(|place| !near(place)) {
            return Err(SurfaceError::FarVertex { vertex: vertex as u64 });
        }
        let (mut triangles, mut faces, mut seen) = (Vec::new(), Vec::new(), HashSet::new());
        let (mut degenerate, mut repeated) = (DefectTally::default(), DefectTally::default());
        for (triangle, corners) in raw.triangles.iter().enumerate() {
            let mut own = corners.map(|vertex| places[vertex as usize]);
            own.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
            if is_flat(&own, &[0, 1, 2]) {
                degenerate.note(raw.face(triangle));
            } else if !seen.insert(own.each_ref().map(bits)) {
                repeated.note(raw.face(triangle));
            } else {
                triangles.push(own);
                faces.push(raw.face(triangle));
            }
        }
        if triangles.is_empty() {
            return Err(SurfaceError::AllDegenerate);
        }
        let mut defects = Vec::new();
        degenerate.report(DefectKind::DegenerateTriangles, "left out of the cracks", &mut defects);
        repeated.report(DefectKind::DuplicateTriangles, "duplicates dropped from the cracks", &mut defects);
        Ok(Self {
            tree: TriangleTree::new(&triangles),
            rim: OpenEdges::new(&triangles),
            sheets: sheets(&triangles),
            triangles,
            faces,
            defects,
        })
    }

    /// Corners of each triangle, local.
    pub fn triangles(&self) -> &[[Point3<f64>; 3]] {
        &self.triangles
    }

    /// Number of sheets: sets of triangles that are connected by shared corners.
    pub fn count(&self) -> u64 {
        self.sheets.iter().enumerate().filter(|(triangle, sheet)| **sheet == *triangle as u32).count() as u64
    }

    /// Lowest and highest corner of the box around all triangles, local.
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let bounds = BoundingBox::of(self.triangles.iter().flatten());
        (bounds.low, bounds.high)
    }

    /// Area of all triangles, inside the object or not; local (squared diagonals).
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
    }

    /// Distance from a local point to the nearest triangle; local.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        closest::nearest(&self.tree, point).0.sqrt()
    }

    /// Reports the sheets, if any, that cut nothing: none of `places` lies in their slots of
    /// half width `half`. All local.
    pub fn idle(&self, inside: &InsideTest, places: &[Point3<f64>], half: f64) -> Option<Defect> {
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (triangle, &sheet) in self.sheets.iter().enumerate() {
            members.entry(sheet).or_default().push(triangle);
        }
        let cuts = |members: &Vec<usize>| {
            let triangles: Vec<[Point3<f64>; 3]> = members.iter().map(|&triangle| self.triangles[triangle]).collect();
            let bounds = BoundingBox::of(triangles.iter().flatten());
            let near = |place: &&Point3<f64>| bounds.distance_squared(place) <= half * half;
            let own = Self {
                tree: TriangleTree::new(&triangles),
                rim: OpenEdges::new(&triangles),
                triangles,
                ..Self::default()
            };
            places.iter().filter(near).any(|place| own.slot_depth(inside, place, half) > 0.0)
        };
        let mut tally = DefectTally::default();
        members.values().filter(|members| !cuts(members)).for_each(|members| tally.note(self.faces[members[0]]));
        let mut defects = Vec::new();
        tally.report(
            DefectKind::IdleCrack,
            "none: outside of the object, or smaller than the lattice resolves",
            &mut defects,
        );
        defects.pop()
    }
}

/// Sheet of each triangle, named by its lowest triangle.
fn sheets(triangles: &[[Point3<f64>; 3]]) -> Vec<u32> {
    let (mut sets, mut first) = (DisjointSets::new(triangles.len()), HashMap::new());
    for (triangle, corners) in triangles.iter().enumerate() {
        for corner in corners {
            let other = *first.entry(bits(corner)).or_insert(triangle as u32);
            sets.join(triangle as u32, other);
        }
    }
    (0..triangles.len() as u32).map(|triangle| sets.root(triangle)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Surface, shapes};

    const FRAME: LocalFrame = LocalFrame { center_m: Point3::new(1.0, 0.0, 0.0), diagonal_m: 2.0 };

    /// Two separate parallel squares of two triangles each.
    fn squares() -> RawMesh {
        let square = |z: f64| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, z));
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        RawMesh::new([square(0.0), square(3.0)].concat(), triangles)
    }

    fn refused(change: impl Fn(&mut RawMesh)) -> SurfaceError {
        let mut raw = squares();
        change(&mut raw);
        CrackSheets::new(&raw, &FRAME).unwrap_err()
    }

    #[test]
    fn sides_and_repetitions_do_not_matter() {
        let (raw, mut turned) = (squares(), squares());
        turned.triangles.iter_mut().for_each(|[a, b, c]| (*a, *b, *c) = (*b, *a, *c));
        turned.triangles.extend(raw.triangles.clone());
        let [one, other] = [&raw, &turned].map(|raw| CrackSheets::new(raw, &FRAME).unwrap());
        assert_eq!(one.triangles, other.triangles);
        assert!((one.area() - 0.5).abs() < 1e-15 && one.defects.is_empty());
        assert_eq!((other.defects[0].kind, other.defects[0].count), (DefectKind::DuplicateTriangles, 4));
        assert!((one.distance(&Point3::new(-0.25, 0.25, 0.3)) - 0.3).abs() < 1e-15);
    }

    #[test]
    fn sheets_that_cut_nothing_are_named() {
        let surface = Surface::repair(shapes::cuboid([2.0; 3])).unwrap();
        let inside = InsideTest::new(&surface);
        let mut raw = squares();
        let tiny = [[0.0, 0.0], [0.02, 0.0], [0.0, 0.02]].map(|[x, y]| Point3::new(x, y, 0.5));
        raw.positions_m.extend(tiny);
        raw.triangles.push([8, 9, 10]);
        let sheets = CrackSheets::new(&raw, &surface.frame).unwrap();
        let places = [[0.2, 0.3, 0.05], [0.005, 0.005, 0.53], [0.3, 0.3, 1.0]]
            .map(|at| Point3::from(at) / surface.frame.diagonal_m);
        let named = sheets.idle(&inside, &places, 0.02).unwrap();
        assert_eq!((named.kind, named.count, named.first_index), (DefectKind::IdleCrack, 2, 2));
        assert_eq!(sheets.idle(&inside, &places[1..], 0.01).unwrap().count, 3);
    }

    #[test]
    fn invalid_sheets_are_rejected_by_name() {
        assert!(matches!(refused(|raw| raw.triangles.clear()), SurfaceError::Empty { .. }));
        assert!(matches!(refused(|raw| raw.positions_m[5].x = 1e9), SurfaceError::FarVertex { vertex: 5 }));
        assert!(matches!(refused(|raw| raw.triangles[1][2] = 8), SurfaceError::VertexOutOfBounds { face: 1, .. }));
        let flat = |raw: &mut RawMesh| raw.triangles.iter_mut().for_each(|corners| corners[1] = corners[0]);
        assert!(matches!(refused(flat), SurfaceError::AllDegenerate));
        let mut raw = squares();
        raw.triangles[2] = [4, 4, 5];
        let sheets = CrackSheets::new(&raw, &FRAME).unwrap();
        let degenerate = &sheets.defects[0];
        assert_eq!((degenerate.kind, degenerate.first_index), (DefectKind::DegenerateTriangles, 2));
    }
}
