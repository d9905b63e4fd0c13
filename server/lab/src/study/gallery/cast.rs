//! Which object shows which effect, and how it is struck.

use super::super::effects::EffectsError;
use super::Pair;
use super::broken::Broken;
use super::marks::{self, SPREAD};
use crate::picture::{Colour, Mesh};
use nalgebra::{Point3, Vector3};
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{Contact, DegreeRequest, Prepared, Strike};
use shatter_fracture::scene::MATERIALS;
use shatter_fracture::scene::{
    Anchors, Controls, DEFAULT_GRAVITY_M_S2, Effect, Effects, Grain, Materials, Paint, Region, Waves,
};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_fracture::token::Token;

/// Cracks of blocks under an artist are seen best when the pieces hardly move.
const NARROW: f64 = 0.06;

/// Pieces that are shown as slivers are smaller, m³.
const SLIVER_M3: f64 = 3e-5;

/// Where the bar is held, m.
const HELD_M: [[f64; 3]; 2] = [[-0.3, -0.1, -0.1], [-0.2, 0.1, 0.1]];

/// One effect and what shows it.
pub struct Show {
    name: &'static str,
    caption: &'static str,
    from: [f32; 3],
    stage: Stage,
    strike: Strike,
    on: Effects,
    controls: Controls,
    anchors: Anchors,
    draw: fn(&Broken, bool) -> Mesh,
    /// A second contact, on the right alone.
    also: Option<Contact>,
    /// Whether the largest piece is struck again on the right.
    again: bool,
}

/// What is struck.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Bar,
    Block,
    Horseshoe,
    Statue,
    /// The statue with texture coordinates, as seen from the front.
    Painted,
    /// The block, cracked already: in the middle, from the top to half its height.
    Cracked,
}

impl Stage {
    fn mesh(self) -> RawMesh {
        match self {
            Self::Bar => shapes::cuboid([0.5, 0.1, 0.1]),
            Self::Block | Self::Cracked => shapes::cuboid([0.4, 0.3, 0.2]),
            Self::Horseshoe => shapes::horseshoe(),
            Self::Statue => shapes::statue(),
            Self::Painted => painted(shapes::statue()),
        }
    }

    fn is_statue(self) -> bool {
        matches!(self, Self::Statue | Self::Painted)
    }

    fn prepare(self, controls: &Controls, anchors: &Anchors, examples: u64) -> Result<Prepared, EffectsError> {
        let name = if self.is_statue() { "plaster" } else { "stone" };
        let materials = Materials::parse(MATERIALS).map_err(|error| EffectsError::Materials(error.to_string()))?;
        let material = materials.get(name).map_err(|error| EffectsError::Materials(error.to_string()))?.clone();
        let cracks = (self == Self::Cracked).then(|| {
            let corners = [[0.0, -0.2], [0.2, -0.2], [0.2, 0.2], [0.0, 0.2]].map(|[y, z]| Point3::new(0.0, y, z));
            RawMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
        });
        let request = BakeRequest { examples, cracks, ..BakeRequest::new("shown", name, material) };
        let token = Token::default();
        let mut prepared = bake(self.mesh(), &request, &token, &mut |_| {})?.warped(controls, &token)?;
        if !anchors.regions.is_empty() {
            prepared.hold(anchors, &token)?;
        }
        Ok(prepared)
    }
}

impl Show {
    fn new(effect: Effect, caption: &'static str, stage: Stage, strike: Strike) -> Self {
        let on = strike.effects.with(effect);
        let draw: fn(&Broken, bool) -> Mesh = |broken, _| broken.mesh(SPREAD);
        let from = if stage.is_statue() { [0.7, 0.35, 1.0] } else { [0.45, 0.55, 1.0] };
        let (name, controls, anchors) = (effect.name(), Controls::default(), Anchors::default());
        Self { name, caption, from, stage, strike, on, controls, anchors, draw, also: None, again: false }
    }

    fn drawn(self, draw: fn(&Broken, bool) -> Mesh) -> Self {
        Self { draw, ..self }
    }

    /// The bar, held at its left end, seen from the front.
    fn held(effect: Effect, caption: &'static str, strike: Strike) -> Self {
        let [min_m, max_m] = HELD_M.map(Point3::from);
        let end = Region::Cuboid { min_m, max_m };
        let anchors = Anchors { regions: vec![end], gravity_m_s2: Some(Vector3::from(DEFAULT_GRAVITY_M_S2)) };
        let show = Self { anchors, from: [0.15, 0.4, 1.0], ..Self::new(effect, caption, Stage::Bar, strike) };
        show.drawn(|broken, on| marks::held(broken, HELD_M.map(Point3::from), on || broken.is_held()))
    }

    /// A control of the artist on a block, seen from the front.
    fn warp(name: &'static str, caption: &'static str, controls: Controls) -> Self {
        let show = Self::new(Effect::Warp, caption, Stage::Block, wide(40));
        Self { name, controls, from: [0.35, 0.4, 1.0], ..show }.drawn(|broken, _| broken.mesh(NARROW))
    }

