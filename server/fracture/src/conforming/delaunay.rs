//! Delaunay tetrahedralization by incremental insertion.
//!
//! Based on: A. Bowyer, *Computing Dirichlet tessellations* (1981); D. F. Watson, *Computing the n-dimensional Delaunay
//! tessellation* (1981). A tetrahedron gives way if the new point is strictly inside its sphere. With exact signs this
//! keeps every tetrahedron positive, also where many points lie on one sphere: of two neighbors with one sphere, both
//! give way or neither does.

use super::error::ConformingError;
use super::insertion_order::insertion_order;
use super::predicates::{in_sphere, is_exact};
use super::tetrahedralization::{NONE, REST, Tetrahedralization, pack, unpack};
use super::work_limit::WorkLimit;
use nalgebra::{Point3, Vector3};
use std::ops::Range;

/// Points inserted between two reports of the progress.
const PROGRESS_INTERVAL: usize = 1024;
/// Longest walk to a point, in tetrahedra.
///
/// Walks through tetrahedra with one sphere may turn in a circle; all others end. A walk in the order of insertion has
/// about 10 steps.
const WALK_MAX: usize = 100_000;
/// Longest walk to a point that divides tetrahedra. Such walks may turn in circles, which a search ends.
const DIVIDED_WALK_MAX: usize = 1000;
/// Distance of the large tetrahedron's corners from the center of the points' box, relative to half its diagonal.
const CORNER_DISTANCE: f64 = 9.0;

/// Faces of the region that gives way to a point, and the region itself.
#[derive(Default)]
struct Cavity {
    tets: Vec<u32>,
    faces: Vec<(u32, usize)>,
    created: Vec<u32>,
}

