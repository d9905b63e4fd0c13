//! Effects that are computed while a result is written: normals, texture coordinates, bonds, debris.

use super::faces::{Face, faces};
use super::meshes::FractureMeshes;
use super::rows::BondRow;
use crate::pipeline::workspace::body_meshes::BodyMeshes;
use crate::random::RandomStream;
use crate::scene::EffectKind;
use crate::tessellation::{HostFrame, MeterFrame, RunRange, Tessellation};
use nalgebra::{Point3, Vector3};

/// Triangles of a crack face per point of debris.
const TRIANGLES_PER_POINT: usize = 4;

/// Smallest and largest size of debris, in spacings of the crack lattice.
const DEBRIS_SPACINGS: [f64; 2] = [0.1, 1.0];

/// Number of the first random stream for debris.
const DEBRIS_STREAM: u64 = 0x6465_6272_6973_0000;

/// A source of dust and chips on a crack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DebrisRow {
    /// Fragment on whose face the point lies, the lower id of the two.
    pub fragment: u32,
    /// Fragment on the other side.
    pub neighbor: u32,
    /// Position relative to the fragment's center of mass, m.
    pub position_m: Vector3<f64>,
    /// Unit normal, out of the fragment.
    pub normal: Vector3<f64>,
    /// Diameter, m.
    pub size_m: f64,
}

/// True if this side of the crack, the lower fragment's, carries its debris and bonds.
fn is_lower(run: &RunRange) -> bool {
    run.neighbor.is_some_and(|neighbor| run.fragment < neighbor)
}

impl FractureMeshes {
    /// Number of bonds; 0 without the effect.
    pub fn bond_count(&self) -> usize {
        let cracks = |body: &BodyMeshes| body.tessellation.runs().iter().filter(|run| is_lower(run)).count();
        match self.effects.has(EffectKind::Bonds) {
            true => self.bodies.iter().map(cracks).sum::<usize>() + self.world.len(),
            false => 0,
        }
    }

    /// Number of points of debris; 0 without the effect.
    pub fn debris_count(&self) -> usize {
        let points = |run: &RunRange| run.triangles.len().div_ceil(TRIANGLES_PER_POINT);
        let cracks = |body: &BodyMeshes| -> usize {
            body.tessellation.runs().iter().filter(|run| is_lower(run)).map(points).sum()
        };
        match self.effects.has(EffectKind::Debris) {
            true => self.bodies.iter().map(cracks).sum(),
            false => 0,
        }
    }

    /// Writes the normals of all vertices, in order: area-weighted means over the triangles of the vertex in its run.
    ///
    /// Writes at most `out.len()` normals.
    pub fn normals(&self, out: &mut [[f32; 3]]) {
        self.normals_for(&MeterFrame, out);
    }

    /// [`Self::normals`] along the axes of `host`.
    pub fn normals_for(&self, host: &impl HostFrame, out: &mut [[f32; 3]]) {
        self.each_run(out, |tessellation, run, out| {
            let mut sums = vec![Vector3::zeros(); out.len()];
            for (triangle, face) in tessellation.run_triangles(run).zip(faces(tessellation, run)) {
                triangle.iter().for_each(|&vertex| sums[vertex as usize] += face.area);
            }
            for (out, sum) in out.iter_mut().zip(&sums) {
                *out = host.direction(sum.try_normalize(0.0).unwrap_or(Vector3::z()));
            }
        });
    }

    /// Writes the texture coordinates of all vertices, m; zero outside cracks.
    ///
    /// They are coordinates in the mean plane of the crack, equal on both sides.
    pub fn uvs(&self, out: &mut [[f32; 2]]) {
        let meter = self.transform.meters_per_unit;
        self.each_run(out, |tessellation, run, out| {
            if !run.crack {
                return out.fill([0.0; 2]);
            }
            let own: Vector3<f64> = faces(tessellation, run).map(|face| face.area).sum();
            let [u, v] = plane(if run.neighbor.is_none_or(|neighbor| run.fragment < neighbor) { own } else { -own });
            for (out, point) in out.iter_mut().zip(tessellation.run_vertices(run)) {
                *out = [(u.dot(&point.coords) * meter) as f32, (v.dot(&point.coords) * meter) as f32];
            }
        });
    }

