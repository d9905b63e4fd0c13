//! A host in one file, to copy from: an object falls in Rapier, breaks, and its fragments go on as bodies.
//!
//! ```sh
//! cargo build --release --workspace
//! target/release/shatterd bake --shape mug --material ceramic --quality draft
//! target/release/shatterd serve &
//! cargo run --release --features shatter-lab/rapier --example rapier -- mug
//! ```
//!
//! What every host does, in the order of this file:
//!
//! 1. Before the simulation: connect, ask for the object, and make its collider ([`Host::add_whole`]).
//! 2. In each step: remember velocities, step, collect the contacts ([`Host::collect`]).
//! 3. Contacts of a step become an impact, which is sent; nothing waits ([`Host::strike`]).
//! 4. In a later step the result is there: fragments take the place of the body ([`Host::replace`]).
//!
//! The frame of a body is that of the mesh file, be it whole or a fragment. So contacts are given in the frame of the body, and a fragment
//! starts with the pose of the body that it was a part of. `rapier_host.rs` beside this file adds second breaks, a daemon that dies, and a film.

use rapier3d_f64::prelude::*;
use shatter_client::contact::{ContactBody, ContactCollector, ContactEvent, ElasticMaterial, MergedContact};
use shatter_client::{Client, Deadline, Effect, FractureResult, Fragment, Impact, Object, Poll, Ticket};
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// What went wrong, in words.
type Failure = Box<dyn std::error::Error>;

/// Steps per second, and how many are simulated.
const RATE_HZ: f64 = 120.0;
const STEPS: u32 = 480;

/// How high the object is dropped from, m, and how it is turned about z, rad.
const HEIGHT_M: f64 = 1.5;
const TURN_RAD: f64 = 2.0;

/// The collider of the whole object is made of so many convex pieces.
const PIECES: u32 = 16;

/// A fragment into whose hull others reach deeper than this, m, is a ring or a bowl: it collides with the ground alone.
const MARGIN_M: f64 = 4e-3;

/// A result that comes later is of no use.
const USEFUL: Duration = Duration::from_secs(1);

/// Who collides with whom: fragments with everything, hollow ones with the ground.
const ANYTHING: InteractionGroups =
    InteractionGroups::new(Group::GROUP_1, Group::GROUP_1.union(Group::GROUP_2), InteractionTestMode::And);
const GROUND: InteractionGroups = InteractionGroups::new(Group::GROUP_2, Group::ALL, InteractionTestMode::And);
const HOLLOW: InteractionGroups = InteractionGroups::new(Group::GROUP_3, Group::GROUP_2, InteractionTestMode::And);

fn main() -> Result<(), Failure> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "mug".to_owned());
    // This waits, so a game does it on a thread that loads. The service is `default`, or what SHATTER_SERVICE names.
    let patience = Deadline::after(Duration::from_secs(20));
    let object = Client::connect_default(patience)?.object(&name, patience)?;
    let mut host = Host::new(object);
    host.add_ground();
    host.add_whole(patience)?;
    let begun = Instant::now();
    for step in 0..STEPS {
        host.step(f64::from(step) / RATE_HZ)?;
        // A game draws here; this example waits until the next step is due.
        let due = begun + Duration::from_secs_f64(f64::from(step + 1) / RATE_HZ);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    host.report();
    Ok(())
}

/// An impact under way.
struct Sent {
    body: RigidBodyHandle,
    ticket: Ticket,
    at_s: f64,
}

/// What a host keeps.
struct Host {
    /// The simulation.
    physics: PhysicsWorld,
    /// What breaks. A connection outlives the daemon: `strike` finds the next one by itself.
    object: Object,
    /// Points of the object's surface, m.
    surface: Vec<[f64; 3]>,
    /// Turns the contacts of a step into impacts.
    contacts: ContactCollector<(u32, u32)>,
    /// Impacts whose results are not there yet.
    sent: Vec<Sent>,
    /// Bodies that are fragments.
    fragments: Vec<RigidBodyHandle>,
    /// How bodies moved before the step: velocity, angular velocity, and the center they are about.
    before: HashMap<RigidBodyHandle, [Vector; 3]>,
}