    /// Strikes twice and makes what is drawn.
    pub fn pair(self) -> Result<Pair, EffectsError> {
        let Self { name, caption, from, .. } = self;
        let examples = if self.on.has(Effect::Examples) { 40 } else { 0 };
        let prepared = self.stage.prepare(&self.controls, &self.anchors, examples)?;
        let half = |effects: Effects, on: bool| {
            let mut strike = Strike { effects, ..self.strike.clone() };
            strike.contacts.extend(self.also.filter(|_| on));
            strike.contacts = snapped(&prepared, &strike);
            let broken = Broken::new(&prepared, &strike)?;
            let broken = if self.again && on { broken.again(&prepared, &strike)? } else { broken };
            Ok::<_, EffectsError>((self.draw)(&broken, on))
        };
        let meshes = [half(self.strike.effects, false)?, half(self.on, true)?];
        Ok(Pair { name, caption, from, meshes })
    }
}

/// The mesh with x and y as texture coordinates.
fn painted(mut mesh: RawMesh) -> RawMesh {
    let uv = |vertex: u32| {
        let point = &mesh.positions_m[vertex as usize];
        [point.x as f32, point.y as f32]
    };
    mesh.looks.uvs = mesh.triangles.iter().map(|triangle| triangle.map(uv)).collect();
    mesh
}

/// The contacts, moved to the nearest nodes of the object's lattices.
fn snapped(prepared: &Prepared, strike: &Strike) -> Vec<Contact> {
    let nodes = || prepared.bodies.iter().flat_map(|body| &body.crack.nodes).map(|node| prepared.frame.to_metres(node));
    let snap = |contact: &Contact| {
        let distance = |node: &Point3<f64>| (node - contact.point_m).norm();
        let point_m = nodes().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(contact.point_m);
        Contact { point_m, ..*contact }
    };
    strike.contacts.iter().map(snap).collect()
}

/// A blow at a point, with so many sites and these effects.
fn blow(point: [f64; 3], impulse: [f64; 3], sites: u32, effects: &[Effect]) -> Strike {
    let contact = Contact { point_m: point.into(), impulse_ns: impulse.into(), duration_s: None, radius_m: None };
    let strike = Strike::at(Point3::from(point), Vector3::from(impulse)).seeded(1);
    let lift = if effects.contains(&Effect::Interior) { LiftKind::Interior } else { LiftKind::Euclidean };
    Strike {
        contacts: vec![contact],
        degree: DegreeRequest::Sites(sites),
        effects: Effects::of(effects.iter().copied()),
        lift,
        seed: 4,
        ..strike
    }
}

/// On the front of the block, with an energy that falls off slowly.
fn wide(sites: u32) -> Strike {
    let mut strike = blow([0.05, 0.02, 0.1], [0.0, 0.0, -300.0], sites, &[]);
    strike.contacts[0].radius_m = Some(0.4);
    strike
}

fn bar(sites: u32, effects: &[Effect]) -> Strike {
    blow([0.0, 0.05, 0.0], [0.0, -60.0, 0.0], sites, effects)
}

fn statue(sites: u32) -> Strike {
    blow([-0.02, 0.3, 0.065], [0.0, 0.0, -20.0], sites, &[Effect::Elastic, Effect::Interior])
}

