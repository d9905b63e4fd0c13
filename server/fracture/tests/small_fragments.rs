//! Striking fragments of exact surfaces that have too few whole tetrahedra for a lattice of their own.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables};
use shatter_fracture::fragment::closed;
use shatter_fracture::pipeline::{
    DegreeRequest, ElementChoice, FractureError, FractureMeshes, FractureOutcome, FractureRequest, PreparedObject,
    Preset, RequestContext, RetainedFragments, Stage, StageObserver, SurfaceKind, Workspace, strike_again,
};
use shatter_fracture::scene::{EffectKind, EffectSet, MATERIALS, Materials};
use shatter_fracture::surface::{LengthUnit, RawMesh, UpAxis, read, shapes};
use std::cell::Cell;
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::LazyLock;

/// A cup whose wall is 0.6 spacings thick.
static CUP: LazyLock<PreparedObject> = LazyLock::new(|| baked(cup(0.3, 0.6 * 0.05), 0.05));

/// A block with a plate of 0.3 spacings on its top, which the lattice lost.
static FIN: LazyLock<PreparedObject> = LazyLock::new(|| baked(fin(0.3 * 0.05), 0.05));

fn baked(mesh: RawMesh, spacing: f64) -> PreparedObject {
    let material = Materials::parse(MATERIALS).unwrap().get("ceramic").unwrap().clone();
    let request = BakeRequest {
        surface: SurfaceKind::Exact,
        // The tests want many small fragments, whose elements are linear in any case.
        elements: ElementChoice::Linear,
        kappa: Some(1.0),
        elastic_spacing: Some(1.5 * spacing),
        crack_spacing: Some(spacing),
        tables: Tables { interior: true, elastic: true, ..Tables::NONE },
        ..BakeRequest::new("object", "ceramic", material)
    };
    let prepared = request.bake(mesh).unwrap();
    assert_eq!(prepared.report.surface.reason, None);
    prepared
}

/// A closed surface around the outline, turned about the y axis. The ends of the outline are on the axis.
fn turned(outline: &[[f64; 2]], sectors: u32) -> RawMesh {
    let (first, rings) = (outline[0], &outline[1..outline.len() - 1]);
    let mut positions = vec![Point3::new(0.0, first[1], 0.0)];
    for [radius, y] in rings {
        let angle = |sector: u32| TAU * f64::from(sector) / f64::from(sectors);
        positions.extend((0..sectors).map(|k| Point3::new(radius * angle(k).cos(), *y, radius * angle(k).sin())));
    }
    let last = positions.len() as u32;
    positions.push(Point3::new(0.0, outline[outline.len() - 1][1], 0.0));
    let at = |ring: u32, sector: u32| 1 + ring * sectors + sector % sectors;
    let mut triangles = Vec::new();
    for k in 0..sectors {
        triangles.push([0, at(0, k), at(0, k + 1)]);
        for ring in 0..rings.len() as u32 - 1 {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            triangles.extend([[a, c, b], [a, d, c]]);
        }
        triangles.push([last, at(rings.len() as u32 - 1, k + 1), at(rings.len() as u32 - 1, k)]);
    }
    RawMesh::new(positions, triangles)
}

/// A cup of this radius and wall thickness with a bottom of 0.12 m.
fn cup(radius: f64, wall: f64) -> RawMesh {
    let inner = radius - wall;
    turned(&[[0.0, -0.2], [radius, -0.2], [radius, 0.3], [inner, 0.3], [inner, -0.08], [0.0, -0.08]], 40)
}

