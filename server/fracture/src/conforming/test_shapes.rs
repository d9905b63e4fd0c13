//! Closed surfaces for the tests of the mesher.

use nalgebra::{Point3, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// Closed, outward surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Shape {
    pub positions: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Volume by the divergence theorem, about the first vertex.
    pub fn volume(&self) -> f64 {
        let origin = self.positions[0];
        let corner = |vertex: u32| self.positions[vertex as usize] - origin;
        self.triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
    }

    /// Diagonal of the bounding box.
    pub fn diagonal(&self) -> f64 {
        let low = self.positions.iter().fold(self.positions[0], |low, point| low.inf(point));
        let high = self.positions.iter().fold(self.positions[0], |high, point| high.sup(point));
        (high - low).norm()
    }

    pub fn map(mut self, change: impl Fn(Point3<f64>) -> Point3<f64>) -> Self {
        self.positions.iter_mut().for_each(|point| *point = change(*point));
        self
    }

    pub fn moved(self, offset: f64) -> Self {
        self.map(|point| point + Vector3::repeat(offset))
    }

    /// The surface facing inward.
    pub fn reversed(mut self) -> Self {
        self.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        self
    }

    /// Both surfaces as shells of one.
    pub fn and(mut self, other: &Self) -> Self {
        let start = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + start)));
        self
    }

    /// Points of a cubic grid and of its cell centers, for which `is_inside` holds.
    pub fn lattice(&self, spacing: f64, is_inside: impl Fn(&Point3<f64>) -> bool) -> Vec<Point3<f64>> {
        let low = self.positions.iter().fold(self.positions[0], |low, point| low.inf(point));
        let high = self.positions.iter().fold(self.positions[0], |high, point| high.sup(point));
        let counts = (high - low).map(|extent| (extent / spacing) as i32 + 1);
        let mut points = Vec::new();
        for i in 0..=counts.x {
            for j in 0..=counts.y {
                for k in 0..=counts.z {
                    let corner = low + Vector3::new(f64::from(i), f64::from(j), f64::from(k)) * spacing;
                    points.extend([corner, corner + Vector3::repeat(spacing / 2.0)].into_iter().filter(&is_inside));
                }
            }
        }
        points
    }
}

