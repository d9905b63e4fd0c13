//! Smallest plane section through a point of a body: the crack that costs the least.

use crate::lattice::{Lattice, NO_TET, NodeStars};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{PI, TAU};

/// Angles, in radians, by which the normals of the other planes are tilted from the first.
const TILTS: [f64; 2] = [PI / 12.0, PI / 6.0];

/// Number of normals per tilt.
const NORMALS_PER_TILT: usize = 6;

/// Number of planes that are tried.
pub const PLANES: usize = 1 + TILTS.len() * NORMALS_PER_TILT;

/// Plane section of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSection {
    /// Unit normal of the plane.
    pub normal: Vector3<f64>,
    /// Area of the part at the point, local.
    pub area: f64,
}

/// Lattice with the tables that a section needs.
#[derive(Clone, Copy)]
pub struct SectionLattice<'a> {
    /// The lattice.
    pub lattice: &'a Lattice,
    /// Volumes of its tetrahedra.
    pub volumes: &'a [f64],
    /// Neighbors of its tetrahedra.
    pub neighbors: &'a [[u32; 4]],
    /// Tetrahedra around its nodes.
    pub stars: &'a NodeStars,
}

/// Search for small sections, and its memory.
pub struct SectionSearch<'a> {
    tables: SectionLattice<'a>,
    marks: Marks,
}

/// Marks of tetrahedra, shared by all planes: those without the current number are unmarked.
struct Marks {
    current: u32,
    tets: Vec<u32>,
}

/// One plane through a node, whose distance is exactly zero.
struct Plane<'a> {
    normal: Vector3<f64>,
    place: Point3<f64>,
    nodes: &'a [Point3<f64>],
}

/// `first` and twelve normals around it, in two cones.
pub fn normals_around(first: Vector3<f64>) -> [Vector3<f64>; PLANES] {
    let axis = Vector3::ith(first.iamin(), 1.0);
    let side = first.cross(&axis).normalize();
    let other = first.cross(&side);
    std::array::from_fn(|index| {
        let Some(index) = index.checked_sub(1) else { return first };
        let (tilt, turn) = (TILTS[index / NORMALS_PER_TILT], index % NORMALS_PER_TILT);
        let angle = TAU * turn as f64 / NORMALS_PER_TILT as f64;
        first * tilt.cos() + (side * angle.cos() + other * angle.sin()) * tilt.sin()
    })
}

/// As many normals as [`normals_around`] at right angles to `axis`, which is nearly a unit vector.
pub fn normals_across(axis: Vector3<f64>) -> [Vector3<f64>; PLANES] {
    let side = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    let other = axis.normalize().cross(&side);
    std::array::from_fn(|index| {
        let angle = PI * index as f64 / PLANES as f64;
        side * angle.cos() + other * angle.sin()
    })
}

impl<'a> SectionSearch<'a> {
    /// A search in `tables`.
    pub fn new(tables: SectionLattice<'a>) -> Self {
        let SectionLattice { lattice, .. } = tables;
        Self { tables, marks: Marks { current: 0, tets: vec![0; lattice.tets.len()] } }
    }

    /// The smallest section by planes through `node` with these `normals`, of those with at least `volume_min` on both
    /// sides; `None` if there is none.
    ///
    /// A section is the part of the plane within the body that is connected to the node: other limbs are not cut. Its area
    /// is that of the lattice. Of equal sections, the first is returned.
    pub fn smallest(&mut self, node: u32, normals: &[Vector3<f64>], volume_min: f64) -> Option<PlaneSection> {
        let Self { tables, marks } = self;
        let (mut best, mut cut): (Option<PlaneSection>, _) = (None, Vec::new());
        for normal in normals {
            let place = tables.lattice.nodes[node as usize];
            let plane = Plane { normal: *normal, place, nodes: &tables.lattice.nodes };
            let most = best.map_or(f64::INFINITY, |best: PlaneSection| best.area);
            marks.current += 1;
            let Some(area) = tables.cut((&plane, node), most, marks, &mut cut) else { continue };
            if [true, false].into_iter().all(|side| tables.exceeds(&plane, (&cut, side), volume_min, marks)) {
                best = Some(PlaneSection { normal: *normal, area });
            }
        }
        best
    }
}