/// A block with a thin plate on its top; its diagonal is about 1 m.
fn fin(width: f64) -> RawMesh {
    let half = width / 2.0;
    let outline =
        [[-0.3, -0.3], [0.3, -0.3], [0.3, 0.1], [half, 0.1], [half, 0.4], [-half, 0.4], [-half, 0.1], [-0.3, 0.1]];
    let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 6], [0, 6, 7], [3, 4, 5], [3, 5, 6]];
    let count = outline.len() as u32;
    let layer = |z: f64| outline.map(|[x, y]| Point3::new(x, y, z));
    let mut triangles = Vec::new();
    for k in 0..count {
        let next = (k + 1) % count;
        triangles.extend([[k, next, count + next], [k, count + next, count + k]]);
    }
    for [a, b, c] in caps {
        triangles.extend([[a, c, b], [count + a, count + b, count + c]]);
    }
    RawMesh::new([layer(-0.25), layer(0.25)].concat(), triangles)
}

/// A request for `sites` sites without merges, at `point_m`, which may be as far as the object is large.
fn request(point_m: Point3<f64>, sites: u32) -> FractureRequest {
    let mut strike = FractureRequest::at(point_m, Vector3::new(5.0, 1.0, -2.0)).seeded(3);
    strike.contacts[0].radius_m = Some(1.0);
    let effects = EffectSet::default().without(EffectKind::Slivers);
    FractureRequest { degree: DegreeRequest::Sites(sites), effects, ..strike }
}

fn first(prepared: &PreparedObject, strike: &FractureRequest) -> FractureMeshes {
    prepared.strike(strike).unwrap().into_meshes().unwrap()
}

/// Notes whether a lift of interior distances was computed: fragments without a lattice have none.
#[derive(Default)]
struct LiftObserver(Cell<bool>);

impl StageObserver for LiftObserver {
    fn enter(&self, _: Stage) {}
    fn leave(&self, _: Stage, _: u64) {}
    fn begin(&self, effect: EffectKind) {
        self.0.set(self.0.get() || effect == EffectKind::Interior);
    }
    fn end(&self, _: EffectKind, _: u64) {}
    fn part(&self, _: EffectKind, _: u64) {}
}

/// Strikes a fragment; the flag tells whether it had no lattice of its own.
fn again(
    prepared: &PreparedObject,
    from: (&RetainedFragments, u32),
    strike: &FractureRequest,
) -> Result<(FractureOutcome, bool), FractureError> {
    let (token, observer) = (CancelToken::default(), LiftObserver::default());
    let context = RequestContext::new(prepared, strike, &token, &observer);
    let outcome = strike_again(context, from, &mut Workspace::default())?;
    Ok((outcome, !observer.0.get()))
}

/// Number of fragments without a lattice that were struck, by generation, and of those that fell into several pieces.
#[derive(Debug, Default, PartialEq)]
struct Struck {
    small: [usize; 3],
    divided: [usize; 3],
    undivided: usize,
    worst: f64,
}

/// Strikes fragments of `before`, and their children, to the third generation. All pieces must be closed, and their volumes must
/// add up to that of their parent.
fn generations(prepared: &PreparedObject, before: &FractureMeshes, generation: usize, struck: &mut Struck) {
    let kept = before.keep();
    let mut rows = before.fragments.clone();
    rows.sort_by(|a, b| a.volume_m3.total_cmp(&b.volume_m3));
    let mut left = [12, 3, 2][generation];
    for row in rows {
        if left == 0 {
            break;
        }
        let found = again(prepared, (&kept, row.id), &request(row.center_m.into(), 4));
        let (outcome, is_small) = match found {
            Err(FractureError::FragmentUndivided { .. }) => {
                struck.undivided += 1;
                continue;
            }
            found => found.unwrap(),
        };
        left -= 1;
        let children = outcome.into_meshes().unwrap();
        let emitted = children.emitted().unwrap();
        emitted.fragments().for_each(|fragment| closed(fragment.positions, fragment.indices).unwrap());
        let sum: f64 = children.fragments.iter().map(|child| child.volume_m3).sum();
        let error = (sum / row.volume_m3 - 1.0).abs();
        struck.worst = struck.worst.max(error);
        assert!(error < 1e-9, "generation {generation}, fragment {}: {sum} m³ of {} m³", row.id, row.volume_m3);
        struck.small[generation] += usize::from(is_small);
        struck.divided[generation] += usize::from(is_small && children.fragments.len() > 1);
        if generation < 2 {
            generations(prepared, &children, generation + 1, struck);
        }
    }
}