/// Everything that is shown.
pub fn cast() -> Vec<Show> {
    let elastic = [Effect::Elastic];
    let horseshoe = Strike { lift: LiftKind::Interior, ..blow([0.0, 0.125, 0.0], [0.0, -30.0, 0.0], 14, &[]) };
    // Off: three pieces, on: five.
    let tap = blow([-0.049, 0.012, 0.0], [0.0, -0.0485, 0.0], 0, &[Effect::Elastic, Effect::Interior]);
    let learned = Strike { degree: DegreeRequest::Inferred, ..tap };
    let slivers = Strike { volume_min_m3: Some(SLIVER_M3), ..statue(90) };
    let textured = Strike { effects: statue(16).effects.with(Effect::Attributes), ..statue(16) };
    let mut all = vec![
        Show::new(Effect::Elastic, "the bar bends, and breaks where it bends", Stage::Bar, bar(24, &[])),
        Show::new(
            Effect::Tensile,
            "cracks where the bar is pulled apart, not where it is pressed",
            Stage::Bar,
            bar(24, &elastic),
        ),
        Show::new(Effect::Interior, "pieces stay on their leg of the horseshoe", Stage::Horseshoe, horseshoe),
        Show::new(Effect::Examples, "as many pieces as the object's own examples say", Stage::Horseshoe, learned),
        Show::new(
            Effect::Slivers,
            "no piece is smaller than 30 cubic centimetres: those are red",
            Stage::Statue,
            slivers,
        )
        .drawn(|broken, _| marks::slivers(broken, SLIVER_M3)),
        Show::new(Effect::Release, "pieces fly with the velocities of their release", Stage::Statue, statue(40))
            .drawn(|broken, on| if on { marks::release(broken) } else { broken.mesh(0.0) }),
        Show::new(Effect::Normals, "smooth light", Stage::Statue, statue(16)).drawn(marks::normals),
        Show::new(Effect::Uv, "a board on crack faces, 12 mm a field", Stage::Statue, statue(16))
            .drawn(|broken, on| if on { marks::uvs(broken) } else { broken.mesh(SPREAD) }),
        Show::new(Effect::Bonds, "which pieces touch, thicker for larger areas", Stage::Statue, statue(24))
            .drawn(|broken, on| if on { marks::bonds(broken) } else { broken.mesh(marks::BOND_SPREAD) }),
        Show::new(
            Effect::Debris,
            "chips on crack faces, drawn three times as large as they are",
            Stage::Statue,
            statue(24),
        )
        .drawn(|broken, on| if on { marks::debris(broken) } else { broken.mesh(SPREAD) }),
        Show::new(Effect::Hulls, "a convex proxy of each piece, for collisions", Stage::Statue, statue(24))
            .drawn(|broken, on| if on { marks::hulls(broken) } else { broken.mesh(SPREAD) }),
        Show::new(
            Effect::Attributes,
            "outer faces look as the input: its texture, its normals",
            Stage::Painted,
            statue(16),
        )
        .drawn(|broken, on| if on { marks::attributes(broken) } else { broken.mesh(SPREAD) }),
        Show::new(
            Effect::Skin,
            "left the lattice's faces with the input's texture, right the input's own triangles, cut with the pieces",
            Stage::Painted,
            textured,
        )
        .drawn(|broken, on| if on { marks::skin(broken) } else { marks::attributes(broken) }),
        Show::held(
            Effect::Anchored,
            "held on the left, the bar breaks there, too",
            blow([0.2, 0.05, 0.0], [0.0, -20.0, 0.0], 24, &elastic),
        ),
        Show::held(
            Effect::Gravity,
            "a tap on a shelf that carries its weight",
            blow([0.2, 0.05, 0.0], [0.0, -1e-4, 0.0], 24, &[Effect::Elastic, Effect::Anchored]),
        ),
    ];
    all.extend(artist());
    all.extend(more());
    all
}

/// What is no effect of its own.
fn more() -> [Show; 3] {
    let both = [Effect::Elastic, Effect::Interior];
    let left = bar(16, &both);
    let right = Contact { point_m: Point3::new(0.2, 0.05, 0.0), ..left.contacts[0] };
    let cracked = Strike { lift: LiftKind::Interior, ..wide(16) };
    let horseshoe =
        Strike { lift: LiftKind::Interior, ..blow([0.0, 0.125, 0.0], [0.0, -30.0, 0.0], 6, &[Effect::Interior]) };
    let new = |name, caption, effect, stage, strike| Show { name, ..Show::new(effect, caption, stage, strike) };
    [
        Show {
            also: Some(right),
            ..new("several contacts", "left one blow, right a second one at the end", Effect::Elastic, Stage::Bar, left)
        },
        new(
            "existing crack",
            "cracked from the top to half its height: left with straight distances, right with those that know no way across",
            Effect::Interior,
            Stage::Cracked,
            cracked,
        )
        .drawn(|broken, _| broken.mesh(0.0)),
        Show {
            again: true,
            ..new(
                "struck again",
                "right, the largest piece of the left has been struck again",
                Effect::Interior,
                Stage::Horseshoe,
                horseshoe,
            )
        },
    ]
}

/// What an artist can say.
fn artist() -> [Show; 5] {
    let silent = Controls::default;
    let grain = Some(Grain { axis: Vector3::new(1.0, 0.5, 0.0), ratio: 4.0 });
    let waves = Some(Waves { length_m: 0.12, slope: 0.3 });
    let points_m = vec![Point3::new(-0.1, 0.0, 0.0), Point3::new(0.1, 0.0, 0.0)];
    let paint = Some(Paint { points_m, factors: vec![6.0, 0.4] });
    let protected = vec![Region::Ball { centre_m: Point3::from([0.06, 0.03, 0.1]), radius_m: 0.07 }];
    let ring = |k: u32| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / 8.0).sin_cos();
        Point3::new(0.09 * cosine, 0.09 * sine, 0.09)
    };
    let sites_m = (0..8).map(ring).chain([Point3::new(0.0, 0.0, 0.09)]).collect();
    let marked: fn(&Broken, bool) -> Mesh = |broken, _| {
        let mut mesh = broken.mesh(0.0);
        let centre = broken.point(&Point3::new(0.06, 0.03, 0.1));
        mesh.append(marks::ball(centre, 0.012, Colour::oklch(0.5, 0.18, 28.0)));
        mesh
    };
    [
        Show::warp("warp: grain", "pieces four times as long along the grain", Controls { grain, ..silent() }),
        Show::warp("warp: waves", "cracks wind", Controls { waves, ..silent() }),
        Show::warp("warp: paint", "many small pieces on the left, few on the right", Controls { paint, ..silent() }),
        Show::warp("warp: protect", "no crack within 7 cm of the red mark", Controls { protected, ..silent() })
            .drawn(marked),
        Show::warp("warp: sites", "a piece around each of nine points", Controls { sites_m, ..silent() })
            .drawn(|broken, _| broken.mesh(0.0)),
    ]
}