impl SectionLattice<'_> {
    /// Collects the tetrahedra of the part of the plane that is connected to its node; returns the area of the part.
    ///
    /// `None` if it is not below `most`, or there is none.
    fn cut(&self, (plane, node): (&Plane<'_>, u32), most: f64, marks: &mut Marks, cut: &mut Vec<u32>) -> Option<f64> {
        cut.clear();
        let (mut area, mut next) = (0.0, 0);
        for &tet in self.stars.of(node) {
            if is_crossed(0b1111, positive(&plane.distances(&self.lattice.tets[tet as usize]))) {
                marks.tets[tet as usize] = marks.current;
                cut.push(tet);
            }
        }
        while let Some(&tet) = cut.get(next) {
            next += 1;
            let distances = plane.distances(&self.lattice.tets[tet as usize]);
            area += section_area(self.volumes[tet as usize], distances);
            if area >= most {
                return None;
            }
            let signs = positive(&distances);
            for (face, &other) in self.neighbors[tet as usize].iter().enumerate() {
                // Face k is opposite corner k.
                let corners = 0b1111 & !(1 << face);
                if is_crossed(corners, signs) && other != NO_TET && marks.tets[other as usize] != marks.current {
                    marks.tets[other as usize] = marks.current;
                    cut.push(other);
                }
            }
        }
        (area > 0.0).then_some(area)
    }

    /// True if at least `volume_min` lies on one side of a cut and is connected to it.
    fn exceeds(&self, plane: &Plane<'_>, (cut, side): (&[u32], bool), volume_min: f64, marks: &mut Marks) -> bool {
        // The plane divides cut tetrahedra about evenly.
        let mut volume = 0.5 * cut.iter().map(|tet| self.volumes[*tet as usize]).sum::<f64>();
        let (mut reached, mut next) = (cut.to_vec(), 0);
        while let Some(&tet) = reached.get(next) {
            next += 1;
            for &other in &self.neighbors[tet as usize] {
                if other == NO_TET || marks.tets[other as usize] == marks.current {
                    continue;
                }
                let signs = positive(&plane.distances(&self.lattice.tets[other as usize]));
                if signs == if side { 0b1111 } else { 0 } {
                    marks.tets[other as usize] = marks.current;
                    reached.push(other);
                    volume += self.volumes[other as usize];
                    if volume >= volume_min {
                        return true;
                    }
                }
            }
        }
        false
    }
}

impl Plane<'_> {
    /// Distances of the corners of a tetrahedron.
    fn distances(&self, corners: &[u32; 4]) -> [f64; 4] {
        corners.map(|corner| self.normal.dot(&(self.nodes[corner as usize] - self.place)))
    }
}

/// Bits of the corners on the positive side, to which corners in the plane belong.
fn positive(distances: &[f64; 4]) -> u32 {
    (0..4).map(|corner| u32::from(distances[corner] >= 0.0) << corner).sum()
}

/// True if the plane separates the corners with these bits.
fn is_crossed(corners: u32, signs: u32) -> bool {
    signs & corners != 0 && signs & corners != corners
}