/// A crack between nodes beside an earlier crack can leave a piece without volume, and so without mass.
#[test]
fn pieces_of_pieces_have_mass() {
    let material = Materials::parse(MATERIALS).unwrap().get("ceramic").unwrap().clone();
    let tables = Tables { interior: true, elastic: true, ..Tables::NONE };
    let bake = BakeRequest {
        quality: Preset::Draft,
        kappa: Some(1.0),
        tables,
        ..BakeRequest::new("mug", "ceramic", material)
    };
    let prepared = bake.bake(shapes::mug()).unwrap();
    let spacing_m = prepared.parameters.crack_spacing * prepared.frame.diagonal_m;
    let before = first(&prepared, &request(Point3::new(0.0, 0.05, 0.04), 120).seeded(0));
    let kept = before.keep();
    let (mut children, mut least) = (0, f64::INFINITY);
    for row in &before.fragments {
        let Ok((outcome, _)) = again(&prepared, (&kept, row.id), &request(row.center_m.into(), 30)) else { continue };
        let pieces = outcome.into_meshes().unwrap().fragments;
        children += pieces.len();
        least = pieces.iter().map(|own| own.volume_m3 / spacing_m.powi(3)).fold(least, f64::min);
    }
    println!("{children} pieces of pieces, the smallest of {least:e} cells");
    assert!(children > 2000 && least > 1e-10, "{children} pieces, {least:e} cells");
}

#[track_caller]
fn check(prepared: &PreparedObject, point_m: Point3<f64>, sites: u32) {
    let mut struck = Struck::default();
    generations(prepared, &first(prepared, &request(point_m, sites)), 0, &mut struck);
    println!("{struck:?}");
    assert!(struck.divided.iter().zip([3, 5, 5]).all(|(count, least)| *count >= least), "{struck:?}");
    assert!(struck.undivided > 0, "{struck:?}");
}

#[test]
fn small_fragments_of_a_thin_cup_fill_their_parents() {
    check(&CUP, Point3::new(0.3, 0.1, 0.0), 60);
}

#[test]
fn small_fragments_of_a_fin_fill_their_parents() {
    check(&FIN, Point3::new(0.0, 0.4, 0.0), 90);
}

/// A fragment without a lattice of its own that can be divided, with the result that has it.
fn small(prepared: &PreparedObject, point_m: Point3<f64>, sites: u32) -> (RetainedFragments, u32, Point3<f64>) {
    let before = first(prepared, &request(point_m, sites));
    let kept = before.keep();
    let divides = |row: &&shatter_fracture::pipeline::FragmentRow| {
        let found = again(prepared, (&kept, row.id), &request(row.center_m.into(), 4));
        found.is_ok_and(|(outcome, is_small)| is_small && outcome.meshes().is_some_and(|own| own.fragments.len() > 2))
    };
    let row = before.fragments.iter().find(divides).unwrap();
    (kept.clone(), row.id, row.center_m.into())
}

#[test]
fn a_small_fragment_breaks_at_its_own_threshold() {
    for (prepared, point_m, sites) in [(&*CUP, Point3::new(0.3, 0.1, 0.0), 60), (&*FIN, Point3::new(0.0, 0.4, 0.0), 90)]
    {
        let (kept, fragment, center_m) = small(prepared, point_m, sites);
        for effect in [EffectKind::Examples, EffectKind::Elastic] {
            let strike = |factor: f64| {
                let mut strike = request(center_m, 1);
                strike.effects = strike.effects.without(effect);
                strike.degree = DegreeRequest::ClosedForm;
                strike.contacts[0].impulse_ns *= factor;
                again(prepared, (&kept, fragment), &strike).unwrap().0
            };
            let just = strike(1.0).threshold().impulse_factor;
            let (whole, broken) = (strike(0.5 * just), strike(3.0 * just));
            assert!(whole.meshes().is_none() && broken.meshes().unwrap().fragments.len() > 1);
            let ratio = broken.threshold().e1_over_gamma / whole.threshold().e1_over_gamma;
            assert!((ratio / 36.0 - 1.0).abs() < 1e-6, "{ratio}");
        }
    }
}