/// Sphere of radius 1 around the origin: an octahedron, refined.
pub(super) fn sphere(levels: u32) -> Shape {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut positions: Vec<Point3<f64>> =
        axes.iter().flat_map(|axis| [Point3::from(*axis), Point3::from(-axis)]).collect();
    let mut triangles = Vec::new();
    for octant in 0..8_u32 {
        let [x, y, z] = [octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2)];
        triangles.push(if octant.count_ones() % 2 == 0 { [x, y, z] } else { [y, x, z] });
    }
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[u, v]: [u32; 2]| {
                *middles.entry([u.min(v), u.max(v)]).or_insert_with(|| {
                    let middle = positions[u as usize].coords + positions[v as usize].coords;
                    positions.push(Point3::from(middle.normalize()));
                    positions.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    Shape { positions, triangles }
}

/// Torus around the z axis, with the radii 1 and `tube`.
pub(super) fn torus(around: u32, across: u32, tube: f64) -> Shape {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..around {
        for j in 0..across {
            let [u, v] = [(i, around), (j, across)].map(|(k, count)| TAU * f64::from(k) / f64::from(count));
            let radius = 1.0 + tube * v.cos();
            positions.push(Point3::new(radius * u.cos(), radius * u.sin(), tube * v.sin()));
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Shape { positions, triangles }
}

/// Surface of a set of unit cubes. `turns` chooses the diagonal of each square in turn.
pub(super) fn cubes(cells: &BTreeSet<[i32; 3]>, turns: impl Fn(usize) -> bool) -> Shape {
    let (mut shape, mut vertices) = (Shape::default(), BTreeMap::new());
    for &cell in cells {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beyond = cell;
                beyond[axis] += 2 * side - 1;
                if cells.contains(&beyond) {
                    continue;
                }
                let mut square = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut corner = cell;
                    corner[axis] += side;
                    corner[(axis + 1) % 3] += u;
                    corner[(axis + 2) % 3] += v;
                    *vertices.entry(corner).or_insert_with(|| {
                        shape.positions.push(Point3::from(corner.map(f64::from)));
                        shape.positions.len() as u32 - 1
                    })
                });
                if side == 0 {
                    square.reverse();
                }
                let [a, b, c, d] = square;
                let turned = turns(shape.triangles.len() / 2);
                shape.triangles.extend(if turned { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
            }
        }
    }
    shape
}

/// Cubes of a box.
pub(super) fn block(counts: [i32; 3]) -> BTreeSet<[i32; 3]> {
    let [x, y, z] = counts;
    (0..x * y * z).map(|k| [k % x, k / x % y, k / (x * y)]).collect()
}

/// Disc with a round hole, of the radii 1 and `hole`. Its faces are two planes of needle triangles.
pub(super) fn washer(outer: u32, inner: u32, hole: f64, height: f64) -> Shape {
    let ring = |count: u32, radius: f64, z: f64| {
        (0..count).map(move |k| {
            let angle = TAU * f64::from(k) / f64::from(count);
            Point3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
    };
    let mut shape = Shape::default();
    for z in [0.0, height] {
        shape.positions.extend(ring(outer, 1.0, z).chain(ring(inner, hole, z)));
    }
    let top = outer + inner;
    let (mut i, mut j) = (0, 0);
    while i < outer || j < inner {
        let (a, b) = (i % outer, outer + j % inner);
        let is_outer = j == inner || i < outer && (i + 1) * inner <= (j + 1) * outer;
        let next = if is_outer { (i + 1) % outer } else { outer + (j + 1) % inner };
        shape.triangles.extend([[a, b, next], [a + top, next + top, b + top]]);
        if is_outer {
            shape.triangles.extend([[a, next, a + top], [next, next + top, a + top]]);
            i += 1;
        } else {
            shape.triangles.extend([[b, b + top, next], [next, b + top, next + top]]);
            j += 1;
        }
    }
    shape
}

/// Cone of radius 1 whose triangles meet at two points: its tip and the center of its base.
pub(super) fn cone(count: u32, height: f64) -> Shape {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(count);
    let mut positions: Vec<Point3<f64>> =
        (0..count).map(|k| Point3::new(angle(k).cos(), angle(k).sin(), 0.0)).collect();
    positions.extend([Point3::new(0.0, 0.0, 0.0), Point3::new(0.0, 0.0, height)]);
    let sides = (0..count).flat_map(|k| [[k, (k + 1) % count, count + 1], [(k + 1) % count, k, count]]);
    Shape { positions, triangles: sides.collect() }
}

/// Box over [0, 1]^3 scaled by `sizes`, with 12 triangles.
pub(super) fn cuboid(sizes: [f64; 3]) -> Shape {
    cubes(&block([1; 3]), |k| k % 2 == 0).map(|point| Point3::from(point.coords.component_mul(&Vector3::from(sizes))))
}

/// Prism whose edge at the origin has the given angle, in radians.
pub(super) fn wedge(angle: f64) -> Shape {
    let side = [Point3::new(0.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0), Point3::new(angle.cos(), angle.sin(), 0.0)];
    let positions = side.into_iter().chain(side.map(|point| point + Vector3::z())).collect();
    let triangles = vec![[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
    Shape { positions, triangles }
}

/// Twisted prism that no tetrahedra fill without a further point (E. Schönhardt, 1928).
pub(super) fn schonhardt() -> Shape {
    let at = |k: u32, turn: f64, z: f64| {
        let angle = TAU * f64::from(k) / 3.0 + turn;
        Point3::new(angle.cos(), angle.sin(), z)
    };
    let positions = (0..3).map(|k| at(k, 0.0, 0.0)).chain((0..3).map(|k| at(k, TAU / 12.0, 1.0))).collect();
    let sides = (0..3).flat_map(|k| {
        let next = (k + 1) % 3;
        [[k, next, 3 + k], [next, 3 + next, 3 + k]]
    });
    let mut shape = Shape { positions, triangles: [[0, 2, 1], [3, 4, 5]].into_iter().chain(sides).collect() };
    // The other diagonal of each side bends inward.
    for k in 0..3_u32 {
        let next = (k + 1) % 3;
        let start = 2 + 2 * k as usize;
        shape.triangles[start] = [k, next, 3 + next];
        shape.triangles[start + 1] = [k, 3 + next, 3 + k];
    }
    shape
}