/// Area of the section of a tetrahedron of this volume whose corners have these distances from a plane.
///
/// It is the derivative of the volume beyond the plane by its shift. Beyond it lies V a³/((a − b)(a − c)(a − d)) if a is the
/// distance of the only corner there.
fn section_area(volume: f64, distances: [f64; 4]) -> f64 {
    let signs = positive(&distances);
    let alone = |signs: u32| signs.trailing_zeros() as usize;
    let corner = |index: usize| {
        let own = distances[index];
        let others = (0..4).filter(|other| *other != index).map(|other| own - distances[other]);
        3.0 * volume * own * own / others.product::<f64>().abs()
    };
    match signs.count_ones() {
        1 => corner(alone(signs)),
        3 => corner(alone(!signs & 0b1111)),
        2 => {
            let first = alone(signs);
            let second = alone(signs & !(1 << first));
            let [third, fourth] = [alone(!signs & 0b1111), 31 - (!signs & 0b1111).leading_zeros() as usize];
            let [a, b, c, d] = [first, second, third, fourth].map(|index| distances[index]);
            3.0 * volume * (c * d * (a + b) - (c + d) * a * b) / ((a - c) * (a - d) * (b - c) * (b - d))
        }
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::block;

    fn nearest(lattice: &Lattice, point: [f64; 3]) -> u32 {
        let distance = |node: &usize| (lattice.nodes[*node] - Point3::from(point)).norm();
        (0..lattice.nodes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap() as u32
    }

    fn smallest(lattice: &Lattice, point: [f64; 3], normal: Vector3<f64>, volume_min: f64) -> Option<PlaneSection> {
        smallest_of(lattice, point, &normals_around(normal), volume_min)
    }

    fn smallest_of(
        lattice: &Lattice,
        point: [f64; 3],
        normals: &[Vector3<f64>],
        volume_min: f64,
    ) -> Option<PlaneSection> {
        let (neighbors, stars) = (lattice.neighbors(), lattice.stars());
        let volumes: Vec<f64> = (0..lattice.tets.len()).map(|tet| lattice.tet_volume(tet)).collect();
        let tables = SectionLattice { lattice, volumes: &volumes, neighbors: &neighbors, stars: &stars };
        SectionSearch::new(tables).smallest(nearest(lattice, point), normals, volume_min)
    }

    #[test]
    fn a_tetrahedron_has_the_sections_of_geometry() {
        // Corners at the origin and the unit points, volume 1/6; planes z = h and x + y = h.
        for h in [0.1_f64, 0.5, 0.9] {
            let found = section_area(1.0 / 6.0, [-h, -h, -h, 1.0 - h]);
            assert!((found - 0.5 * (1.0 - h).powi(2)).abs() < 1e-12);
            let scale = std::f64::consts::SQRT_2;
            let found = section_area(1.0 / 6.0, [-h, 1.0 - h, 1.0 - h, -h].map(|distance| distance / scale));
            assert!((found - scale * h * (1.0 - h)).abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn the_smallest_section_of_a_beam_is_its_cross_section() {
        let lattice = block([24, 4, 6], 0.05);
        for point in [[0.0, 0.1, 0.0], [0.21, 0.0, 0.15], [0.33, 0.1, 0.15]] {
            let tilted = Vector3::new(1.0, 0.1, -0.05).normalize();
            for normal in [Vector3::x(), tilted] {
                let found = smallest(&lattice, point, normal, 1e-3).unwrap();
                assert!((0.06 - 1e-9..0.0605).contains(&found.area), "{point:?}: {found:?}");
            }
        }
        // A section near the end would leave less than the smallest piece.
        let end = [0.58, 0.1, 0.0];
        assert!(smallest(&lattice, end, Vector3::x(), 0.0).is_some());
        assert_eq!(smallest(&lattice, end, Vector3::x(), 0.01), None);
        // Through the middle of the last cells: of the 24 tetrahedra of each, 8 are beyond, and half of the other 16 counts.
        let of = |volume_min: f64| smallest_of(&lattice, [0.575, 0.025, 0.025], &[Vector3::x()], volume_min);
        assert!(of(0.0019).is_some() && of(0.0021).is_none());
    }

    #[test]
    fn other_limbs_are_not_cut() {
        // Two legs under a table: the plane y = const through one of them crosses both.
        let mut lattice = block([12, 8, 3], 0.1);
        let center =
            |nodes: &[u32; 4]| nodes.iter().map(|node| lattice.nodes[*node as usize].coords).sum::<Vector3<f64>>();
        let tets = lattice.tets.iter().filter(|nodes| {
            let middle = center(nodes) / 4.0;
            middle.y > 0.1 || middle.x.abs() > 0.3
        });
        lattice.tets = tets.copied().collect();
        let found = smallest(&lattice, [-0.6, -0.2, 0.0], Vector3::y(), 1e-3).unwrap();
        assert!((found.area - 0.3 * 0.3).abs() < 1e-9, "{found:?}");
    }
}
