//! The simulation: bodies, contacts, and the replacement of bodies by fragments.
//!
//! The frame of every body, whole or fragment, is that of its mesh file. So a fragment starts with the pose of its parent, and contacts
//! in body coordinates are in the coordinates of requests.

use super::film::{Film, Key, Look, Shell};
use super::prototype::{Block, Prototype};
use super::set::Set;
use super::tally::Tally;
use rapier3d_f64::parry::query;
use rapier3d_f64::prelude::*;
use shatter_export::contact::{
    ContactBody, ContactCollector, ContactEvent, ElasticMaterial, ImpulseLost, MergedContact,
};
use std::collections::HashMap;

/// Origin of a fragment: process id of the daemon that retains the result, handle of the result, number of the fragment.
pub type Origin = (u32, u64, u32);

/// Breakable body.
pub struct Piece {
    pub body: RigidBodyHandle,
    pub actor: usize,
    pub prototype: usize,
    pub generation: u32,
    pub origin: Option<Origin>,
    pub center_m: [f64; 3],
    hollow: bool,
    pub alive: bool,
}

/// New fragment.
pub struct NewPiece {
    pub block: Block,
    /// Velocity in addition to the parent's, in the coordinates of the mesh file.
    pub linear_m_s: [f64; 3],
    pub angular_rad_s: [f64; 3],
    pub origin: Option<Origin>,
}

/// Initial state of a piece.
struct Start {
    pose: Pose,
    linear: Vector,
    angular: Vector,
    generation: u32,
    origin: Option<Origin>,
    at_s: f64,
}

/// Owners of colliders (`user_data`): ground, ball, or 2 plus the number of a piece.
const GROUND: u128 = 0;
const BALL: u128 = 1;
const FIRST: u128 = 2;

/// Collision groups: fragments with others inside of their hulls collide with everything but pieces, all others with everything.
const PIECES: InteractionGroups =
    InteractionGroups::new(Group::GROUP_2, Group::GROUP_1.union(Group::GROUP_2), InteractionTestMode::And);
const HOLLOW: InteractionGroups = InteractionGroups::new(Group::GROUP_3, Group::GROUP_1, InteractionTestMode::And);
const OTHERS: InteractionGroups = InteractionGroups::new(Group::GROUP_1, Group::ALL, InteractionTestMode::And);

/// Number of generations of fragments that may break again.
const GENERATIONS: u32 = 2;

/// Mass over the whole object below which fragments do not break again.
const SHARE: f64 = 0.03;

pub struct World<'a> {
    pub prototypes: &'a [Prototype],
    pub pieces: Vec<Piece>,
    physics: PhysicsWorld,
    balls: Vec<(RigidBodyHandle, usize)>,
    ball: ContactBody,
    contacts: ContactCollector<u32>,
    /// Bodies released at a time of the simulation, s.
    cues: Vec<(f64, RigidBodyHandle)>,
    /// Motion of bodies before the step: velocities, and the point they refer to.
    before: HashMap<RigidBodyHandle, [Vector; 3]>,
    newborn: Vec<u32>,
}

impl<'a> World<'a> {
    pub fn new(prototypes: &'a [Prototype], set: Set, film: &mut Film) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.integration_parameters.dt = 1.0 / f64::from(set.rate_hz());
        // With clustering off, impulses are those of single contacts.
        physics.integration_parameters.contact_clustering = false;
        let mut world = Self {
            prototypes,
            pieces: Vec::new(),
            physics,
            balls: Vec::new(),
            ball: ContactBody::ground(ElasticMaterial::STEEL),
            contacts: ContactCollector::default(),
            cues: Vec::new(),
            before: HashMap::new(),
            newborn: Vec::new(),
        };
        set.build(&mut world, film);
        world
    }

    /// Adds a static box.
    pub fn add_ground(&mut self, half_m: [f64; 3], place_m: [f64; 3], film: &mut Film) {
        let [x, y, z] = half_m;
        let collider = ColliderBuilder::cuboid(x, y, z)
            .translation(place_m.into())
            .friction(0.6)
            .collision_groups(OTHERS)
            .user_data(GROUND);
        self.physics.insert_collider(collider, None);
        let key = Key { at_s: 0.0, place_m: place_m.map(|x| x as f32), turn: [0.0, 0.0, 0.0, 1.0] };
        film.enter("ground".into(), Look::Ground, Shell::cuboid(half_m.map(|x| x as f32)), key);
    }

