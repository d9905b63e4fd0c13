//! Striking fragments again: children stay inside their parent, their volumes add up to its volume, and distances do
//! not cross a crack.

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::centroidal::{self, DiagramOptions, EnergyField};
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::fragment::closed;
use shatter_fracture::lattice::{EnergyTransfer, NO_INDEX, block};
use shatter_fracture::lift::LiftKind;
use shatter_fracture::pipeline::{
    self, DegreeRequest, DisplacementMethod, ElementChoice, FractureError, FractureMeshes, FractureOutcome,
    FractureRequest, OUTER, PreparedObject, RequestContext, RetainedFragments, SurfaceKind, Workspace, strike_again,
};
use shatter_fracture::scene::{EffectKind, EffectSet, Materials};
use shatter_fracture::surface::{RawMesh, shapes};
use std::sync::LazyLock;

/// A ring of round bar with a gap, 20 mm thick, with its tips at the bottom.
static HORSESHOE: LazyLock<PreparedObject> = LazyLock::new(|| prepared(shapes::horseshoe(), 0.025));

/// A bar of 0.4 × 0.2 × 0.2 m with a slit from the top to its middle, two spacings wide.
static SLIT: LazyLock<PreparedObject> = LazyLock::new(|| prepared(slit_bar(0.02), 0.04));

fn prepared(mesh: RawMesh, crack_spacing: f64) -> PreparedObject {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let glass = materials.get("glass").unwrap().clone();
    let request = BakeRequest {
        elastic_spacing: Some(2.0 * crack_spacing),
        crack_spacing: Some(crack_spacing),
        kappa: Some(2.0),
        seed: 1,
        ..BakeRequest::new("thing", "glass", glass)
    };
    bake(mesh, &request, &CancelToken::default(), &mut |_| {}).unwrap()
}

/// The outline of a U, extruded along z. The slit is `2 · half` wide.
fn slit_bar(half: f64) -> RawMesh {
    let outline: [[f64; 2]; 8] =
        [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [half, 0.1], [half, 0.0], [-half, 0.0], [-half, 0.1], [-0.2, 0.1]];
    let cap = [[1, 2, 3], [1, 3, 4], [0, 1, 4], [0, 4, 5], [0, 5, 6], [0, 6, 7]];
    let layer = |z: f64| outline.map(|[x, y]| Point3::new(x, y, z));
    let mut triangles: Vec<[u32; 3]> = cap.map(|[a, b, c]| [c, b, a]).to_vec();
    triangles.extend(cap.map(|corners| corners.map(|corner| corner + 8)));
    for k in 0..8 {
        let next = (k + 1) % 8;
        triangles.extend([[k, next, next + 8], [k, next + 8, k + 8]]);
    }
    RawMesh::new([layer(-0.1), layer(0.1)].concat(), triangles)
}

/// A request for `sites` sites at the extreme point of an object or fragment in the direction `towards`.
fn request(points: &[Point3<f64>], towards: Vector3<f64>, sites: u32) -> FractureRequest {
    let along = |point: &&Point3<f64>| point.coords.dot(&towards);
    let point = points.iter().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap();
    let mut strike = FractureRequest::at(*point, -towards).seeded(1);
    strike.degree = DegreeRequest::Sites(sites);
    strike
}

/// Emitted data of one fragment, in the coordinates of the file.
struct Shown {
    points: Vec<Point3<f64>>,
    /// Area of cracks without a neighbor, and of the outer surface, m².
    old_crack_m2: f64,
    outer_m2: f64,
}

/// The emitted fragments of a result; each must be closed.
fn shown(pieces: &FractureMeshes) -> Vec<Shown> {
    let counts = pieces.counts;
    let (mut positions, mut indices) = (vec![[0.0; 3]; counts.vertices], vec![0; counts.indices]);
    pieces.emit(&mut positions, &mut indices, &mut vec![[0; 2]; counts.merges]).unwrap();
    let show = |row: &pipeline::FragmentRow| {
        let own = &positions[row.vertex_first as usize..][..row.vertex_count as usize];
        closed(own, &indices[row.index_first as usize..][..row.index_count as usize]).unwrap();
        let center = Vector3::from(row.center_m);
        let points: Vec<Point3<f64>> = own.iter().map(|at| Point3::from(at.map(f64::from)) + center).collect();
        let runs = || pieces.runs[row.run_first as usize..][..row.run_count as usize].iter();
        let area = |run: &pipeline::RunRow| -> f64 {
            let corners = indices[run.index_first as usize..][..run.index_count as usize].chunks_exact(3);
            let [a, b, c] = [0, 1, 2];
            corners
                .map(|corner| [a, b, c].map(|k: usize| points[corner[k] as usize]))
                .map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm())
                .sum()
        };
        Shown {
            old_crack_m2: runs().filter(|run| run.crack && run.neighbor == OUTER).map(area).sum(),
            outer_m2: runs().filter(|run| !run.crack).map(area).sum(),
            points,
        }
    };
    pieces.fragments.iter().map(show).collect()
}

