//! The film: actors, the times at which they are visible, and their poses at each picture.

use super::world::World;

/// Triangles, relative to the center of mass of their body.
#[derive(Clone, Default)]
pub struct Shell {
    pub positions: Vec<[f32; 3]>,
    pub outer: Vec<[u32; 3]>,
    pub cracks: Vec<[u32; 3]>,
    /// Normals of the positions; none without the effect `normals`.
    pub normals: Vec<[f32; 3]>,
    /// The center of mass in the coordinates of the mesh file, m.
    pub center_m: [f32; 3],
}

/// Appearance of an actor.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// Breakable body, by the number of its piece.
    Piece(u32),
    Steel,
    Ground,
}

/// Pose at a time.
#[derive(Clone, Copy, PartialEq)]
pub struct Key {
    pub at_s: f64,
    pub place_m: [f32; 3],
    /// Quaternion: x, y, z, w.
    pub turn: [f32; 4],
}

/// Actor of the film.
pub struct Actor {
    pub name: String,
    pub look: Look,
    pub shell: Shell,
    pub born_s: f64,
    /// Time at which it broke, s.
    pub gone_s: Option<f64>,
    pub keys: Vec<Key>,
}

/// All actors of the film.
#[derive(Default)]
pub struct Film {
    pub actors: Vec<Actor>,
}

impl Film {
    /// Adds an actor; returns its number.
    pub fn enter(&mut self, name: String, look: Look, shell: Shell, key: Key) -> usize {
        self.actors.push(Actor { name, look, shell, born_s: key.at_s, gone_s: None, keys: vec![key] });
        self.actors.len() - 1
    }

    /// Marks an actor as broken; its fragments replace it.
    pub fn leave(&mut self, actor: usize, now_s: f64) {
        self.actors[actor].gone_s = Some(now_s);
    }

    /// Takes one picture.
    pub fn shoot(&mut self, now_s: f64, world: &World<'_>) {
        for (actor, key) in world.poses(now_s) {
            let keys = &mut self.actors[actor].keys;
            let still = |other: &Key| other.place_m == key.place_m && other.turn == key.turn;
            // Two keys are enough for an actor at rest.
            if keys.len() > 1 && keys[keys.len() - 2..].iter().all(still) {
                keys.pop();
            }
            keys.push(key);
        }
    }
}

impl Actor {
    /// Pose at `at_s`, from the last picture before it; `None` if the actor is not visible then.
    pub fn at(&self, at_s: f64) -> Option<&Key> {
        let there = self.born_s <= at_s && self.gone_s.is_none_or(|gone_s| at_s < gone_s);
        let next = self.keys.partition_point(|key| key.at_s <= at_s);
        self.keys.get(next.saturating_sub(1)).filter(|_| there)
    }
}

impl Shell {
    /// Adds a run, whose indices count from `first`.
    pub fn add(&mut self, positions: &[[f32; 3]], indices: &[u32], moved: [f32; 3], first: u32, crack: bool) {
        let base = self.positions.len() as u32;
        self.positions.extend(positions.iter().map(|point| [0, 1, 2].map(|k| point[k] + moved[k])));
        let corner = |index: u32| index.wrapping_sub(first).wrapping_add(base);
        let triangles = indices.chunks_exact(3).map(|t| [corner(t[0]), corner(t[1]), corner(t[2])]);
        if crack { self.cracks.extend(triangles) } else { self.outer.extend(triangles) }
    }

    /// Box.
    pub fn cuboid(half_m: [f32; 3]) -> Self {
        let sign = |corner: usize, axis: usize| if corner >> axis & 1 == 1 { half_m[axis] } else { -half_m[axis] };
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Self {
            positions: (0..8).map(|corner| [0, 1, 2].map(|axis| sign(corner, axis))).collect(),
            outer: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
            ..Self::default()
        }
    }

    /// Sphere of rings.
    pub fn ball(radius_m: f32) -> Self {
        let (rings, around) = (16_u32, 32_u32);
        let at = |ring: u32, k: u32| ring * around + k % around;
        let point = |ring: u32, k: u32| {
            let (polar, turn) =
                (std::f32::consts::PI * ring as f32 / rings as f32, std::f32::consts::TAU * k as f32 / around as f32);
            [polar.sin() * turn.cos(), polar.cos(), -polar.sin() * turn.sin()].map(|x| x * radius_m)
        };
        let places = (0..rings).flat_map(|ring| (0..around).map(move |k| (ring, k)));
        let quads = places.map(|(ring, k)| [at(ring, k), at(ring + 1, k), at(ring + 1, k + 1), at(ring, k + 1)]);
        Self {
            positions: (0..=rings)
                .flat_map(|ring| (0..around).map(move |k| (ring, k)))
                .map(|(r, k)| point(r, k))
                .collect(),
            outer: quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
            ..Self::default()
        }
    }
}