    /// Adds a steel ball on a string from `pivot_m`, released at `at_s`.
    pub fn add_ball(&mut self, radius_m: f64, place_m: [f64; 3], pivot_m: [f64; 3], at_s: f64, film: &mut Film) {
        let mass_kg = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * radius_m.powi(3);
        self.ball = ContactBody { material: ElasticMaterial::STEEL, mass_kg, radius_m };
        let body = RigidBodyBuilder::fixed().translation(place_m.into()).can_sleep(false);
        let collider =
            ColliderBuilder::ball(radius_m).density(7850.0).friction(0.3).collision_groups(OTHERS).user_data(BALL);
        let (body, _) = self.physics.insert(body, collider);
        self.physics.bodies[body].recompute_mass_properties_from_colliders(&self.physics.colliders);
        let pivot = self.physics.insert_body(RigidBodyBuilder::fixed().translation(pivot_m.into()));
        let arm = Vector::from(pivot_m) - Vector::from(place_m);
        let joint = SphericalJointBuilder::new().local_anchor1(Vector::ZERO).local_anchor2(arm);
        self.physics.insert_impulse_joint(pivot, body, joint);
        self.cues.push((at_s, body));
        let key = self.key(body, Vector::ZERO, 0.0);
        let actor = film.enter("ball".into(), Look::Steel, Shell::ball(radius_m as f32), key);
        self.balls.push((body, actor));
    }

    /// Adds a whole object; with `held_s` it is held and invisible until then.
    pub fn add_object(&mut self, prototype: usize, pose: Pose, held_s: Option<f64>, film: &mut Film) {
        let own = &self.prototypes[prototype];
        let name = format!("{}-{}", own.facts.name, self.pieces.len());
        let start = Start { pose, linear: Vector::ZERO, angular: Vector::ZERO, generation: 0, origin: None, at_s: 0.0 };
        let piece = self.add_piece(prototype, &own.block, start, name, film);
        self.contacts.watch(piece, own.terms);
        let body = self.pieces[piece as usize].body;
        if let Some(at_s) = held_s {
            self.physics.bodies[body].set_body_type(RigidBodyType::Fixed, false);
            self.cues.push((at_s, body));
            film.actors[self.pieces[piece as usize].actor].born_s = at_s;
        }
    }

    fn add_piece(&mut self, prototype: usize, block: &Block, start: Start, name: String, film: &mut Film) -> u32 {
        let Start { pose, linear, angular, generation, origin, at_s } = start;
        let number = self.pieces.len() as u32;
        let body = RigidBodyBuilder::dynamic().pose(pose).linvel(linear).angvel(angular);
        let body = self.physics.insert_body(body.additional_mass_properties(block.mass_properties()));
        for shape in &block.shapes {
            let collider = ColliderBuilder::new(shape.clone()).density(0.0).friction(0.6).restitution(0.05);
            let collider = collider.collision_groups(if block.hollow { HOLLOW } else { PIECES });
            self.physics.insert_collider(collider.user_data(FIRST + u128::from(number)), Some(body));
        }
        // Rapier itself would compute the mass only in the next step.
        self.physics.bodies[body].recompute_mass_properties_from_colliders(&self.physics.colliders);
        let key = self.key(body, block.center_m.into(), at_s);
        let actor = film.enter(name, Look::Piece(number), block.shell.clone(), key);
        let (center_m, hollow) = (block.center_m, block.hollow);
        self.pieces.push(Piece { body, actor, prototype, generation, origin, center_m, hollow, alive: true });
        number
    }

    /// Runs one step and passes its contacts to the collector.
    pub fn step(&mut self, now_s: f64) {
        let bodies = &mut self.physics.bodies;
        self.cues.retain(|(at_s, body)| {
            let due = *at_s <= now_s;
            if due {
                bodies[*body].set_body_type(RigidBodyType::Dynamic, true);
            }
            !due
        });
        let motion = |body: &RigidBody| [body.linvel(), body.angvel(), body.center_of_mass()];
        self.before.clear();
        self.before.extend(bodies.iter().map(|(handle, body)| (handle, motion(body))));
        self.physics.step();
        self.collect_contacts();
    }

    /// Pieces struck by the contacts of the step.
    pub fn merged_contacts(&mut self, now_s: f64) -> Vec<(u32, Result<Vec<MergedContact>, ImpulseLost>)> {
        self.contacts.step(now_s)
    }

    /// Excludes `piece` from further requests.
    pub fn spare(&mut self, piece: u32) {
        self.contacts.forget(&piece);
    }

    /// Passes every contact to the collector, once for each of the two bodies that may break.
    fn collect_contacts(&mut self) {
        for pair in self.physics.narrow_phase.contact_pairs() {
            let colliders = [pair.collider1, pair.collider2].map(|handle| &self.physics.colliders[handle]);
            for manifold in pair.solver_manifolds() {
                for point in manifold.points.iter().filter(|point| point.data.impulse > 0.0) {
                    let place = colliders[0].position().transform_point(point.local_p1);
                    let [one, other] = colliders.map(|collider| self.velocity(collider, place));
                    let speed_m_s = (one - other).dot(manifold.data.normal);
                    let impulse = manifold.data.normal * point.data.impulse;
                    for (own, other, impulse) in [(0, 1, -impulse), (1, 0, impulse)] {
                        let Some(piece) = colliders[own].user_data.checked_sub(FIRST) else { continue };
                        let Some(pose) = colliders[own].parent().map(|body| *self.physics.bodies[body].position())
                        else {
                            continue;
                        };
                        let touch = ContactEvent {
                            point_m: pose.inverse_transform_point(place).into(),
                            impulse_ns: pose.inverse_transform_vector(impulse).into(),
                            speed_m_s,
                            other: self.partner(colliders[other]),
                        };
                        self.contacts.touch(&(piece as u32), touch);
                    }
                }
            }
        }
    }