impl Tetrahedralization {
    /// Delaunay tetrahedralization of `points` and the four corners of a large tetrahedron around them.
    ///
    /// `progress` receives the number of points inserted so far.
    ///
    /// # Errors
    /// [`ConformingError::DuplicatePoint`] if two points are equal, [`ConformingError::InvalidPoint`], and the errors of
    /// [`WorkLimit::check`].
    pub(super) fn delaunay(
        mut points: Vec<Point3<f64>>,
        limit: &mut WorkLimit,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Self, ConformingError> {
        check_exact(&points)?;
        let count = points.len() as u32;
        points.extend(large_tetrahedron(&points));
        let mut mesh = Self::new(points);
        mesh.allocate([count, count + 1, count + 2, count + 3]);
        mesh.insert_all(0..count, limit, progress)?;
        Ok(mesh)
    }

    /// Inserts further points into a Delaunay tetrahedralization. Their indices begin at `first`; those of the points that had
    /// them, and of all later ones, grow by the number of points.
    ///
    /// # Errors
    /// As [`Self::delaunay`].
    pub(super) fn insert_points(
        &mut self,
        first: u32,
        points: &[Point3<f64>],
        limit: &mut WorkLimit,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), ConformingError> {
        let added = self.number_points(first, points)?;
        self.insert_all(added, limit, progress)
    }

    /// Numbers further points, which no tetrahedron has yet, from `first` on; returns their indices.
    fn number_points(&mut self, first: u32, points: &[Point3<f64>]) -> Result<Range<u32>, ConformingError> {
        check_exact(points)?;
        let (place, count) = (first as usize, points.len() as u32);
        self.points.splice(place..place, points.iter().copied());
        self.incident.splice(place..place, points.iter().map(|_| NONE));
        let later = self.tets.iter_mut().flatten().filter(|corner| (first..NONE).contains(corner));
        later.for_each(|corner| *corner += count);
        Ok(first..first + count)
    }

    /// Inserts further points, numbered as by [`Self::insert_points`]. Each divides the tetrahedra that contain it, and no others.
    /// Edges that contain no point stay, but the tetrahedralization is no Delaunay one any more. There must be no constraints.
    ///
    /// # Errors
    /// As [`Self::delaunay`].
    pub(super) fn divide_at_points(
        &mut self,
        first: u32,
        points: &[Point3<f64>],
        limit: &mut WorkLimit,
    ) -> Result<(), ConformingError> {
        let mut hint = self.tets.iter().position(|corners| corners[0] != NONE).map_or(0, |tet| tet as u32);
        for vertex in self.number_points(first, points)? {
            limit.check(self)?;
            hint = self.locate(hint, vertex, DIVIDED_WALK_MAX);
            let on = (0..4).filter(|&corner| self.moved(hint, corner, vertex).1 == 0.0).collect::<Vec<_>>();
            let region = match on[..] {
                [] => Some(vec![hint]),
                [corner] => {
                    let beyond = self.neighbors[hint as usize][corner];
                    (beyond != NONE).then(|| vec![hint, beyond >> 2])
                }
                [first, second] => {
                    let [k, l] = REST[first][second].map(|corner| self.tets[hint as usize][corner]);
                    self.ring(hint, [k, l]).map(|ring| ring.tets)
                }
                _ => return Err(ConformingError::DuplicatePoint { at: *self.point(vertex) }),
            };
            // Outside of the large tetrahedron.
            let Some(region) = region else { return Err(ConformingError::InvalidPoint { point: vertex as usize }) };
            let parts = region.iter().flat_map(|&tet| (0..4).map(move |corner| (tet, corner)));
            let parts = parts.map(|(tet, corner)| self.moved(tet, corner, vertex));
            let parts: Vec<[u32; 4]> = parts.filter(|&(_, sign)| sign > 0.0).map(|(corners, _)| corners).collect();
            hint = self.replace(&region, &parts)[0];
        }
        Ok(())
    }

    /// Corners of a tetrahedron with `vertex` in place of one of them, and the sign of its volume.
    fn moved(&self, tet: u32, corner: usize, vertex: u32) -> ([u32; 4], f64) {
        let mut corners = self.tets[tet as usize];
        corners[corner] = vertex;
        (corners, self.orientation(corners[0], corners[1], corners[2], corners[3]))
    }

    /// Inserts the points of these indices, which no tetrahedron has yet.
    fn insert_all(
        &mut self,
        added: Range<u32>,
        limit: &mut WorkLimit,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), ConformingError> {
        let order = insertion_order(&self.points[added.start as usize..added.end as usize]);
        let mut hint = self.tets.iter().position(|corners| corners[0] != NONE).map_or(0, |tet| tet as u32);
        let mut cavity = Cavity::default();
        for (done, vertex) in order.iter().map(|index| added.start + index).enumerate() {
            limit.check(self)?;
            if done.is_multiple_of(PROGRESS_INTERVAL) {
                progress(done);
            }
            hint = self.locate(hint, vertex, WALK_MAX);
            let at = *self.point(vertex);
            if self.tets[hint as usize].iter().any(|&corner| *self.point(corner) == at) {
                return Err(ConformingError::DuplicatePoint { at });
            }
            hint = self.insert(vertex, hint, &mut cavity);
        }
        Ok(())
    }

    /// A tetrahedron that contains a point, found by walking from `tet`, or by search if the walk is too long.
    ///
    /// Based on: O. Devillers, S. Pion, M. Teillaud, *Walking in a triangulation* (2002).
    fn locate(&self, mut tet: u32, vertex: u32, walk_max: usize) -> u32 {
        let mut entry = NONE;
        'walk: for turn in 0..walk_max {
            let corners = self.tets[tet as usize];
            for k in 0..4 {
                let corner = (k + turn) % 4;
                if corner as u32 == entry {
                    continue;
                }
                let mut moved = corners;
                moved[corner] = vertex;
                let beyond = self.neighbors[tet as usize][corner];
                if beyond != NONE && self.orientation(moved[0], moved[1], moved[2], moved[3]) < 0.0 {
                    (tet, entry) = (beyond >> 2, beyond & 3);
                    continue 'walk;
                }
            }
            return tet;
        }
        (0..self.tets.len() as u32).find(|&tet| self.contains(tet, vertex)).unwrap_or(tet)
    }

