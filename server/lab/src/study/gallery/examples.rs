//! Objects and requests that show each effect.

use super::super::effects::EffectsError;
use super::EffectComparison;
use super::marks::{self, SPREAD};
use super::result::GalleryResult;
use crate::picture::{Color, DrawnMesh};
use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{DegreeRequest, FractureRequest, ImpactContact, PreparedObject, SurfaceKind};
use shatter_fracture::scene::{
    Anchors, DEFAULT_GRAVITY_M_S2, EffectKind, EffectSet, Grain, Material, Paint, Region, WarpControls, Waves,
};
use shatter_fracture::surface::{RawMesh, shapes};

/// Displacement of fragments for the artist's controls, whose cracks show best when the fragments hardly move.
const NARROW: f64 = 0.06;

/// Volume below which a fragment is shown as a sliver, m³.
const SLIVER_M3: f64 = 3e-5;

/// Box that holds the bar, m.
const HELD_M: [[f64; 3]; 2] = [[-0.3, -0.1, -0.1], [-0.2, 0.1, 0.1]];

/// Effect, with the object and request that show it.
pub struct EffectExample {
    name: &'static str,
    caption: &'static str,
    from: [f32; 3],
    stage: Stage,
    strike: FractureRequest,
    on: EffectSet,
    controls: WarpControls,
    anchors: Anchors,
    draw: fn(&GalleryResult, bool) -> DrawnMesh,
    /// Second contact, only with the effect on.
    also: Option<ImpactContact>,
    /// Whether the largest fragment is struck again with the effect on.
    again: bool,
}

/// Object of a showcase.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Bar,
    Block,
    Horseshoe,
    Statue,
    /// Statue with texture coordinates, as seen from the front.
    Painted,
    /// Block with an existing crack in its middle, from the top to half its height.
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

    fn prepare(
        self,
        controls: &WarpControls,
        anchors: &Anchors,
        examples: u64,
    ) -> Result<PreparedObject, EffectsError> {
        let name = if self.is_statue() { "plaster" } else { "stone" };
        let material = Material::named(name).map_err(|error| EffectsError::Materials(error.to_string()))?;
        let cracks = (self == Self::Cracked).then(|| {
            let corners = [[0.0, -0.2], [0.2, -0.2], [0.2, 0.2], [0.0, 0.2]].map(|[y, z]| Point3::new(0.0, y, z));
            RawMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
        });
        // The exact surface has the input's texture without these effects.
        let surface = if self == Self::Painted { SurfaceKind::Lattice } else { SurfaceKind::Exact };
        let request = BakeRequest { examples, cracks, surface, ..BakeRequest::new("shown", name, material) };
        let token = CancelToken::default();
        let mut prepared = bake(self.mesh(), &request, &token, &mut |_| {})?.warped(controls, &token)?;
        if !anchors.regions.is_empty() {
            prepared.anchor(anchors, &token)?;
        }
        Ok(prepared)
    }
}

impl EffectExample {
    fn new(effect: EffectKind, caption: &'static str, stage: Stage, strike: FractureRequest) -> Self {
        let on = strike.effects.with(effect);
        let draw: fn(&GalleryResult, bool) -> DrawnMesh = |result, _| result.mesh(SPREAD);
        let from = if stage.is_statue() { [0.7, 0.35, 1.0] } else { [0.45, 0.55, 1.0] };
        let (name, controls, anchors) = (effect.name(), WarpControls::default(), Anchors::default());
        Self { name, caption, from, stage, strike, on, controls, anchors, draw, also: None, again: false }
    }

    fn drawn(self, draw: fn(&GalleryResult, bool) -> DrawnMesh) -> Self {
        Self { draw, ..self }
    }