    /// Velocity before the step at a point.
    fn velocity(&self, collider: &Collider, place: Vector) -> Vector {
        let motion = collider.parent().and_then(|body| self.before.get(&body));
        motion.map_or(Vector::ZERO, |[linear, angular, center]| *linear + angular.cross(place - *center))
    }

    /// Contact body of a collider.
    fn partner(&self, collider: &Collider) -> ContactBody {
        match collider.user_data {
            GROUND => ContactBody::ground(ElasticMaterial::CONCRETE),
            BALL => self.ball,
            piece => {
                let number = (piece - FIRST) as u32;
                let own = || self.prototypes[self.pieces[number as usize].prototype].terms.own();
                self.contacts.terms(&number).map_or_else(own, |terms| terms.own())
            }
        }
    }

    /// Replaces `piece` by fragments, which continue its motion.
    pub fn shatter(&mut self, piece: u32, mut new_pieces: Vec<NewPiece>, now_s: f64, film: &mut Film) {
        let Piece { body, actor, prototype, generation, hollow, .. } = self.pieces[piece as usize];
        self.pieces[piece as usize].alive = false;
        self.contacts.forget(&piece);
        film.leave(actor, now_s);
        let Some(old) = self.physics.remove_body(body) else { return };
        let pose = *old.position();
        let own = &self.prototypes[prototype];
        for new_piece in &mut new_pieces {
            // Fragments of a body that contained others may overlap them.
            new_piece.block.hollow |= hollow;
            let center = pose.transform_point(new_piece.block.center_m.into());
            let linear = old.velocity_at_point(center) + pose.transform_vector(new_piece.linear_m_s.into());
            let angular = old.angvel() + pose.transform_vector(new_piece.angular_rad_s.into());
            let name = format!("{}-{}", own.facts.name, self.pieces.len());
            let start =
                Start { pose, linear, angular, generation: generation + 1, origin: new_piece.origin, at_s: now_s };
            let number = self.add_piece(prototype, &new_piece.block, start, name, film);
            let heavy = new_piece.block.mass_kg >= SHARE * own.block.mass_kg;
            if heavy && generation + 1 < GENERATIONS && new_piece.origin.is_some() {
                self.contacts.watch(number, own.terms_of(&new_piece.block));
            }
            self.newborn.push(number);
        }
    }

    /// Measures the overlaps of the fragments that were created in this step with each other and with anything else.
    pub fn measure_births(&mut self, tally: &mut Tally) {
        let newborn = std::mem::take(&mut self.newborn);
        let is_new = |collider: &Collider| {
            collider.user_data.checked_sub(FIRST).is_some_and(|piece| newborn.contains(&(piece as u32)))
        };
        let all: Vec<(Aabb, &Collider)> = self.physics.colliders.iter().map(|(_, c)| (c.compute_aabb(), c)).collect();
        for (bounds, own) in all.iter().filter(|(_, collider)| is_new(collider)) {
            for (_, other) in all.iter().filter(|(others, _)| others.intersects(bounds)) {
                if own.user_data == other.user_data || !own.collision_groups().test(other.collision_groups()) {
                    continue;
                }
                let contact = query::contact(own.position(), own.shape(), other.position(), other.shape(), 0.0);
                let depth_m = contact.ok().flatten().map_or(0.0, |contact| -contact.dist);
                tally.new_piece(depth_m, is_new(other));
            }
        }
    }

    /// Mass of everything that may break or has broken, kg, from Rapier.
    pub fn mass_kg(&self) -> f64 {
        self.alive().map(|piece| self.physics.bodies[piece.body].mass()).sum()
    }

    /// Kinetic and potential energy, J.
    pub fn energy_j(&self) -> f64 {
        let energy = |body: &RigidBody| body.kinetic_energy() + 9.81 * body.mass() * body.center_of_mass().y;
        let balls = self.balls.iter().map(|(body, _)| *body);
        let bodies = self.alive().map(|piece| piece.body).chain(balls);
        bodies.map(|body| energy(&self.physics.bodies[body])).sum()
    }

    /// Pieces that exist now.
    pub fn alive(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().filter(|piece| piece.alive)
    }

    /// Poses of everything that moves.
    pub fn poses(&self, now_s: f64) -> impl Iterator<Item = (usize, Key)> + '_ {
        let pieces = self.alive().map(move |piece| (piece.actor, self.key(piece.body, piece.center_m.into(), now_s)));
        pieces.chain(self.balls.iter().map(move |&(body, actor)| (actor, self.key(body, Vector::ZERO, now_s))))
    }

    fn key(&self, body: RigidBodyHandle, center: Vector, at_s: f64) -> Key {
        let pose = self.physics.bodies[body].position();
        let (place, turn) = (pose.transform_point(center), pose.rotation);
        Key {
            at_s,
            place_m: [place.x, place.y, place.z].map(|x| x as f32),
            turn: [turn.x, turn.y, turn.z, turn.w].map(|x| x as f32),
        }
    }
}