/// The meshes of the fragments of a result, in the coordinates of the file.
fn meshes(pieces: &FractureMeshes) -> Vec<RawMesh> {
    let counts = pieces.counts;
    let (mut positions, mut indices) = (vec![[0.0; 3]; counts.vertices], vec![0; counts.indices]);
    pieces.emit(&mut positions, &mut indices, &mut vec![[0; 2]; counts.merges]).unwrap();
    let mesh = |row: &pipeline::FragmentRow| {
        let center = Vector3::from(row.center_m);
        let own = &positions[row.vertex_first as usize..][..row.vertex_count as usize];
        let triangles = indices[row.index_first as usize..][..row.index_count as usize].as_chunks().0.to_vec();
        RawMesh::new(own.iter().map(|at| Point3::from(at.map(f64::from)) + center).collect(), triangles)
    };
    pieces.fragments.iter().map(mesh).collect()
}

fn first(prepared: &PreparedObject, strike: &FractureRequest) -> FractureMeshes {
    let outcome = pipeline::strike(
        pipeline::RequestContext::new(prepared, strike, &CancelToken::default(), &()),
        &mut Workspace::default(),
    )
    .unwrap();
    outcome.into_meshes().unwrap()
}

fn again(
    prepared: &PreparedObject,
    kept: &RetainedFragments,
    fragment: u32,
    strike: &FractureRequest,
) -> Result<FractureOutcome, FractureError> {
    strike_again(
        RequestContext::new(prepared, strike, &CancelToken::default(), &()),
        (kept, fragment),
        &mut Workspace::default(),
    )
}

/// Total volume of the fragments, m³.
fn volume(pieces: &FractureMeshes) -> f64 {
    pieces.fragments.iter().map(|row| row.volume_m3).sum()
}

/// Strikes a fragment again and returns the children. Their volumes and outer areas must add up to the parent's, and
/// one must touch an earlier crack.
#[track_caller]
fn check(
    prepared: &PreparedObject,
    before: &FractureMeshes,
    fragment: u32,
    strike: &FractureRequest,
) -> FractureMeshes {
    let children = again(prepared, &before.keep(), fragment, strike).unwrap().into_meshes().unwrap();
    let (parent, own) = (&before.fragments[fragment as usize], shown(&children));
    let error = volume(&children) / parent.volume_m3 - 1.0;
    println!("fragment {fragment}: {} children, volume off by {error:.1e}", own.len());
    assert!(error.abs() < 1e-6, "{error:e}");
    assert!(children.fragments.iter().enumerate().all(|(id, row)| row.id as usize == id && row.body == parent.body));
    let before = &shown(before)[fragment as usize];
    let outer: f64 = own.iter().map(|child| child.outer_m2).sum();
    assert!((outer - before.outer_m2).abs() < 1e-6 * before.outer_m2.max(1e-6), "{outer} {}", before.outer_m2);
    assert!(own.iter().any(|child| child.old_crack_m2 > 0.0), "a child touches the first crack");
    let side = |crack: bool| children.runs.iter().filter(|run| run.crack == crack && run.neighbor == OUTER).count();
    assert!(side(true) > 0 || side(false) > 0);
    children
}

/// The horseshoe broken near one tip, and its largest fragment.
fn cut_horseshoe() -> (FractureMeshes, u32) {
    let tip = [Point3::new(0.023, -0.065, 0.0)];
    let pieces = first(&HORSESHOE, &request(&tip, Vector3::new(1.0, -1.0, 0.0), 4));
    let largest = pieces.fragments.iter().max_by(|a, b| a.volume_m3.total_cmp(&b.volume_m3)).unwrap().id;
    (pieces, largest)
}