    /// Showcase of the bar, held at its left end, seen from the front.
    fn held(effect: EffectKind, caption: &'static str, strike: FractureRequest) -> Self {
        let [min_m, max_m] = HELD_M.map(Point3::from);
        let end = Region::Cuboid { min_m, max_m };
        let anchors = Anchors { regions: vec![end], gravity_m_s2: Some(Vector3::from(DEFAULT_GRAVITY_M_S2)) };
        let show = Self { anchors, from: [0.15, 0.4, 1.0], ..Self::new(effect, caption, Stage::Bar, strike) };
        show.drawn(|result, on| marks::held(result, HELD_M.map(Point3::from), on || result.is_held()))
    }

    /// Showcase of an artist's control on a block, seen from the front.
    fn warp(name: &'static str, caption: &'static str, controls: WarpControls) -> Self {
        let show = Self::new(EffectKind::Warp, caption, Stage::Block, wide(40));
        Self { name, controls, from: [0.35, 0.4, 1.0], ..show }.drawn(|result, _| result.mesh(NARROW))
    }

    /// Strikes twice and builds the meshes.
    pub fn comparison(self) -> Result<EffectComparison, EffectsError> {
        let Self { name, caption, from, .. } = self;
        let examples = if self.on.has(EffectKind::Examples) { 40 } else { 0 };
        let prepared = self.stage.prepare(&self.controls, &self.anchors, examples)?;
        let half = |effects: EffectSet, on: bool| {
            let mut strike = FractureRequest { effects, ..self.strike.clone() };
            strike.contacts.extend(self.also.filter(|_| on));
            strike.contacts = snapped(&prepared, &strike);
            let result = GalleryResult::new(&prepared, &strike)?;
            let result = if self.again && on { result.again(&prepared, &strike)? } else { result };
            Ok::<_, EffectsError>((self.draw)(&result, on))
        };
        let meshes = [half(self.strike.effects, false)?, half(self.on, true)?];
        Ok(EffectComparison { name, caption, from, meshes })
    }
}

/// Mesh with x and y as texture coordinates.
fn painted(mut mesh: RawMesh) -> RawMesh {
    let uv = |vertex: u32| {
        let point = &mesh.positions_m[vertex as usize];
        [point.x as f32, point.y as f32]
    };
    mesh.attributes.uvs = mesh.triangles.iter().map(|triangle| triangle.map(uv)).collect();
    mesh
}

/// Contacts, moved to the nearest nodes of the object's lattices.
fn snapped(prepared: &PreparedObject, strike: &FractureRequest) -> Vec<ImpactContact> {
    let nodes = || prepared.bodies.iter().flat_map(|body| &body.crack.nodes).map(|node| prepared.frame.to_meters(node));
    let snap = |contact: &ImpactContact| {
        let distance = |node: &Point3<f64>| (node - contact.point_m).norm();
        let point_m = nodes().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(contact.point_m);
        ImpactContact { point_m, ..*contact }
    };
    strike.contacts.iter().map(snap).collect()
}

/// Impact at a point, with that many sites and these effects.
fn request(point: [f64; 3], impulse: [f64; 3], sites: u32, effects: &[EffectKind]) -> FractureRequest {
    let strike = FractureRequest::at(Point3::from(point), Vector3::from(impulse)).seeded(1);
    let lift = if effects.contains(&EffectKind::Interior) { LiftKind::Interior } else { LiftKind::Euclidean };
    FractureRequest {
        degree: DegreeRequest::Sites(sites),
        effects: EffectSet::of(effects.iter().copied()),
        lift,
        seed: 4,
        ..strike
    }
}

/// Impact on the front of the block whose energy falls off slowly.
fn wide(sites: u32) -> FractureRequest {
    let mut strike = request([0.05, 0.02, 0.1], [0.0, 0.0, -300.0], sites, &[]);
    strike.contacts[0].radius_m = Some(0.4);
    strike
}

fn bar(sites: u32, effects: &[EffectKind]) -> FractureRequest {
    request([0.0, 0.05, 0.0], [0.0, -60.0, 0.0], sites, effects)
}

