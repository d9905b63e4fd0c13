//! Data of an object before it breaks, requested from the service once before the simulation begins.

use super::Failure;
use super::film::Shell;
use nalgebra::{Matrix3, Vector3};
use rapier3d_f64::prelude::{MassProperties, Matrix, SharedShape, Vector};
use shatter_client::{Contact, Deadline, DegreeRule, Effect, FractureResult, Fragment, Impact, Object, ObjectFacts};
use shatter_export::contact::{ContactBody, ContactPolicy, ElasticMaterial, HertzContact};
use std::time::Duration;

/// Number of pieces in the collider of a whole object.
const PARTS: u32 = 16;

/// Time for the service to reply to one of these requests.
const TIMEOUT: Duration = Duration::from_secs(30);

/// Speed of the impact of the threshold request, m/s.
const SPEED_M_S: f64 = 3.0;

/// Share of the impulse that just breaks the object at the weakest of six places; contacts below it are not sent.
const SHARE: f64 = 0.25;

/// Depth from which a hull that overlaps other fragments counts as hollow (a ring or a bowl), m.
const MARGIN_M: f64 = 4e-3;

/// Body for the simulation: mass, colliders and triangles, in the coordinates of the mesh file.
#[derive(Clone)]
pub struct Block {
    pub mass_kg: f64,
    pub center_m: [f64; 3],
    pub volume_m3: f64,
    /// Moments xx, yy, zz, xy, xz, yz about the center.
    pub inertia_kg_m2: [f64; 6],
    /// Collider shapes, in the coordinates of the mesh file.
    pub shapes: Vec<SharedShape>,
    /// Whether other fragments are inside of its hull; it does not collide with them.
    pub hollow: bool,
    /// Triangles relative to the center.
    pub shell: Shell,
}

/// Object of the service as a whole body.
pub struct Prototype {
    pub facts: ObjectFacts,
    pub block: Block,
    pub terms: ContactPolicy,
    /// Impulse below which contacts are not sent, N·s.
    least_ns: f64,
}

impl Prototype {
    /// Breaks the object into a few pieces whose hulls become its collider, and requests its threshold.
    pub fn of(object: &Object) -> Result<Self, Failure> {
        let facts = object.facts().clone();
        let block = whole(&facts, object)?;
        let terms = facts.contact_policy(block.mass_kg).speed_min(0.5).cooldown(0.1);
        let least_ns = SHARE * weakest(object, &block, terms.own())?;
        Ok(Self { facts, block, terms: terms.impulse_min(least_ns), least_ns })
    }

    /// Contact policy of a fragment.
    ///
    /// The relevant energy grows with F²L, and the duration of Hertz contacts with the size of bodies, so the impulse that just breaks a
    /// body grows with the square root of its size.
    pub fn terms_of(&self, fragment: &Block) -> ContactPolicy {
        let radius_m = (fragment.volume_m3 * 0.75 / std::f64::consts::PI).cbrt();
        let least_ns = self.least_ns * (fragment.volume_m3 / self.block.volume_m3).powf(1.0 / 6.0);
        let own = ContactBody { material: self.facts.contact_material(), mass_kg: fragment.mass_kg, radius_m };
        ContactPolicy::new(own).merge(self.facts.radius_m).speed_min(0.5).impulse_min(least_ns).cooldown(0.1)
    }
}

/// Whole object, joined from pieces.
fn whole(facts: &ObjectFacts, object: &Object) -> Result<Block, Failure> {
    let impact = Impact::new([Contact::new(facts.center_m).impulse([0.0, -1.0, 0.0]).radius(facts.diagonal_m)]);
    let impact = impact.degree(DegreeRule::Sites(PARTS)).enable(Effect::Hulls);
    let result: FractureResult = object.strike(&impact)?.wait(Deadline::after(TIMEOUT))?;
    let parts: Vec<Block> = result.fragments().map(|fragment| block(&fragment)).collect();
    let mass_kg: f64 = parts.iter().map(|part| part.mass_kg).sum();
    let moment: Vector3<f64> = parts.iter().map(|part| Vector3::from(part.center_m) * part.mass_kg).sum();
    let center = moment / mass_kg;
    let inertia: Matrix3<f64> = parts.iter().map(|part| about(part, &center)).sum();
    // The visible mesh is the closed object in one piece, because each of the pieces is rounded about its own center.
    let one = object.strike(&object.even(1, Deadline::after(TIMEOUT))?)?.wait(Deadline::after(TIMEOUT))?;
    let mut shell = Shell { center_m: center.cast::<f32>().into(), ..Shell::default() };
    for fragment in one.fragments() {
        shell.normals.extend_from_slice(fragment.normals());
        let moved = (Vector3::from(fragment.center_m()) - center).cast::<f32>();
        fragment
            .runs()
            .for_each(|run| shell.add(run.positions, run.indices, moved.into(), run.vertex_first, run.is_crack));
    }
    let index = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    Ok(Block {
        mass_kg,
        center_m: center.into(),
        volume_m3: parts.iter().map(|part| part.volume_m3).sum(),
        inertia_kg_m2: index.map(|at| inertia[at]),
        shapes: parts.into_iter().flat_map(|part| part.shapes).collect(),
        hollow: false,
        shell,
    })
}