    /// Returns true if a point lies in a tetrahedron or on its boundary.
    fn contains(&self, tet: u32, vertex: u32) -> bool {
        let corners = self.tets[tet as usize];
        corners[0] != NONE && (0..4).all(|corner| self.moved(tet, corner, vertex).1 >= 0.0)
    }

    /// Inserts a point that lies in `tet`; returns one of the tetrahedra around it.
    fn insert(&mut self, vertex: u32, tet: u32, cavity: &mut Cavity) -> u32 {
        self.find_cavity(vertex, tet, cavity);
        cavity.created.clear();
        for &(tet, corner) in &cavity.faces {
            let mut corners = self.tets[tet as usize];
            corners[corner] = vertex;
            let outer = self.neighbors[tet as usize][corner];
            let created = self.allocate(corners);
            debug_assert!(self.orientation(corners[0], corners[1], corners[2], corners[3]) > 0.0);
            self.link(pack(created, corner), outer);
            self.neighbors[tet as usize][corner] = pack(created, corner);
            cavity.created.push(created);
        }
        for (&(tet, corner), &created) in cavity.faces.iter().zip(&cavity.created) {
            for k in 0..4 {
                if k != corner && self.neighbors[created as usize][k] == NONE {
                    let other = self.across_cavity(tet, corner, k);
                    self.link(pack(created, k), other);
                }
            }
        }
        cavity.tets.iter().for_each(|&tet| self.release(tet));
        cavity.created[0]
    }

    /// Collects the tetrahedra whose spheres contain a point, marks them, and lists the faces around them.
    fn find_cavity(&mut self, vertex: u32, tet: u32, cavity: &mut Cavity) {
        let at = *self.point(vertex);
        cavity.tets.clear();
        cavity.faces.clear();
        self.clear_marks();
        self.mark(tet);
        cavity.tets.push(tet);
        let mut next = 0;
        while let Some(&tet) = cavity.tets.get(next) {
            next += 1;
            self.count_steps(1);
            for corner in 0..4 {
                let beyond = self.neighbors[tet as usize][corner];
                if beyond != NONE && self.is_marked(beyond >> 2) {
                    continue;
                }
                let corners = |tet: u32| self.tets[tet as usize].map(|corner| &self.points[corner as usize]);
                if beyond != NONE && in_sphere(corners(beyond >> 2), &at) > 0.0 {
                    self.mark(beyond >> 2);
                    cavity.tets.push(beyond >> 2);
                } else {
                    cavity.faces.push((tet, corner));
                }
            }
        }
    }

    /// Face of the new tetrahedron that shares an edge of the cavity's boundary with the one at (`tet`, `pivot`).
    ///
    /// The edge is that without the corners `pivot` and `apex`. Boundary faces name their new tetrahedron as neighbor.
    fn across_cavity(&self, tet: u32, pivot: usize, apex: usize) -> u32 {
        let (mut current, mut pivot, mut through) = (tet, pivot, apex);
        loop {
            let (next, entry) = unpack(self.neighbors[current as usize][through]);
            if !self.is_marked(next) {
                return pack(next, pivot);
            }
            // The edge and the pivot span the face crossed. Beyond it, the face without the pivot continues the turn.
            let pivot_vertex = self.tets[current as usize][pivot];
            let Some(turned) = self.corner(next, pivot_vertex) else { return NONE };
            (current, pivot, through) = (next, entry, turned);
        }
    }
}

/// Refuses points at which signs are not exact.
fn check_exact(points: &[Point3<f64>]) -> Result<(), ConformingError> {
    match points.iter().position(|point| !is_exact(point)) {
        Some(point) => Err(ConformingError::InvalidPoint { point }),
        None => Ok(()),
    }
}

/// Corners of a positive regular tetrahedron around all points.
fn large_tetrahedron(points: &[Point3<f64>]) -> [Point3<f64>; 4] {
    let first = points.first().copied().unwrap_or_else(Point3::origin);
    let (low, high) = points.iter().fold((first, first), |(low, high), point| (low.inf(point), high.sup(point)));
    let center = nalgebra::center(&low, &high);
    let diagonal = (high - low).norm();
    let reach = if diagonal > 0.0 { CORNER_DISTANCE * diagonal / 2.0 } else { 1.0 };
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0]]
        .map(|corner| center + Vector3::from(corner) * reach)
}