fn statue(sites: u32) -> FractureRequest {
    request([-0.02, 0.3, 0.065], [0.0, 0.0, -20.0], sites, &[EffectKind::Elastic, EffectKind::Interior])
}

/// All showcases.
pub fn effect_examples() -> Vec<EffectExample> {
    let elastic = [EffectKind::Elastic];
    let horseshoe =
        FractureRequest { lift: LiftKind::Interior, ..request([0.0, 0.125, 0.0], [0.0, -30.0, 0.0], 14, &[]) };
    // Three fragments without the effect, five with it.
    let tap = request([-0.049, 0.012, 0.0], [0.0, -0.0485, 0.0], 0, &[EffectKind::Elastic, EffectKind::Interior]);
    let learned = FractureRequest { degree: DegreeRequest::Inferred, ..tap };
    let slivers = FractureRequest { volume_min_m3: Some(SLIVER_M3), ..statue(90) };
    let textured = FractureRequest { effects: statue(16).effects.with(EffectKind::Attributes), ..statue(16) };
    let mut all = vec![
        EffectExample::new(EffectKind::Elastic, "the bar bends, and breaks where it bends", Stage::Bar, bar(24, &[])),
        EffectExample::new(
            EffectKind::Tensile,
            "cracks where the bar is in tension, not in compression",
            Stage::Bar,
            bar(24, &elastic),
        ),
        EffectExample::new(EffectKind::Interior, "fragments stay on their leg of the horseshoe", Stage::Horseshoe, horseshoe),
        EffectExample::new(
            EffectKind::Examples,
            "as many fragments as a network predicts from the object's examples",
            Stage::Horseshoe,
            learned,
        ),
        EffectExample::new(
            EffectKind::Slivers,
            "fragments below 30 cm³ (red) are merged into neighbors",
            Stage::Statue,
            slivers,
        )
        .drawn(|result, _| marks::slivers(result, SLIVER_M3)),
        EffectExample::new(
            EffectKind::Release,
            "fragments fly with their release velocities",
            Stage::Statue,
            statue(40),
        )
        .drawn(|result, on| if on { marks::release(result) } else { result.mesh(0.0) }),
        EffectExample::new(EffectKind::Normals, "smooth shading", Stage::Statue, statue(16)).drawn(marks::normals),
        EffectExample::new(EffectKind::Uv, "a checkerboard on crack faces, fields of 12 mm", Stage::Statue, statue(16))
            .drawn(|result, on| if on { marks::uvs(result) } else { result.mesh(SPREAD) }),
        EffectExample::new(EffectKind::Bonds, "bonds between touching fragments, thicker for larger areas", Stage::Statue, statue(24))
            .drawn(|result, on| if on { marks::bonds(result) } else { result.mesh(marks::BOND_SPREAD) }),
        EffectExample::new(
            EffectKind::Debris,
            "chips on crack faces, drawn three times as large as they are",
            Stage::Statue,
            statue(24),
        )
        .drawn(|result, on| if on { marks::debris(result) } else { result.mesh(SPREAD) }),
        EffectExample::new(EffectKind::Hulls, "a convex hull of each fragment, for collisions", Stage::Statue, statue(24))
            .drawn(|result, on| if on { marks::hulls(result) } else { result.mesh(SPREAD) }),
        EffectExample::new(
            EffectKind::Attributes,
            "outer faces with the input's texture and normals",
            Stage::Painted,
            statue(16),
        )
        .drawn(|result, on| if on { marks::attributes(result) } else { result.mesh(SPREAD) }),
        EffectExample::new(
            EffectKind::Skin,
            "left: the lattice's faces with the input's texture; right: the input's own triangles, cut with the fragments",
            Stage::Painted,
            textured,
        )
        .drawn(|result, on| if on { marks::skin(result) } else { marks::attributes(result) }),
        EffectExample::held(
            EffectKind::Anchored,
            "the bar is held on the left and breaks there, too",
            request([0.2, 0.05, 0.0], [0.0, -20.0, 0.0], 24, &elastic),
        ),
        EffectExample::held(
            EffectKind::Gravity,
            "a tap on a shelf that carries its weight",
            request([0.2, 0.05, 0.0], [0.0, -1e-4, 0.0], 24, &[EffectKind::Elastic, EffectKind::Anchored]),
        ),
    ];
    all.extend(artist());
    all.extend(more());
    all
}

