//! Example host in one file: an object falls in Rapier and breaks, and its fragments continue as bodies.
//!
//! ```sh
//! cargo build --release --workspace
//! target/release/shatterd bake --shape mug --material ceramic --quality draft
//! target/release/shatterd serve &
//! cargo run --release --features shatter-lab/rapier --example rapier -- mug
//! ```
//!
//! Every host takes these steps, which are also the order of this file:
//!
//! 1. Before the simulation: connect, request the object, and make its collider ([`Host::add_whole`]).
//! 2. In each step: store velocities, step, collect the contacts ([`Host::collect`]).
//! 3. Convert the contacts of a step to an impact and send it; no call waits ([`Host::strike`]).
//! 4. In a later step, receive the result and replace the body by its fragments ([`Host::replace`]).
//!
//! The frame of every body, whole or fragment, is that of the mesh file. So contacts are given in the frame of the body, and a
//! fragment starts with the pose of its parent. The example `rapier_host` beside this file also breaks fragments again, survives a
//! killed daemon, and draws pictures.

use rapier3d_f64::prelude::*;
use shatter_client::contact::{ContactBody, ContactCollector, ContactEvent, ElasticMaterial, MergedContact};
use shatter_client::{Client, Deadline, Effect, FractureResult, Fragment, Impact, Object, Poll, Ticket};
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Error of the example.
type Failure = Box<dyn std::error::Error>;

/// Steps per second, and number of steps.
const RATE_HZ: f64 = 120.0;
const STEPS: u32 = 480;

/// Height from which the object falls, m, and its rotation about z, rad.
const HEIGHT_M: f64 = 1.5;
const TURN_RAD: f64 = 2.0;

/// Number of convex pieces in the collider of the whole object.
const PIECES: u32 = 16;

/// Depth from which a hull that overlaps other fragments counts as hollow (a ring or a bowl), m. It collides only with the ground.
const MARGIN_M: f64 = 4e-3;

/// Deadline of requests; later results are of no use.
const USEFUL: Duration = Duration::from_secs(1);

/// Collision groups: fragments collide with everything, hollow ones with the ground.
const ANYTHING: InteractionGroups =
    InteractionGroups::new(Group::GROUP_1, Group::GROUP_1.union(Group::GROUP_2), InteractionTestMode::And);
const GROUND: InteractionGroups = InteractionGroups::new(Group::GROUP_2, Group::ALL, InteractionTestMode::And);
const HOLLOW: InteractionGroups = InteractionGroups::new(Group::GROUP_3, Group::GROUP_2, InteractionTestMode::And);

fn main() -> Result<(), Failure> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "mug".to_owned());
    // These calls wait, so a game makes them on a loading thread. The service is `default`, or the one that SHATTER_SERVICE names.
    let timeout = Deadline::after(Duration::from_secs(20));
    let object = Client::connect_default(timeout)?.object(&name, timeout)?;
    let mut host = Host::new(object);
    host.add_ground();
    host.add_whole(timeout)?;
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

/// Request in flight.
struct Sent {
    body: RigidBodyHandle,
    ticket: Ticket,
    at_s: f64,
}

/// State of a host.
struct Host {
    /// The simulation.
    physics: PhysicsWorld,
    /// The breakable object. Its connection outlives the daemon: `strike` connects to the next one.
    object: Object,
    /// Points of the object's surface, m.
    surface: Vec<[f64; 3]>,
    /// Turns the contacts of a step into impacts.
    contacts: ContactCollector<(u32, u32)>,
    /// Requests without a result yet.
    sent: Vec<Sent>,
    /// Bodies that are fragments.
    fragments: Vec<RigidBodyHandle>,
    /// Motion of bodies before the step: velocity, angular velocity, and the center they refer to.
    before: HashMap<RigidBodyHandle, [Vector; 3]>,
}

impl Host {
    fn new(object: Object) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.integration_parameters.dt = 1.0 / RATE_HZ;
        // With clustering off, impulses are those of single contacts.
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

