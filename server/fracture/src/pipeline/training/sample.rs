//! Random impacts over an object's surface, for calibration and training.
//!
//! Ours: contact points uniform by area, directions around the inward normal, radii over two octaves, one or two contacts.

use crate::pipeline::contact::ImpactContact;
use crate::pipeline::prepared::object::{PreparedBody, PreparedObject};
use crate::pipeline::prepared::parameters::DisplacementMethod;
use crate::pipeline::prepared::reduction::TRAINED_RADIUS_MIN;
use crate::pipeline::request::fracture_request::FractureRequest;
use crate::random::RandomStream;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

/// Share of the impacts with a second contact.
const TWO_CONTACTS: f64 = 0.2;

/// Smallest and largest cosine of the angle between a direction and the inward normal.
const COSINES: [f64; 2] = [0.5, 1.0];

/// As [`COSINES`], for all forces that push.
const COSINES_ALL: [f64; 2] = [0.0, 1.0];

/// As [`COSINES`], for forces along the surface.
const COSINES_ALONG: [f64; 2] = [0.0, 0.0];

/// Largest radius over the smallest.
const RADIUS_RANGE: f64 = 4.0 / 0.95;

/// Random source of impacts over all bodies of an object.
pub struct ImpactSampler<'a> {
    prepared: &'a PreparedObject,
    /// Body, face of its crack lattice's boundary, and cumulative area up to and including that face.
    faces: Vec<(usize, usize, f64)>,
}

impl<'a> ImpactSampler<'a> {
    /// A sampler over the boundaries of all crack lattices.
    pub fn new(prepared: &'a PreparedObject) -> Self {
        let mut sum = 0.0;
        let mut faces = Vec::new();
        for (index, body) in prepared.bodies.iter().enumerate() {
            for face in 0..body.topology.boundary.len() {
                sum += normal(corners(body, face)).norm();
                faces.push((index, face, sum));
            }
        }
        Self { prepared, faces }
    }

    /// A point, uniform by area, and the inward unit normal at it, both local.
    pub fn point(&self, stream: &mut RandomStream) -> (Point3<f64>, Vector3<f64>) {
        let total = self.faces.last().map_or(0.0, |(.., sum)| *sum);
        let place = stream.uniform() * total;
        let found = self.faces.partition_point(|(.., sum)| *sum <= place).min(self.faces.len() - 1);
        let (body, face, _) = self.faces[found];
        let triangle = corners(&self.prepared.bodies[body], face);
        let [a, b, c] = triangle.map(|corner| corner.coords / 3.0);
        (Point3::from(a + b + c), -normal(triangle).normalize())
    }

    /// Impact `index` of `seed`, of about 1 N·s, to be solved; options that are not drawn have their defaults.
    pub fn impact(&self, seed: u64, index: u64) -> FractureRequest {
        self.drawn(seed, index, COSINES)
    }

    /// As [`Self::impact`], with forces at any angle to the surface.
    pub(super) fn impact_at_any_angle(&self, seed: u64, index: u64) -> FractureRequest {
        self.drawn(seed, index, COSINES_ALL)
    }

    /// As [`Self::impact`], with forces along the surface.
    pub(super) fn impact_along(&self, seed: u64, index: u64) -> FractureRequest {
        self.drawn(seed, index, COSINES_ALONG)
    }

    fn drawn(&self, seed: u64, index: u64, cosines: [f64; 2]) -> FractureRequest {
        let mut stream = RandomStream::new(seed, index);
        let count = if stream.uniform() < TWO_CONTACTS { 2 } else { 1 };
        let contacts = (0..count).map(|_| self.contact(&mut stream, cosines)).collect::<Vec<_>>();
        let first = contacts[0];
        let elastic = DisplacementMethod::Solve;
        FractureRequest { contacts, seed: index, elastic, ..FractureRequest::at(first.point_m, first.impulse_ns) }
    }

    fn contact(&self, stream: &mut RandomStream, [least, most]: [f64; 2]) -> ImpactContact {
        let (point, inward) = self.point(stream);
        let cosine = most - (most - least) * stream.uniform();
        let (turn, magnitude) = (TAU * stream.uniform(), 1.0 - 0.5 * stream.uniform());
        let radius = TRAINED_RADIUS_MIN * RADIUS_RANGE.powf(stream.uniform());
        let across = inward.cross(&least_axis(&inward)).normalize();
        let sideways = across * turn.cos() + inward.cross(&across) * turn.sin();
        let direction = inward * cosine + sideways * (1.0 - cosine * cosine).sqrt();
        ImpactContact {
            point_m: self.prepared.frame.to_meters(&point),
            impulse_ns: direction * magnitude,
            duration_s: None,
            radius_m: Some(radius * self.prepared.frame.diagonal_m),
            partner: None,
        }
    }
}

fn corners(body: &PreparedBody, face: usize) -> [Point3<f64>; 3] {
    body.topology.boundary[face].nodes.map(|node| body.crack.nodes[node as usize])
}

/// Outward normal with twice the area as length.
fn normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// The coordinate axis with the smallest component in `vector`.
fn least_axis(vector: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[vector.iamin()] = 1.0;
    axis
}