#[test]
fn child_fragments_fill_their_parent() {
    let (pieces, _) = cut_horseshoe();
    let all = shown(&pieces);
    let mut struck = 0;
    for (fragment, own) in all.iter().enumerate() {
        for (sites, towards) in [(2, Vector3::y()), (9, Vector3::new(0.3, -1.0, 0.4)), (40, Vector3::x())] {
            let strike = request(&own.points, towards, sites);
            match again(&HORSESHOE, &pieces.keep(), fragment as u32, &strike) {
                Err(FractureError::FragmentUndivided { .. }) => {}
                _ => {
                    check(&HORSESHOE, &pieces, fragment as u32, &strike);
                    struck += 1;
                }
            }
        }
    }
    assert!(struck >= 6, "{struck}");
}

#[test]
fn no_child_joins_separate_limbs_of_the_parent() {
    let (pieces, largest) = cut_horseshoe();
    let own = &shown(&pieces)[largest as usize];
    let spanning = |lift: LiftKind| {
        let count = |seed: u64| {
            let strike = FractureRequest { lift, seed, ..request(&own.points, Vector3::new(-1.0, -1.0, 0.0), 5) };
            let children = check(&HORSESHOE, &pieces, largest, &strike);
            let joins = |child: &Shown| {
                let low = || child.points.iter().filter(|point| point.y < -0.03);
                low().any(|point| point.x < -0.01) && low().any(|point| point.x > 0.01)
            };
            shown(&children).iter().filter(|child| joins(child)).count()
        };
        (0..6).map(count).sum::<usize>()
    };
    assert_eq!(spanning(LiftKind::Interior), 0);
}

/// A strip of one cell and a half across, broken in two: its fragments have its elements.
#[test]
fn fragments_of_thin_bodies_bend() {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let bake = BakeRequest {
        elastic: DisplacementMethod::Solve,
        surface: SurfaceKind::Lattice,
        elastic_spacing: Some(0.03),
        crack_spacing: Some(0.03),
        kappa: Some(2.0),
        ..BakeRequest::new("strip", "glass", materials.get("glass").unwrap().clone())
    };
    let strain_j = |elements: ElementChoice| {
        let strip = BakeRequest { elements, ..bake.clone() }.bake(shapes::cuboid([0.4, 0.06, 0.02])).unwrap();
        let pieces = first(&strip, &request(&[Point3::new(0.0, 0.0, 0.01)], Vector3::z(), 2));
        let middle = Point3::new(pieces.fragments[0].center_m[0], 0.0, 0.01);
        let strike = request(&[middle], Vector3::z(), 2);
        again(&strip, &pieces.keep(), 0, &strike).unwrap().threshold().strain_j.unwrap()
    };
    let [linear, quadratic] = [ElementChoice::Linear, ElementChoice::Auto].map(strain_j);
    assert!(quadratic > 1.15 * linear, "{linear} J, {quadratic} J");
}

/// Energies of fragments, and what they tell of their errors, against the same meshes baked as objects of their own.
#[track_caller]
fn check_energies(crack_spacing: f64, sites: u32) {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let bake = |name: &str, elastic_spacing: f64, crack_spacing: f64| BakeRequest {
        elastic: DisplacementMethod::Solve,
        surface: SurfaceKind::Lattice,
        elastic_spacing: Some(elastic_spacing),
        crack_spacing: Some(crack_spacing),
        kappa: Some(2.0),
        ..BakeRequest::new(name, "glass", materials.get("glass").unwrap().clone())
    };
    let plate = bake("plate", 0.04, crack_spacing).bake(shapes::cuboid([0.3, 0.24, 0.03])).unwrap();
    let pieces = first(&plate, &request(&[Point3::new(0.0, 0.0, 0.015)], Vector3::z(), sites));
    let is_large = |row: &pipeline::FragmentRow| {
        row.volume_m3 / volume(&pieces) * plate.crack_nodes() as f64 > pipeline::SOLVED_NODES_MAX as f64
    };
    let (mut errors, mut covered) = (Vec::new(), 0);
    let judged = pieces.fragments.iter().zip(meshes(&pieces));
    for (row, own) in judged.filter(|(row, _)| is_large(row) == (crack_spacing < 0.03)) {
        let center = Point3::from(row.center_m);
        let top = own.positions_m.iter().filter(|point| point.z > 0.0149);
        let near = *top.min_by(|a, b| (*a - center).norm().total_cmp(&(*b - center).norm())).unwrap();
        let mut strike = request(&[near], Vector3::z(), 2);
        strike.contacts[0].radius_m = Some(0.012);
        let object = bake("piece", 0.06, 0.06).bake(own).unwrap();
        let expected = pipeline::strike(
            RequestContext::new(&object, &strike, &CancelToken::default(), &()),
            &mut Workspace::default(),
        );
        let expected = expected.unwrap().threshold().strain_j.unwrap();
        let found = again(&plate, &pieces.keep(), row.id, &strike).unwrap();
        let error = (found.threshold().strain_j.unwrap() / expected - 1.0).abs();
        let told = found.threshold().discretization_error.unwrap();
        println!("fragment {}: {error:.3} off, told {told:.3}", row.id);
        errors.push(error);
        covered += usize::from(told >= 0.5 * error);
    }
    errors.sort_by(f64::total_cmp);
    assert!(errors.len() >= 4 && errors[errors.len() / 2] < 0.1, "{errors:?}");
    assert!(10 * covered >= 8 * errors.len(), "{errors:?}");
}

