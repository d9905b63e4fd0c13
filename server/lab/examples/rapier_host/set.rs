//! The sets: what stands, hangs and falls, and the scenes of their objects.

use super::film::Film;
use super::vessel;
use super::world::World;
use rapier3d_f64::prelude::{Pose, Vector};

/// Set of the simulation.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Set {
    /// Shelves of vases and mugs, a ball on a string before each, and falling objects; in real time
    Shelves,
    /// Painted vase and a ball on a string, close up; each step waits for its results
    Vase,
}

/// Vase of a set: its object, its mesh as OBJ, and the preset of its lattices.
pub struct Vase {
    pub name: &'static str,
    pub mesh: String,
    pub quality: &'static str,
}

impl Set {
    /// Objects, in the order of prototypes.
    pub fn objects(self) -> &'static [&'static str] {
        match self {
            Self::Shelves => &["mug", "statue", "vase"],
            Self::Vase => &["painted-vase"],
        }
    }

    /// Scene for `shatterd bake --scene` and `shatterd serve --scene`.
    pub fn scene(self) -> &'static str {
        match self {
            Self::Shelves => SHELVES_SCENE,
            Self::Vase => VASE_SCENE,
        }
    }

    /// Vase of the set, which no generated shape gives.
    pub fn vase(self) -> Vase {
        match self {
            Self::Shelves => Vase { name: "vase", mesh: vessel::vase(), quality: "draft" },
            Self::Vase => Vase { name: "painted-vase", mesh: vessel::painted_vase(), quality: "film" },
        }
    }

    /// Steps per simulated second.
    pub fn rate_hz(self) -> u32 {
        match self {
            Self::Shelves => 120,
            Self::Vase => 960,
        }
    }

    /// Fills the simulation.
    pub fn build(self, world: &mut World<'_>, film: &mut Film) {
        world.add_ground([8.0, 0.5, 8.0], [0.0, -0.5, 0.0], film);
        match self {
            Self::Shelves => shelves(world, film),
            Self::Vase => {
                world.add_object(0, Pose::new(Vector::ZERO, Vector::new(0.0, VASE_TURN_RAD, 0.0)), None, film);
                hang(VASE_BALL_M, VASE_PIVOT_M, 0.0, world, film);
            }
        }
    }

    fn number(self, name: &str) -> usize {
        self.objects().iter().position(|own| *own == name).unwrap_or_default()
    }
}

/// Fragments of a few nodes are too small for a game.
const SHELVES_SCENE: &str = r#"title = "Rapier host"

[objects.mug]
shape = "mug"
material = "terracotta"
quality = "draft"
effects = ["elastic", "interior", "release", "hulls"]
sites_max = 16

[objects.statue]
shape = "statue"
material = "plaster"
quality = "draft"
effects = ["elastic", "interior", "release", "hulls"]
sites_max = 24

[objects.vase]
quality = "draft"
effects = ["elastic", "interior", "release", "hulls"]
sites_max = 20
"#;

const VASE_SCENE: &str = r#"title = "Painted vase"

[objects.painted-vase]
quality = "film"
effects = ["elastic", "interior", "release", "normals", "hulls"]
fragment_size_m = 0.025
sites_max = 60
"#;

/// Rotation of the painted vase about y, rad; radius of its ball, m, and the point to which its string is tied, m.
const VASE_TURN_RAD: f64 = 0.5;
const VASE_BALL_M: f64 = 0.04;
const VASE_PIVOT_M: [f64; 3] = [-0.05, 1.97, 0.0];

/// Height of the shelves' boards, half their length, and their positions along z, m.
const BOARD_M: f64 = 1.0;
const HALF_M: f64 = 0.9;
const SHELVES: [(f64, f64); 3] = [(-1.2, 0.3), (0.0, 2.5), (1.2, 4.7)];

/// Length of a ball's string, m, and the angle to which it is pulled up, degrees.
const STRING_M: f64 = 1.8;
const PULLED_DEG: f64 = 80.0;
const BALL_M: f64 = 0.07;

/// Falling objects: name, position, rotation about z in degrees, and start time.
const FALLS: [(&str, [f64; 3], f64, f64); 20] = [
    ("statue", [-1.5, 1.6, 0.6], 160.0, 0.1),
    ("vase", [1.5, 1.8, 0.6], 30.0, 0.4),
    ("vase", [1.7, 1.8, -0.6], 80.0, 1.2),
    ("mug", [1.4, 1.8, 0.7], 120.0, 1.8),
    ("statue", [-1.5, 1.9, -0.6], 60.0, 2.0),
    ("vase", [1.9, 2.0, 0.3], 170.0, 2.9),
    ("mug", [1.6, 2.0, -0.5], 10.0, 3.4),
    ("vase", [2.0, 2.0, 1.1], 45.0, 3.8),
    ("statue", [-1.5, 2.1, 1.5], 185.0, 4.4),
    ("vase", [1.5, 2.1, -0.6], 60.0, 5.2),
    ("mug", [1.9, 2.1, 0.6], 75.0, 5.8),
    ("vase", [1.6, 2.2, 0.6], 200.0, 6.6),
    ("statue", [-1.6, 2.2, -1.5], 90.0, 7.2),
    ("vase", [1.8, 2.2, -0.2], 100.0, 8.0),
    ("statue", [-1.5, 2.4, 0.6], 200.0, 3.2),
    ("vase", [-1.9, 2.4, 1.8], 15.0, 0.8),
    ("vase", [-1.9, 2.4, -1.8], 65.0, 1.6),
    ("vase", [2.3, 2.4, 1.6], 140.0, 2.4),
    ("vase", [2.3, 2.4, -1.6], 190.0, 6.2),
    ("statue", [-2.1, 2.4, 0.6], 20.0, 8.4),
];

fn shelves(world: &mut World<'_>, film: &mut Film) {
    for (z, at_s) in SHELVES {
        world.add_ground([HALF_M, 0.02, 0.13], [0.0, BOARD_M - 0.02, z], film);
        for k in 0..7 {
            let x = -0.75 + 0.25 * f64::from(k);
            let name = if k % 3 == 1 { "mug" } else { "vase" };
            world.add_object(Set::Shelves.number(name), Pose::translation(x, BOARD_M + 0.001, z), None, film);
        }
        hang(BALL_M, [0.0, BOARD_M + 0.1 + STRING_M, z], at_s, world, film);
    }
    for (name, place_m, turn_deg, at_s) in FALLS {
        let turned = Vector::new(0.0, 0.0, turn_deg.to_radians());
        world.add_object(Set::Shelves.number(name), Pose::new(place_m.into(), turned), Some(at_s), film);
    }
}

/// Adds a ball on a string, pulled up towards -x and released at `at_s`.
fn hang(radius_m: f64, pivot_m: [f64; 3], at_s: f64, world: &mut World<'_>, film: &mut Film) {
    let (sine, cosine) = PULLED_DEG.to_radians().sin_cos();
    let place_m = [pivot_m[0] - STRING_M * sine, pivot_m[1] - STRING_M * cosine, pivot_m[2]];
    world.add_ball(radius_m, place_m, pivot_m, at_s, film);
}