    /// All bonds: between fragments by body and fragment, then between fragments and the world by fragment.
    pub fn bonds(&self) -> Vec<BondRow> {
        let meter = self.transform.meters_per_unit;
        let mut bonds = Vec::with_capacity(self.bond_count());
        self.each_crack(|first, tessellation, run, neighbor| {
            let (mut area, mut mean, mut moment) = (0.0, Vector3::zeros(), Vector3::zeros());
            for face in faces(tessellation, run) {
                let own = face.area.norm();
                (area, mean) = (area + own, mean + face.area);
                moment += face.corners.iter().map(|corner| corner.coords).sum::<Vector3<f64>>() * (own / 3.0);
            }
            bonds.push(BondRow {
                fragments: [first + run.fragment, first + neighbor],
                area_m2: area * meter * meter,
                normal: mean.try_normalize(0.0).unwrap_or_default(),
                centroid_m: self.frame.to_meters(&Point3::from(moment / area.max(f64::MIN_POSITIVE))),
            });
        });
        bonds.extend_from_slice(&self.world);
        bonds
    }

    /// Random points on all cracks, uniform by area, with sizes by a power law.
    ///
    /// Source: D. L. Turcotte, *Fractals and fragmentation* (1986): the number of larger pieces is proportional to the
    /// inverse square of the size.
    pub fn debris(&self) -> Vec<DebrisRow> {
        let meter = self.transform.meters_per_unit;
        let [least, most] = DEBRIS_SPACINGS.map(|spacings| spacings * self.crack_spacing * meter);
        let mut debris = Vec::with_capacity(self.debris_count());
        let mut crack = 0;
        self.each_crack(|first, tessellation, run, neighbor| {
            let mut random = RandomStream::new(self.seed, DEBRIS_STREAM + crack);
            crack += 1;
            let faces: Vec<Face> = faces(tessellation, run).collect();
            let mut sum = 0.0;
            let mut sums = Vec::with_capacity(faces.len());
            for face in &faces {
                sum += face.area.norm();
                sums.push(sum);
            }
            let center = &self.fragments[(first + run.fragment) as usize].center_m;
            let center = Point3::from(*center);
            for _ in 0..faces.len().div_ceil(TRIANGLES_PER_POINT) {
                let wanted = random.uniform() * sum;
                let face = &faces[sums.partition_point(|sum| *sum <= wanted).min(faces.len() - 1)];
                let point = within(&face.corners, [random.uniform(), random.uniform()]);
                let tail = 1.0 - random.uniform() * (1.0 - (least / most).powi(2));
                debris.push(DebrisRow {
                    fragment: first + run.fragment,
                    neighbor: first + neighbor,
                    position_m: self.frame.to_meters(&point) - center,
                    normal: face.area.try_normalize(0.0).unwrap_or(Vector3::z()),
                    size_m: least / tail.sqrt(),
                });
            }
        });
        debris
    }

    /// Calls `work` with each run and its part of `out`, one element per vertex, in parallel.
    fn each_run<T: Send>(&self, out: &mut [T], work: impl Fn(&Tessellation, &RunRange, &mut [T]) + Sync) {
        let mut rest = out;
        for pieces in &self.bodies {
            let tessellation = &pieces.tessellation;
            let (own, others) = rest.split_at_mut(tessellation.vertex_count());
            tessellation.each_run(own, |run, out| work(tessellation, run, out));
            rest = others;
        }
    }

    /// Calls `work` with each crack from its lower fragment: index of the body's first fragment, tessellation, run, and
    /// upper fragment within the body.
    fn each_crack(&self, mut work: impl FnMut(u32, &Tessellation, &RunRange, u32)) {
        let mut first = 0;
        for pieces in &self.bodies {
            let tessellation = &pieces.tessellation;
            for run in tessellation.runs().iter().filter(|run| is_lower(run)) {
                work(first, tessellation, run, run.neighbor.unwrap_or(run.fragment));
            }
            first += tessellation.fragments().len() as u32;
        }
    }
}

/// Two unit vectors orthogonal to `normal` and to each other.
fn plane(normal: Vector3<f64>) -> [Vector3<f64>; 2] {
    let normal = normal.try_normalize(0.0).unwrap_or(Vector3::z());
    let mut axis = Vector3::zeros();
    axis[normal.iamin()] = 1.0;
    let u = normal.cross(&axis).normalize();
    [u, normal.cross(&u)]
}

/// A point uniform over a triangle's area, from two uniform numbers.
fn within(corners: &[Point3<f64>; 3], [a, b]: [f64; 2]) -> Point3<f64> {
    let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
    corners[0] + (corners[1] - corners[0]) * a + (corners[2] - corners[0]) * b
}