#[test]
fn energies_of_fragments_are_those_of_their_meshes() {
    check_energies(0.04, 8);
}

/// Their displacements are those of the elastic lattice.
#[test]
fn energies_of_large_fragments_are_those_of_their_meshes() {
    check_energies(0.02, 6);
}

#[test]
fn grandchild_fragments_fill_their_parent() {
    let (pieces, largest) = cut_horseshoe();
    let own = &shown(&pieces)[largest as usize];
    let children = check(&HORSESHOE, &pieces, largest, &request(&own.points, Vector3::y(), 6));
    let mut struck = 0;
    for (child, own) in shown(&children).iter().enumerate() {
        let strike = request(&own.points, Vector3::new(0.2, 1.0, 0.1), 5);
        if again(&HORSESHOE, &children.keep(), child as u32, &strike).is_ok() {
            let grown = check(&HORSESHOE, &children, child as u32, &strike);
            struck += usize::from(grown.fragments.len() > 1);
        }
    }
    assert!(struck >= 3, "{struck}");
}

#[test]
fn volumes_add_up_over_many_generations() {
    let mut before = first(&SLIT, &request(&[Point3::new(0.2, 0.0, 0.0)], Vector3::x(), 6));
    for generation in 0..5 {
        let largest = before.fragments.iter().max_by(|a, b| a.volume_m3.total_cmp(&b.volume_m3)).unwrap().id;
        let own = &shown(&before)[largest as usize];
        let towards = [Vector3::x(), Vector3::y(), Vector3::z()][generation % 3];
        before = check(&SLIT, &before, largest, &request(&own.points, towards, 4));
    }
}

#[test]
fn volumes_add_up_where_many_cracks_meet() {
    let pieces = first(&SLIT, &request(&[Point3::new(0.2, 0.0, 0.0)], Vector3::x(), 24));
    let all = shown(&pieces);
    let mut struck = 0;
    for (fragment, own) in all.iter().enumerate() {
        let elastic = request(&own.points, Vector3::y(), 24);
        let falloff = FractureRequest { effects: EffectSet::default().without(EffectKind::Elastic), ..elastic.clone() };
        for strike in [elastic, falloff] {
            if again(&SLIT, &pieces.keep(), fragment as u32, &strike).is_ok() {
                check(&SLIT, &pieces, fragment as u32, &strike);
                struck += 1;
            }
        }
    }
    assert!(struck > 20, "{struck}");
}

#[test]
fn effects_apply_to_children_as_to_fragments() {
    let (pieces, largest) = cut_horseshoe();
    let own = &shown(&pieces)[largest as usize];
    // The parent has no skin, and the response to a pulse is refused.
    let all = EffectSet::of(EffectKind::ALL).without(EffectKind::Skin).without(EffectKind::Dynamics);
    let strike = FractureRequest { effects: all, ..request(&own.points, Vector3::y(), 60) };
    let children = again(&HORSESHOE, &pieces.keep(), largest, &strike).unwrap().into_meshes().unwrap();
    let plain = FractureRequest { effects: EffectSet::default().without(EffectKind::Slivers), ..strike.clone() };
    let many = again(&HORSESHOE, &pieces.keep(), largest, &plain).unwrap().into_meshes().unwrap();
    assert!(children.fragments.len() < many.fragments.len(), "slivers are merged");
    assert!((volume(&children) / pieces.fragments[largest as usize].volume_m3 - 1.0).abs() < 1e-6);
    shown(&children);
    assert_eq!(children.velocities.len(), children.fragments.len());
    let momentum = |k: usize| children.velocities[k].linear_m_s * children.fragments[k].mass_kg;
    let sizes = (0..children.fragments.len()).map(|k| momentum(k).norm()).sum::<f64>();
    let sum: Vector3<f64> = (0..children.fragments.len()).map(momentum).sum();
    assert!(sizes > 0.0 && sum.norm() < 1e-9 * sizes);
    assert!(children.bonds().iter().all(|bond| bond.fragments[1] < children.fragments.len() as u32));
    assert_eq!((children.debris().len(), children.bonds().len()), (children.debris_count(), children.bond_count()));
}