#[cfg(test)]
mod tests {
    use super::super::tetrahedralization::FACES;
    use super::*;
    use crate::cancel_token::CancelToken;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn delaunay(points: Vec<Point3<f64>>) -> Result<Tetrahedralization, ConformingError> {
        let token = CancelToken::default();
        Tetrahedralization::delaunay(points, &mut WorkLimit::new(1000, u64::MAX, &token), &mut |_| ())
    }

    /// Checks the tetrahedralization of the points, and that of the same points of which some are inserted later.
    fn check_delaunay(mut points: Vec<Point3<f64>>) -> Result<(), TestCaseError> {
        // The large tetrahedron must hold the later points, so those with extreme coordinates come first.
        for axis in 0..3 {
            let last = points.len() - 1;
            points[(2 * axis).min(last)..].sort_by(|a, b| a[axis].total_cmp(&b[axis]));
            points.swap((2 * axis + 1).min(last), last);
        }
        let first = points.len().min(6);
        let later = first..points.len().midpoint(first);
        let token = CancelToken::default();
        let mut limit = WorkLimit::new(1000, u64::MAX, &token);
        let earlier = [&points[..first], &points[later.end..]].concat();
        let mut grown = Tetrahedralization::delaunay(earlier, &mut limit, &mut |_| ()).unwrap();
        grown.insert_points(first as u32, &points[later], &mut limit, &mut |_| ()).unwrap();
        prop_assert_eq!(&grown.points[..points.len()], &points[..]);
        check_mesh(&grown)?;
        check_mesh(&delaunay(points).unwrap())
    }

    fn check_mesh(mesh: &Tetrahedralization) -> Result<(), TestCaseError> {
        check_topology(mesh)?;
        for (tet, corners) in mesh.tets.iter().enumerate().filter(|(_, corners)| corners[0] != NONE) {
            for beyond in mesh.neighbors[tet].into_iter().filter(|&beyond| beyond != NONE) {
                let (other, back) = unpack(beyond);
                let apex = mesh.point(mesh.tets[other as usize][back]);
                prop_assert!(in_sphere(corners.map(|corner| mesh.point(corner)), apex) <= 0.0);
            }
        }
        Ok(())
    }

    fn check_topology(mesh: &Tetrahedralization) -> Result<(), TestCaseError> {
        for (tet, corners) in mesh.tets.iter().enumerate().filter(|(_, corners)| corners[0] != NONE) {
            prop_assert!(mesh.orientation(corners[0], corners[1], corners[2], corners[3]) > 0.0);
            for (corner, face) in FACES.into_iter().enumerate() {
                let beyond = mesh.neighbors[tet][corner];
                if beyond == NONE {
                    continue;
                }
                let (other, back) = unpack(beyond);
                prop_assert_eq!(mesh.neighbors[other as usize][back], pack(tet as u32, corner));
                let mut face = face.map(|k| corners[k]);
                let mut same = mesh.face(other, back);
                face.sort_unstable();
                same.sort_unstable();
                prop_assert_eq!(face, same);
            }
        }
        let used = mesh.incident.iter().all(|&tet| tet != NONE);
        prop_assert!(used);
        Ok(())
    }

    fn edges(mesh: &Tetrahedralization) -> BTreeSet<[u32; 2]> {
        let tets = mesh.tets.iter().filter(|corners| corners[0] != NONE);
        tets.flat_map(|corners| (0..4).flat_map(move |i| (0..4).map(move |k| [corners[i], corners[k]]))).collect()
    }