/// Showcases of features that are not separate effects.
fn more() -> [EffectExample; 3] {
    let both = [EffectKind::Elastic, EffectKind::Interior];
    let left = bar(16, &both);
    let right = ImpactContact { point_m: Point3::new(0.2, 0.05, 0.0), ..left.contacts[0] };
    let cracked = FractureRequest { lift: LiftKind::Interior, ..wide(16) };
    let horseshoe = FractureRequest {
        lift: LiftKind::Interior,
        ..request([0.0, 0.125, 0.0], [0.0, -30.0, 0.0], 6, &[EffectKind::Interior])
    };
    let new = |name, caption, effect, stage, strike| EffectExample {
        name,
        ..EffectExample::new(effect, caption, stage, strike)
    };
    [
        EffectExample {
            also: Some(right),
            ..new(
                "several contacts",
                "left: one contact; right: a second one at the end",
                EffectKind::Elastic,
                Stage::Bar,
                left,
            )
        },
        new(
            "existing crack",
            "cracked from the top to half its height; left: straight distances; right: distances around the crack",
            EffectKind::Interior,
            Stage::Cracked,
            cracked,
        )
        .drawn(|result, _| result.mesh(0.0)),
        EffectExample {
            again: true,
            ..new(
                "struck again",
                "right: the largest fragment of the left, struck again",
                EffectKind::Interior,
                Stage::Horseshoe,
                horseshoe,
            )
        },
    ]
}

/// Showcases of the artist's controls.
fn artist() -> [EffectExample; 5] {
    let silent = WarpControls::default;
    let grain = Some(Grain { axis: Vector3::new(1.0, 0.5, 0.0), ratio: 4.0 });
    let waves = Some(Waves { length_m: 0.12, slope: 0.3 });
    let points_m = vec![Point3::new(-0.1, 0.0, 0.0), Point3::new(0.1, 0.0, 0.0)];
    let paint = Some(Paint { points_m, factors: vec![6.0, 0.4] });
    let protected = vec![Region::Ball { center_m: Point3::from([0.06, 0.03, 0.1]), radius_m: 0.07 }];
    let ring = |k: u32| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / 8.0).sin_cos();
        Point3::new(0.09 * cosine, 0.09 * sine, 0.09)
    };
    let sites_m = (0..8).map(ring).chain([Point3::new(0.0, 0.0, 0.09)]).collect();
    let marked: fn(&GalleryResult, bool) -> DrawnMesh = |result, _| {
        let mut mesh = result.mesh(0.0);
        let center = result.point(&Point3::new(0.06, 0.03, 0.1));
        mesh.append(marks::ball(center, 0.012, Color::oklch(0.5, 0.18, 28.0)));
        mesh
    };
    [
        EffectExample::warp(
            "warp: grain",
            "fragments four times as long along the grain",
            WarpControls { grain, ..silent() },
        ),
        EffectExample::warp("warp: waves", "winding cracks", WarpControls { waves, ..silent() }),
        EffectExample::warp(
            "warp: paint",
            "many small fragments on the left, few on the right",
            WarpControls { paint, ..silent() },
        ),
        EffectExample::warp(
            "warp: protect",
            "no crack within 7 cm of the red mark",
            WarpControls { protected, ..silent() },
        )
        .drawn(marked),
        EffectExample::warp(
            "warp: sites",
            "a fragment around each of nine points",
            WarpControls { sites_m, ..silent() },
        )
        .drawn(|result, _| result.mesh(0.0)),
    ]
}