#[test]
fn a_second_strike_has_the_same_bytes_for_any_number_of_threads() {
    let (pieces, largest) = cut_horseshoe();
    let strike = request(&shown(&pieces)[largest as usize].points, Vector3::y(), 20);
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let children = again(&HORSESHOE, &pieces.keep(), largest, &strike).unwrap().into_meshes().unwrap();
            let points: Vec<u64> = shown(&children)
                .iter()
                .flat_map(|child| child.points.iter().flat_map(|point| point.coords.iter().map(|x| x.to_bits())))
                .collect();
            (points, children.fragments.clone(), children.runs.clone())
        })
    };
    assert!(bytes(1) == bytes(5));
}

#[test]
fn thresholds_and_energies_are_the_fragments_own() {
    let (pieces, largest) = cut_horseshoe();
    let own = &shown(&pieces)[largest as usize];
    let strike = |factor: f64| {
        let mut strike = request(&own.points, Vector3::y(), 1);
        strike.degree = DegreeRequest::Inferred;
        strike.contacts[0].impulse_ns *= factor;
        again(&HORSESHOE, &pieces.keep(), largest, &strike).unwrap()
    };
    let just = strike(1.0).threshold().impulse_factor;
    let (whole, broken) = (strike(0.5 * just), strike(3.0 * just));
    assert!(whole.meshes().is_none() && whole.fracture_degree() == 1);
    assert!(broken.fracture_degree() >= 2 && broken.meshes().unwrap().fragments.len() >= 2);
    assert!((broken.threshold().e1_over_gamma / whole.threshold().e1_over_gamma / 36.0 - 1.0).abs() < 1e-6);
    let falloff = FractureRequest {
        effects: EffectSet::default().without(EffectKind::Elastic),
        ..request(&own.points, Vector3::y(), 9)
    };
    check(&HORSESHOE, &pieces, largest, &falloff);
}

#[test]
fn invalid_repeated_requests_are_rejected_by_name() {
    let (pieces, largest) = cut_horseshoe();
    let own = &shown(&pieces)[largest as usize];
    let kept = pieces.keep();
    let count = pieces.fragments.len() as u32;
    let strike = request(&own.points, Vector3::y(), 4);
    let dynamic = FractureRequest { effects: strike.effects.with(EffectKind::Dynamics), ..strike.clone() };
    assert_eq!(kept.fragments(), count);
    assert!(kept.bytes() > 4 * HORSESHOE.crack_nodes());
    for (prepared, fragment, strike, words) in [
        (&*HORSESHOE, count, strike.clone(), "the result has"),
        (&*HORSESHOE, u32::MAX, strike.clone(), "the result has"),
        (&*SLIT, largest, strike.clone(), "belong to another object"),
        (&*HORSESHOE, largest, FractureRequest { lift: LiftKind::SurfaceDiffusion, ..strike.clone() }, "has no lift"),
        (&*HORSESHOE, largest, request(&[Point3::new(9.0, 0.0, 0.0)], Vector3::x(), 4), "from the surface"),
        (&*HORSESHOE, largest, dynamic, "`dynamics` is for whole objects"),
    ] {
        let error = again(prepared, &kept, fragment, &strike).err().unwrap();
        assert!(error.to_string().contains(words), "{error}");
        assert_eq!(error.is_callers(), words != "belong to another object", "{error}");
    }
    let surface = SurfaceKind::Lattice;
    let many = first(&HORSESHOE, &FractureRequest { degree: DegreeRequest::Sites(512), surface, ..strike });
    let smallest = many.fragments.iter().min_by(|a, b| a.volume_m3.total_cmp(&b.volume_m3)).unwrap().id;
    let point = &shown(&many)[smallest as usize].points;
    let error = again(&HORSESHOE, &many.keep(), smallest, &request(point, Vector3::y(), 4)).err().unwrap();
    assert!(error.is_callers() && error.to_string().contains("too small"), "{error}");
}