#[test]
fn a_small_fragment_breaks_alike_for_any_number_of_threads() {
    let (kept, fragment, center_m) = small(&FIN, Point3::new(0.0, 0.4, 0.0), 90);
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let children = again(&FIN, (&kept, fragment), &request(center_m, 4)).unwrap().0.into_meshes().unwrap();
            let emitted = children.emitted().unwrap();
            let bits: Vec<u32> = emitted.positions.iter().flatten().map(|x| x.to_bits()).collect();
            (bits, emitted.indices.clone(), children.fragments.clone())
        })
    };
    let one = bytes(1);
    assert!(one.2.len() > 2 && one == bytes(2) && one == bytes(4));
}

#[test]
fn effects_apply_to_the_children_of_a_small_fragment() {
    let (kept, fragment, center_m) = small(&FIN, Point3::new(0.0, 0.4, 0.0), 90);
    let output = [EffectKind::Release, EffectKind::Bonds, EffectKind::Debris, EffectKind::Hulls, EffectKind::Normals];
    let plain = request(center_m, 4);
    let effects = output.into_iter().fold(plain.effects, EffectSet::with);
    let strike = |effects| {
        let request = FractureRequest { effects, ..plain.clone() };
        again(&FIN, (&kept, fragment), &request).unwrap().0.into_meshes().unwrap()
    };
    let children = strike(effects);
    let momentum = |k: usize| children.velocities[k].linear_m_s * children.fragments[k].mass_kg;
    let sizes = (0..children.fragments.len()).map(|k| momentum(k).norm()).sum::<f64>();
    let sum: Vector3<f64> = (0..children.fragments.len()).map(momentum).sum();
    assert!(sizes > 0.0 && sum.norm() < 1e-9 * sizes);
    assert!(children.bonds().len() >= children.fragments.len() - 1);
    // Children smaller than a lattice cell are merged.
    let merged = strike(effects.with(EffectKind::Slivers));
    assert!(merged.fragments.len() < children.fragments.len());
}

#[test]
fn a_small_fragment_with_the_surface_of_the_lattice_is_refused() {
    let strike = FractureRequest { surface: SurfaceKind::Lattice, ..request(Point3::new(0.3, 0.1, 0.0), 120) };
    let before = first(&CUP, &strike);
    let smallest = before.fragments.iter().min_by(|a, b| a.volume_m3.total_cmp(&b.volume_m3)).unwrap();
    let error = again(&CUP, (&before.keep(), smallest.id), &request(smallest.center_m.into(), 4)).err().unwrap();
    assert!(matches!(error, FractureError::FragmentSmall { .. }) && error.to_string().contains("lattice"), "{error}");
}

#[test]
fn small_fragments_of_an_ear_fill_their_parents() {
    let Ok(folder) = std::env::var("SHATTER_MESHES") else {
        println!("skipped: SHATTER_MESHES is not set");
        return;
    };
    let mesh = read(&Path::new(&folder).join("stanford-bunny.obj"), LengthUnit::M, UpAxis::Y).unwrap();
    let prepared = baked(mesh, 0.025);
    let nodes = &prepared.bodies[0].cutting.as_ref().unwrap().mesh.nodes;
    let tip = nodes.iter().max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
    check(&prepared, prepared.frame.to_meters(tip), 150);
}