/// Inertia of a part about another point (Steiner).
fn about(part: &Block, point: &Vector3<f64>) -> Matrix3<f64> {
    let arm = Vector3::from(part.center_m) - point;
    tensor(part.inertia_kg_m2) + part.mass_kg * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose())
}

fn tensor([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Fragment, copied out of shared memory.
pub fn block(fragment: &Fragment<'_>) -> Block {
    let center_m = fragment.center_m();
    let place = |point: &[f32; 3]| Vector::from([0, 1, 2].map(|k| f64::from(point[k]) + center_m[k]));
    let triangles = |indices: &[u32]| indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect::<Vec<_>>();
    let hull = fragment.hull();
    let shape = hull.and_then(|hull| {
        SharedShape::convex_mesh(hull.positions.iter().map(place).collect(), &triangles(hull.indices))
    });
    // Fragments too flat for a hull from the service get a thickness of one millimeter.
    let flat = || SharedShape::round_convex_hull(&fragment.positions().iter().map(place).collect::<Vec<_>>(), 5e-4);
    let (center, normals) = (center_m.map(|x| x as f32), fragment.normals().to_vec());
    let mut shell = Shell { center_m: center, normals, ..Shell::default() };
    for run in fragment.runs() {
        shell.add(run.positions, run.indices, [0.0; 3], run.vertex_first, run.is_crack);
    }
    Block {
        mass_kg: fragment.mass_kg(),
        center_m,
        volume_m3: fragment.volume_m3(),
        inertia_kg_m2: fragment.inertia_kg_m2(),
        shapes: shape.or_else(flat).into_iter().collect(),
        hollow: hull.is_some_and(|hull| hull.margin_m > MARGIN_M),
        shell,
    }
}

impl Block {
    /// Mass properties for Rapier, in the coordinates of the mesh file.
    pub fn mass_properties(&self) -> MassProperties {
        let [xx, yy, zz, xy, xz, yz] = self.inertia_kg_m2;
        let inertia = Matrix::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        MassProperties::with_inertia_matrix(self.center_m.into(), self.mass_kg, inertia)
    }
}

/// Smallest impulse, N·s, that just breaks the object at one of the six ends of its axes, in a contact with the floor.
fn weakest(object: &Object, block: &Block, own: ContactBody) -> Result<f64, Failure> {
    let floor = ContactBody::ground(ElasticMaterial::CONCRETE);
    let hertz = HertzContact::of(&own, &floor, SPEED_M_S)?;
    let mut least_ns = f64::INFINITY;
    for (axis, sign) in (0..6).map(|end| (end / 2, if end % 2 == 0 { 1.0 } else { -1.0 })) {
        let reach = |point: &[f32; 3]| f64::from(point[axis]) * sign;
        let Some(tip) = block.shell.positions.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))) else { continue };
        let point_m = [0, 1, 2].map(|k| block.center_m[k] + f64::from(tip[k]));
        let mut impulse_ns = [0.0; 3];
        impulse_ns[axis] = -sign;
        let impact =
            Impact::new([Contact::new(point_m).impulse(impulse_ns).duration(hertz.duration_s).radius(hertz.radius_m)]);
        let result = object.strike(&impact.threshold_only())?.wait(Deadline::after(TIMEOUT))?;
        least_ns = least_ns.min(result.summary().threshold_impulse_factor);
    }
    Ok(least_ns)
}