impl Host {
    fn new(object: Object) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.integration_parameters.dt = 1.0 / RATE_HZ;
        // Each contact then has its own impulse.
        physics.integration_parameters.contact_clustering = false;
        Self {
            physics,
            object,
            surface: Vec::new(),
            contacts: ContactCollector::default(),
            sent: Vec::new(),
            fragments: Vec::new(),
            before: HashMap::new(),
        }
    }

    /// A floor whose top is at height 0.
    fn add_ground(&mut self) {
        let floor = ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::new(0.0, -0.5, 0.0)).friction(0.6);
        self.physics.insert_collider(floor.collision_groups(GROUND), None);
    }

    /// The whole object: the service divides it into even pieces, whose hulls are its collider.
    fn add_whole(&mut self, patience: Deadline) -> Result<(), Failure> {
        let impact = self.object.even(PIECES, patience)?.enable(Effect::Hulls);
        let pieces = self.object.strike(&impact)?.wait(patience)?;
        let mass: MassProperties = pieces.fragments().map(|piece| mass(&piece)).sum();
        let pose = Pose::new(Vector::new(0.0, HEIGHT_M, 0.0), Vector::new(0.0, 0.0, TURN_RAD));
        let body = RigidBodyBuilder::dynamic().pose(pose).additional_mass_properties(mass);
        let body = self.physics.insert_body(body);
        for piece in pieces.fragments() {
            self.add_hull(body, &piece, ANYTHING);
            // The outside alone: a contact on the collider is moved to the nearest of these points.
            for run in piece.runs().filter(|run| !run.crack) {
                self.surface.extend(run.positions.iter().map(|point| placed(&piece, point)));
            }
        }
        self.physics.bodies[body].recompute_mass_properties_from_colliders(&self.physics.colliders);
        // From now on its contacts become impacts, those faster than half a meter per second, four times a second at most.
        let policy = self.object.facts().contact_terms(mass.mass());
        self.contacts.watch(body.into_raw_parts(), policy.speed_min(0.5).cooldown(0.25));
        println!("{}: {:.3} kg, {} hulls", self.object.facts().name, mass.mass(), pieces.fragments().len());
        Ok(())
    }

    /// The hull of a fragment as a collider of `body`. It has no density: the mass of the body is given.
    fn add_hull(&mut self, body: RigidBodyHandle, fragment: &Fragment<'_>, groups: InteractionGroups) {
        let corners = |points: &[[f32; 3]]| points.iter().map(|point| placed(fragment, point).into()).collect();
        let shape = match fragment.hull() {
            Some(hull) => {
                let triangles = hull.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect::<Vec<_>>();
                SharedShape::convex_mesh(corners(hull.positions), &triangles)
            }
            // The service gives no hull to a fragment that is too flat: here it is as thick as a millimeter.
            None => {
                let points: Vec<Vector> = corners(fragment.positions());
                SharedShape::round_convex_hull(&points, 5e-4)
            }
        };
        if let Some(shape) = shape {
            let collider = ColliderBuilder::new(shape).density(0.0).friction(0.6).restitution(0.05);
            self.physics.insert_collider(collider.collision_groups(groups), Some(body));
        }
    }

    /// One step of the game. No call in it waits for the service.
    fn step(&mut self, now_s: f64) -> Result<(), Failure> {
        let motion = |body: &RigidBody| [body.linvel(), body.angvel(), body.center_of_mass()];
        self.before = self.physics.bodies.iter().map(|(handle, body)| (handle, motion(body))).collect();
        self.physics.step();
        self.collect();
        for (body, merged) in self.contacts.step(now_s) {
            let body = RigidBodyHandle::from_raw_parts(body.0, body.1);
            match merged {
                Ok(merged) => self.strike(body, &merged, now_s),
                // A flat landing, for instance, has no width by Hertz theory.
                Err(lost) => println!("{now_s:.3} s: no impact: {lost}"),
            }
        }
        self.poll(now_s)
    }

    /// Tells the collector every contact of the step, once for each of the two bodies. It leaves out the bodies that it does not watch.
    fn collect(&mut self) {
        for pair in self.physics.narrow_phase.contact_pairs() {
            let colliders = [pair.collider1, pair.collider2].map(|handle| &self.physics.colliders[handle]);
            for manifold in pair.solver_manifolds() {
                for point in manifold.points.iter().filter(|point| point.data.impulse > 0.0) {
                    let place = colliders[0].position().transform_point(point.local_p1);
                    let [one, other] = colliders.map(|collider| self.velocity_before(collider, place));
                    let speed_m_s = (one - other).dot(manifold.data.normal);
                    // The normal points from the first to the second: the first is pushed back, the second forth.
                    let impulse = manifold.data.normal * point.data.impulse;
                    for (own, other, impulse) in [(0, 1, -impulse), (1, 0, impulse)] {
                        let Some(body) = colliders[own].parent() else { continue };
                        let other = self.partner(colliders[other]);
                        let pose = self.physics.bodies[body].position();
                        let event = ContactEvent {
                            point_m: pose.inverse_transform_point(place).into(),
                            impulse_ns: pose.inverse_transform_vector(impulse).into(),
                            speed_m_s,
                            other,
                        };
                        self.contacts.touch(&body.into_raw_parts(), event);
                    }
                }
            }
        }
    }

    /// Velocity of a collider at a place before the step: after it the bodies no longer approach each other.
    fn velocity_before(&self, collider: &Collider, place: Vector) -> Vector {
        let motion = collider.parent().and_then(|body| self.before.get(&body));
        motion.map_or(Vector::ZERO, |[linear, angular, center]| *linear + angular.cross(place - *center))
    }

    /// What touches: the mass, material and radius that Hertz theory asks for.
    fn partner(&self, collider: &Collider) -> ContactBody {
        let Some(body) = collider.parent() else { return ContactBody::ground(ElasticMaterial::CONCRETE) };
        self.object.facts().contact_terms(self.physics.bodies[body].mass()).own()
    }

    /// Sends the contacts of a step as one impact. A body has one under way at most.
    fn strike(&mut self, body: RigidBodyHandle, merged: &[MergedContact], now_s: f64) {
        if self.sent.iter().any(|sent| sent.body == body) {
            return;
        }
        let on_surface: Vec<MergedContact> = merged.iter().map(|contact| self.snapped(contact)).collect();
        let Some(impact) = Impact::of(&on_surface) else { return };
        let impact = impact.enable(Effect::Hulls).enable(Effect::Release).deadline(USEFUL);
        match self.object.strike(&impact) {
            Ok(ticket) => self.sent.push(Sent { body, ticket, at_s: now_s }),
            // Without a daemon the game goes on without fracture; the next contact tries again.
            Err(error) => println!("{now_s:.3} s: not sent: {error}"),
        }
    }

    /// The contact at the nearest point of the surface: hulls are convex and touch where a hollow object has no wall.
    fn snapped(&self, contact: &MergedContact) -> MergedContact {
        let square = |point: &[f64; 3]| (0..3).map(|k| (point[k] - contact.point_m[k]).powi(2)).sum::<f64>();
        let nearest = self.surface.iter().min_by(|a, b| square(a).total_cmp(&square(b)));
        MergedContact { point_m: nearest.copied().unwrap_or(contact.point_m), ..*contact }
    }

    /// Looks at every impact under way.
    fn poll(&mut self, now_s: f64) -> Result<(), Failure> {
        for mut sent in std::mem::take(&mut self.sent) {
            match sent.ticket.poll() {
                Ok(Poll::Pending) => self.sent.push(sent),
                Ok(Poll::Ready(result)) if result.is_whole() => {
                    println!("{now_s:.3} s: whole, at {:.2} of the threshold", result.summary().e1_over_gamma);
                }
                Ok(Poll::Ready(result)) => {
                    let late_ms = 1e3 * (now_s - sent.at_s);
                    println!("{now_s:.3} s: {} fragments, {late_ms:.0} ms after the contact", result.fragments().len());
                    self.replace(sent.body, &result);
                }
                Err(error) if error.kind.retry() => println!("{now_s:.3} s: {error}"),
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// Fragments take the place of a body: where it is now, not where it was when it was struck.
    fn replace(&mut self, body: RigidBodyHandle, result: &FractureResult) {
        self.contacts.forget(&body.into_raw_parts());
        let Some(old) = self.physics.remove_body(body) else { return };
        let pose = *old.position();
        for fragment in result.fragments() {
            // It moves as its part of the body did, and as the released energy drives it.
            let center = pose.transform_point(fragment.center_m().into());
            let (mut linear, mut angular) = (old.velocity_at_point(center), old.angvel());
            if let Some(released) = fragment.velocity() {
                linear += pose.transform_vector(released.linear_m_s.into());
                angular += pose.transform_vector(released.angular_rad_s.into());
            }
            let new = RigidBodyBuilder::dynamic().pose(pose).linvel(linear).angvel(angular);
            let new = self.physics.insert_body(new.additional_mass_properties(mass(&fragment)));
            let is_hollow = fragment.hull().is_some_and(|hull| hull.margin_m > MARGIN_M);
            self.add_hull(new, &fragment, if is_hollow { HOLLOW } else { ANYTHING });
            // Rapier would take the mass in with the next step only.
            self.physics.bodies[new].recompute_mass_properties_from_colliders(&self.physics.colliders);
            self.fragments.push(new);
            // A game copies `fragment.positions()`, `indices()` and `runs()` into its own meshes here.
        }
        // The result is dropped soon after: it lies in memory that the service lends again.
    }

    /// What has become of it.
    fn report(&self) {
        let bodies = || self.fragments.iter().map(|handle| &self.physics.bodies[*handle]);
        let mass_kg: f64 = bodies().map(RigidBody::mass).sum();
        let slow = bodies().filter(|body| body.linvel().length() < 0.1).count();
        println!("{} fragments of {mass_kg:.3} kg together, {slow} of them at rest", self.fragments.len());
    }
}

/// Mass, center and inertia of a fragment in the frame of the mesh file.
fn mass(fragment: &Fragment<'_>) -> MassProperties {
    let [xx, yy, zz, xy, xz, yz] = fragment.inertia_kg_m2();
    let inertia = Matrix::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    MassProperties::with_inertia_matrix(fragment.center_m().into(), fragment.mass_kg(), inertia)
}

/// A point of a fragment in the frame of the mesh file: positions are relative to its center.
fn placed(fragment: &Fragment<'_>, point: &[f32; 3]) -> [f64; 3] {
    let center_m = fragment.center_m();
    [0, 1, 2].map(|k| center_m[k] + f64::from(point[k]))
}