#[test]
fn a_part_of_a_body_gets_all_energy_of_its_elastic_tetrahedra() {
    let (elastic, crack) = (block([3, 2, 2], 0.2), block([6, 4, 4], 0.1));
    let transfer = EnergyTransfer::between(&elastic, &crack);
    let left = |x: f64| x < 0.05;
    let number = |kept: Vec<bool>| -> Vec<u32> {
        let mut next = 0..;
        kept.into_iter().map(|kept| if kept { next.next().unwrap() } else { NO_INDEX }).collect()
    };
    let nodes = number(crack.nodes.iter().map(|node| left(node.x)).collect());
    let tets = number((0..elastic.tets.len()).map(|tet| elastic.corners(tet).iter().all(|at| left(at.x))).collect());
    let count = |names: &[u32]| names.iter().filter(|name| **name != NO_INDEX).count();
    let part = transfer.part(&nodes, &tets);
    assert_eq!(part.offsets.len(), count(&nodes) + 1);
    let energies: Vec<f64> = (0..count(&tets)).map(|tet| 1.0 + tet as f64).collect();
    let mut shares = Vec::new();
    part.apply(&energies, &mut shares);
    let (given, got): (f64, f64) = (energies.iter().sum(), shares.iter().sum());
    assert!((got / given - 1.0).abs() < 1e-12 && shares.iter().all(|share| *share >= 0.0), "{got} of {given}");
}

/// True if points near the mouth of the slit are on both of its sides.
fn spans_the_mouth(points: impl Iterator<Item = Point3<f64>>) -> bool {
    let mouth: Vec<f64> = points.filter(|point| point.y > 0.06).map(|point| point.x).collect();
    mouth.iter().any(|x| *x < -0.015) && mouth.iter().any(|x| *x > 0.015)
}

/// Number of fragments, and of cells of their diagrams, on both sides of the slit's mouth, over eight requests beside
/// it.
fn across_the_slit(lift: LiftKind) -> [usize; 2] {
    let mut across = [0; 2];
    for seed in 0..8 {
        let mut strike = FractureRequest::at(Point3::new(0.06, 0.1, 0.0), Vector3::new(0.0, -1.0, 0.0)).seeded(1);
        (strike.degree, strike.lift, strike.seed) = (DegreeRequest::Sites(8), lift, seed);
        let fragments = shown(&first(&SLIT, &strike));
        across[0] += fragments.iter().filter(|own| spans_the_mouth(own.points.iter().copied())).count();
        let labels = cells(&SLIT, &strike);
        let place = |node: usize| SLIT.frame.to_meters(&SLIT.bodies[0].crack.nodes[node]);
        for cell in 0..8 {
            let own = (0..labels.len()).filter(|&node| labels[node] == cell);
            across[1] += usize::from(spans_the_mouth(own.map(place)));
        }
    }
    across
}

/// The cell of each node of the only body.
fn cells(prepared: &PreparedObject, strike: &FractureRequest) -> Vec<u32> {
    let (mut workspace, token) = (Workspace::default(), CancelToken::default());
    let impact = pipeline::ContactSet::new(prepared, strike).unwrap();
    let mut energies =
        pipeline::strain_energy(pipeline::RequestContext::new(prepared, strike, &token, &()), &impact, &mut workspace)
            .unwrap();
    let mut shares = std::mem::take(&mut energies[0].shares);
    let field =
        EnergyField::new(prepared.lift(0, strike.lift).unwrap(), &prepared.bodies[0].volumes, &mut shares).unwrap();
    centroidal::diagram(&field, &DiagramOptions::new(8, strike.seed), &mut Default::default(), &token).unwrap().labels
}

#[test]
fn nothing_spans_the_mouth_of_a_slit_but_straight_distances() {
    let [interior, straight] = [LiftKind::Interior, LiftKind::Euclidean].map(across_the_slit);
    println!("fragments and cells across the slit: interior {interior:?}, euclidean {straight:?}");
    assert_eq!(interior, [0; 2]);
    assert!(straight.iter().all(|across| *across > 0));
}