    proptest! {
        #[test]
        fn divided_tetrahedra_fill_the_same_region_and_keep_all_other_edges(
            grid in prop::collection::btree_set(prop::array::uniform3(0..5_i32), 20..100),
            random in prop::collection::vec(prop::array::uniform3(0.5..3.5_f64), 1..20),
        ) {
            // Points of a grid lie on edges and faces between other ones.
            let mut points: Vec<Point3<f64>> = grid.into_iter().map(|p| Point3::from(p.map(f64::from))).collect();
            points.extend(random.into_iter().map(Point3::from));
            let later = points.split_off(points.len() / 2);
            let first = points.len() as u32 / 2;
            let token = CancelToken::default();
            let mut limit = WorkLimit::new(1000, u64::MAX, &token);
            let mut mesh = Tetrahedralization::delaunay(points, &mut limit, &mut |_| ()).unwrap();
            let before = edges(&mesh);
            let added = later.len() as u32;
            mesh.divide_at_points(first, &later, &mut limit).unwrap();
            check_topology(&mesh)?;
            let after = edges(&mesh);
            let renumbered = |vertex: u32| if vertex < first { vertex } else { vertex + added };
            for [a, b] in before.into_iter().map(|edge| edge.map(renumbered)).filter(|[a, b]| a < b) {
                let holds = |point: &Point3<f64>| {
                    let (from, to) = (*mesh.point(a), *mesh.point(b));
                    let along = (point - from).dot(&(to - from)) / (to - from).norm_squared();
                    (0.0..1.0).contains(&along) && ((to - from) * along - (point - from)).norm() < 1e-9
                };
                prop_assert!(after.contains(&[a, b]) || later.iter().any(holds), "{a} {b}");
            }
        }

        #[test]
        fn spheres_of_grids_and_of_random_points_are_empty(
            grid in prop::collection::btree_set(prop::array::uniform3(0..6_i32), 1..120),
            random in prop::collection::vec(prop::array::uniform3(0.0..1.0_f64), 1..200),
            offset in prop_oneof![Just(0.0), Just(1e6)],
        ) {
            check_delaunay(grid.into_iter().map(|p| Point3::from(p.map(|x| f64::from(x) * 0.1 + offset))).collect())?;
            check_delaunay(random.into_iter().map(|p| Point3::from(p.map(|x| x + offset))).collect())?;
        }
    }

    #[test]
    fn equal_points_are_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]].map(Point3::from).to_vec();
        assert_eq!(delaunay(points).unwrap_err(), ConformingError::DuplicatePoint { at: Point3::origin() });
    }

    #[test]
    fn a_point_that_equals_a_corner_is_refused() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from).to_vec();
        let mut mesh = delaunay(points).unwrap();
        let token = CancelToken::default();
        let result = mesh.divide_at_points(4, &[Point3::origin()], &mut WorkLimit::new(1000, u64::MAX, &token));
        assert_eq!(result.unwrap_err(), ConformingError::DuplicatePoint { at: Point3::origin() });
    }

    #[test]
    fn a_canceled_token_stops_the_insertion() {
        let token = CancelToken::default();
        token.cancel();
        let mut limit = WorkLimit::new(1, u64::MAX, &token);
        let result = Tetrahedralization::delaunay(vec![Point3::origin()], &mut limit, &mut |_| ());
        assert!(matches!(result, Err(ConformingError::Canceled(_))));
    }

    #[test]
    fn points_on_two_skew_lines_exceed_the_limit_of_tetrahedra() {
        // Every two points on one line and every two on the other form a tetrahedron.
        let points: Vec<Point3<f64>> = (0..200)
            .map(|k| f64::from(k) / 200.0)
            .flat_map(|x| [Point3::new(x, 0.0, 0.0), Point3::new(0.0, x, 1.0)])
            .collect();
        let result = delaunay(points);
        assert_eq!(result.unwrap_err(), ConformingError::TooManyTets { tets_max: 16_000 });
    }

    #[test]
    fn a_long_walk_ends_with_a_search() {
        let points: Vec<Point3<f64>> =
            (0..100).map(|k| Point3::new(f64::from(k).sin(), f64::from(k * k).sin(), f64::from(k))).collect();
        let mesh = delaunay(points).unwrap();
        let near = mesh.incident[7];
        for vertex in 0..100 {
            for walk_max in [0, 1, 1000] {
                let found = mesh.locate(near, vertex, walk_max);
                assert!(mesh.corner(found, vertex).is_some());
            }
        }
    }
}