    /// Adds a floor whose top is at height 0.
    fn add_ground(&mut self) {
        let floor = ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::new(0.0, -0.5, 0.0)).friction(0.6);
        self.physics.insert_collider(floor.collision_groups(GROUND), None);
    }

    /// Adds the whole object. The service divides it into even pieces, whose hulls are its collider.
    fn add_whole(&mut self, timeout: Deadline) -> Result<(), Failure> {
        let impact = self.object.even(PIECES, timeout)?.enable(Effect::Hulls);
        let pieces = self.object.strike(&impact)?.wait(timeout)?;
        let mass: MassProperties = pieces.fragments().map(|piece| mass(&piece)).sum();
        let pose = Pose::new(Vector::new(0.0, HEIGHT_M, 0.0), Vector::new(0.0, 0.0, TURN_RAD));
        let body = RigidBodyBuilder::dynamic().pose(pose).additional_mass_properties(mass);
        let body = self.physics.insert_body(body);
        for piece in pieces.fragments() {
            self.add_hull(body, &piece, ANYTHING);
            // Only the outside: a contact on the collider is moved to the nearest of these points.
            for run in piece.runs().filter(|run| !run.is_crack) {
                self.surface.extend(run.positions.iter().map(|point| placed(&piece, point)));
            }
        }
        self.physics.bodies[body].recompute_mass_properties_from_colliders(&self.physics.colliders);
        // Contacts faster than 0.5 m/s become impacts, at most four per second.
        let policy = self.object.facts().contact_policy(mass.mass());
        self.contacts.watch(body.into_raw_parts(), policy.speed_min(0.5).cooldown(0.25));
        println!("{}: {:.3} kg, {} hulls", self.object.facts().name, mass.mass(), pieces.fragments().len());
        Ok(())
    }

    /// Adds the hull of a fragment as a collider of `body`. It has no density: the body has a given mass.
    fn add_hull(&mut self, body: RigidBodyHandle, fragment: &Fragment<'_>, groups: InteractionGroups) {
        let corners = |points: &[[f32; 3]]| points.iter().map(|point| placed(fragment, point).into()).collect();
        let shape = match fragment.hull() {
            Some(hull) => {
                let triangles = hull.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect::<Vec<_>>();
                SharedShape::convex_mesh(corners(hull.positions), &triangles)
            }
            // A fragment that is too flat has no hull in the result; here its collider is a millimeter thick.
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

    /// Runs one step of the game. No call in it waits for the service.
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

    /// Passes every contact to the collector, once for each of the two bodies. The collector ignores bodies that it does not watch.
    fn collect(&mut self) {
        for pair in self.physics.narrow_phase.contact_pairs() {
            let colliders = [pair.collider1, pair.collider2].map(|handle| &self.physics.colliders[handle]);
            for manifold in pair.solver_manifolds() {
                for point in manifold.points.iter().filter(|point| point.data.impulse > 0.0) {
                    let point_m = colliders[0].position().transform_point(point.local_p1);
                    let [one, other] = colliders.map(|collider| self.velocity_before(collider, point_m));
                    let speed_m_s = (one - other).dot(manifold.data.normal);
                    // The normal points from the first to the second collider: the first is pushed against it, the second along it.
                    let impulse = manifold.data.normal * point.data.impulse;
                    for (own, other, impulse) in [(0, 1, -impulse), (1, 0, impulse)] {
                        let Some(body) = colliders[own].parent() else { continue };
                        let other = self.partner(colliders[other]);
                        let pose = self.physics.bodies[body].position();
                        let event = ContactEvent {
                            point_m: pose.inverse_transform_point(point_m).into(),
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

    /// Velocity of a collider at a point before the step; after it the bodies no longer approach each other.
    fn velocity_before(&self, collider: &Collider, point_m: Vector) -> Vector {
        let motion = collider.parent().and_then(|body| self.before.get(&body));
        motion.map_or(Vector::ZERO, |[linear, angular, center]| *linear + angular.cross(point_m - *center))
    }

    /// Contact body of a collider: the mass, material and radius that Hertz theory needs.
    fn partner(&self, collider: &Collider) -> ContactBody {
        let Some(body) = collider.parent() else { return ContactBody::ground(ElasticMaterial::CONCRETE) };
        self.object.facts().contact_policy(self.physics.bodies[body].mass()).own()
    }

    /// Sends the contacts of a step as one impact. A body has at most one request in flight.
    fn strike(&mut self, body: RigidBodyHandle, merged: &[MergedContact], now_s: f64) {
        if self.sent.iter().any(|sent| sent.body == body) {
            return;
        }
        let on_surface: Vec<MergedContact> = merged.iter().map(|contact| self.snapped(contact)).collect();
        let Some(impact) = Impact::of(&on_surface) else { return };
        let impact = impact.enable(Effect::Hulls).enable(Effect::Release).deadline(USEFUL);
        match self.object.strike(&impact) {
            Ok(ticket) => self.sent.push(Sent { body, ticket, at_s: now_s }),
            // Without a daemon the game continues without fracture; the next contact tries again.
            Err(error) => println!("{now_s:.3} s: not sent: {error}"),
        }
    }

    /// Moves the contact to the nearest point of the surface: hulls are convex and touch where a hollow object has no wall.
    fn snapped(&self, contact: &MergedContact) -> MergedContact {
        let square = |point: &[f64; 3]| (0..3).map(|k| (point[k] - contact.point_m[k]).powi(2)).sum::<f64>();
        let nearest = self.surface.iter().min_by(|a, b| square(a).total_cmp(&square(b)));
        MergedContact { point_m: nearest.copied().unwrap_or(contact.point_m), ..*contact }
    }

    /// Polls every request in flight.
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

    /// Replaces a body by fragments at its present pose, not at the pose of the impact.
    fn replace(&mut self, body: RigidBodyHandle, result: &FractureResult) {
        self.contacts.forget(&body.into_raw_parts());
        let Some(old) = self.physics.remove_body(body) else { return };
        let pose = *old.position();
        for fragment in result.fragments() {
            // It continues the motion of its part of the body, and adds the velocity of the released energy.
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
            // Rapier itself would compute the mass only in the next step.
            self.physics.bodies[new].recompute_mass_properties_from_colliders(&self.physics.colliders);
            self.fragments.push(new);
            // A game copies `fragment.positions()`, `indices()` and `runs()` into its own meshes here.
        }
        // Drop the result soon: it lies in memory that the service lends again.
    }

    /// Prints the outcome.
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
