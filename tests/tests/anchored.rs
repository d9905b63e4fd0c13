//! Anchors and weight in the engine: units, superposition, fixed nodes, errors.

use nalgebra::{Point3, Vector3};
use shatter_engine::scene::Scene;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::elasticity::{DrivingEnergy, ElasticWorkspace, ElasticityError, NodalLoad};
use shatter_fracture::pipeline::{
    AnchorError, ContactSet, DegreeRequest, DegreeSource, DisplacementMethod, FractureError, FractureRequest,
    PreparedObject, RANK_MAX, WORLD, reduce,
};
use shatter_fracture::scene::{Anchors, EffectKind, EffectSet, Region};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_tests::{real, struck};

/// Spacing of most elastic lattices here, over the diagonal.
const COARSE: f64 = 0.1;

const SIZE: [f64; 3] = [0.4, 0.2, 0.2];
const GRAVITY: [f64; 3] = [9.81, 0.0, 0.0];

/// The last 5 cm of the bar at its lower end along x.
fn end() -> Region {
    Region::Cuboid { min_m: Point3::new(-0.3, -0.3, -0.3), max_m: Point3::new(-0.15, 0.3, 0.3) }
}

/// A layer at that end: the rest of the bar hangs freely.
fn face() -> Region {
    Region::Cuboid { min_m: Point3::new(-0.3, -0.3, -0.3), max_m: Point3::new(-0.198, 0.3, 0.3) }
}

fn anchors(region: Region) -> Anchors {
    Anchors { regions: vec![region], gravity_m_s2: Some(GRAVITY.into()) }
}

/// A bar along x of glass, but with ν = 0.
fn bar_of(mesh: RawMesh, elastic_spacing: f64) -> PreparedObject {
    let mut request = BakeRequest {
        elastic_spacing: Some(elastic_spacing),
        crack_spacing: Some(0.6 * elastic_spacing),
        kappa: Some(1.0),
        ..real::request("bar", "glass")
    };
    request.material.poisson = 0.0;
    bake(mesh, &request, &CancelToken::default(), &mut |_| ()).unwrap()
}

fn bar(region: Region) -> PreparedObject {
    let mut prepared = bar_of(shapes::cuboid(SIZE), COARSE);
    prepared.anchor(&anchors(region), &CancelToken::default()).unwrap();
    prepared
}

/// An impact on the free end with `times` the impulse that breaks it.
fn request(times: f64, more: &[EffectKind]) -> FractureRequest {
    let effects = more.iter().fold(EffectSet::default(), |effects, effect| effects.with(*effect));
    let mut request =
        FractureRequest::at(Point3::new(0.2, 0.02, 0.01), Vector3::new(-50.0, 3.0, -5.0) * times).seeded(1);
    request.contacts[0].radius_m = Some(0.05);
    FractureRequest { effects, degree: DegreeRequest::Sites(24), ..request }
}

const HELD: [EffectKind; 2] = [EffectKind::Anchored, EffectKind::Gravity];

#[test]
fn the_weight_alone_has_the_energy_of_a_hanging_bar() {
    let material = real::material("glass");
    // ρ²g²AL³/(6E).
    let exact = (material.density_kg_m3 * GRAVITY[0]).powi(2) * 0.04 * 0.4f64.powi(3) / (6.0 * material.young_pa);
    // Lattices round the edges of the end off, so that anchors hold a little less than all of it.
    for (spacing, bound) in [(COARSE, 0.15), (0.5 * COARSE, 0.1)] {
        let mut fine = bar_of(shapes::cuboid(SIZE), spacing);
        fine.anchor(&anchors(face()), &CancelToken::default()).unwrap();
        let energy = struck::energy(&fine, &request(1e-9, &HELD));
        println!("spacing {spacing}: {} J, exact {exact} J", energy.energy_j);
        assert!((energy.energy_j / exact - 1.0).abs() < bound, "{} of {exact}", energy.energy_j);
        assert_eq!(energy.reduced_error, None);
    }
    let bar = bar(face());
    let [weak, strong] = [1e-13, 1e-10].map(|times| struck::energy(&bar, &request(times, &HELD)).energy_j);
    assert!((weak / strong - 1.0).abs() < 1e-6, "whatever the impact that it is relative to: {weak} and {strong}");
}

/// The sum of the pipeline equals one solve of both loads, also if only tension counts.
#[test]
fn impact_and_weight_superpose() {
    let bar = bar(end());
    let (solid, held) = (bar.solid(0).unwrap(), bar.held(request(1.0, &HELD).effects).unwrap().unwrap());
    let elasticity = &held.body(0).unwrap().elasticity;
    for (more, driving) in [(vec![], DrivingEnergy::Total), (vec![EffectKind::Tensile], DrivingEnergy::Tensile)] {
        // Weak enough for the weight to count.
        let request = request(0.02, &[&HELD[..], &more].concat());
        let own = struck::energy(&bar, &request);
        let impact = ContactSet::new(&bar, &request).unwrap();
        let (mut load, mut workspace, token) =
            (NodalLoad::default(), ElasticWorkspace::default(), CancelToken::default());
        elasticity.load(&impact.bodies[0].1, &mut load, &mut workspace).unwrap();
        let (alone, weight) = (load.forces.clone(), elasticity.weight(&GRAVITY.into()));
        load.forces.iter_mut().zip(&weight).for_each(|(f, w)| *f += w * impact.weight_unit(&bar));
        let energy = |forces: &[f64]| {
            let (mut displacement, mut energies, mut shares) = (Vec::new(), Vec::new(), Vec::new());
            let mut workspace = ElasticWorkspace::default();
            elasticity.solve(forces, &mut displacement, &mut workspace, &token).unwrap();
            elasticity.tet_energy(&solid.lattice, &displacement, driving, &mut energies, &token).unwrap();
            solid.transfer.apply(&energies, &mut shares);
            (shares, elasticity.elastic_energy(forces, &displacement))
        };
        let ((both, strain), (request_alone, _)) = (energy(&load.forces), energy(&alone));
        let total: f64 = both.iter().sum();
        let unit_j = impact.unit_j(&bar);
        assert!((own.energy_j / (total * unit_j) - 1.0).abs() < 1e-9, "{} of {}", own.energy_j, total * unit_j);
        let strain_j = own.strain_j.unwrap();
        assert!((strain_j / (strain * unit_j) - 1.0).abs() < 1e-9, "{strain_j} of {}", strain * unit_j);
        let worst = own.shares.iter().zip(&both).map(|(own, both)| (own - both / total).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9, "{worst:e}");
        assert!((request_alone.iter().sum::<f64>() / total - 1.0).abs() > 1e-6, "the weight counts");
    }
}

#[test]
fn without_the_effect_a_held_object_is_as_it_was() {
    let (free, held) = (bar_of(shapes::cuboid(SIZE), COARSE), bar(end()));
    let [before, after] = [&free, &held].map(|bar| struck::energy(bar, &request(1.0, &[])));
    assert_eq!(before, after);
    assert_ne!(struck::energy(&held, &request(1.0, &HELD[..1])).shares, after.shares);
    assert!(held.bytes() > free.bytes());
}

#[test]
fn a_body_that_no_anchor_reaches_is_free() {
    let mut both = shapes::cuboid(SIZE);
    let (other, first) = (shapes::cuboid(SIZE), both.positions_m.len() as u32);
    both.positions_m.extend(other.positions_m.iter().map(|point| point + Vector3::new(1.0, 0.0, 0.0)));
    both.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    let mut bars = bar_of(both, COARSE);
    bars.anchor(&anchors(end()), &CancelToken::default()).unwrap();
    assert_eq!(bars.bodies.len(), 2);
    let mut right = request(1.0, &HELD);
    right.contacts[0].point_m.x += 1.0;
    let free = FractureRequest { effects: EffectSet::default(), ..right.clone() };
    assert_eq!(struck::energy(&bars, &right), struck::energy(&bars, &free));
    let left = request(1.0, &HELD);
    assert_ne!(
        struck::energy(&bars, &left),
        struck::energy(&bars, &FractureRequest { effects: EffectSet::default(), ..left })
    );
}

#[test]
fn held_fragments_are_bonded_to_the_world_and_stand_still() {
    let bar = bar(end());
    let outputs = [HELD[0], EffectKind::Bonds, EffectKind::Release];
    let pieces = struck::outcome(&bar, &request(1.0, &outputs)).unwrap().into_meshes().unwrap();
    let bonds = pieces.bonds();
    assert_eq!(bonds.len(), pieces.bond_count());
    let world: Vec<_> = bonds.iter().filter(|bond| bond.fragments[1] == WORLD).collect();
    let area: f64 = world.iter().map(|bond| bond.area_m2).sum();
    // The end and four strips of 5 cm.
    let exact = 0.2 * 0.2 + 4.0 * 0.2 * 0.05;
    println!("{} of {} fragments held, {area} m² of {exact} m²", world.len(), pieces.fragments.len());
    assert!((area / exact - 1.0).abs() < 0.15, "{area} of {exact}");
    assert!(!world.is_empty() && world.len() < pieces.fragments.len());
    assert!(world.iter().all(|bond| bond.centroid_m.x < -0.14), "{world:?}");
    for (id, velocity) in pieces.velocities.iter().enumerate() {
        let still = velocity.linear_m_s == Vector3::zeros() && velocity.angular_rad_s == Vector3::zeros();
        assert_eq!(still, world.iter().any(|bond| bond.fragments[0] == id as u32), "fragment {id}");
    }
    let free = struck::outcome(&bar, &request(1.0, &outputs[1..])).unwrap().into_meshes().unwrap();
    assert!(free.bonds().iter().all(|bond| bond.fragments[1] != WORLD));
}

#[test]
fn an_anchored_body_uses_neither_basis_nor_examples() {
    let request = BakeRequest {
        elastic_spacing: Some(0.08),
        crack_spacing: Some(0.06),
        examples: 10,
        elastic: DisplacementMethod::Solve,
        ..real::request("arch", "ceramic")
    };
    let mut arch = bake(shapes::arch(), &request, &CancelToken::default(), &mut |_| ()).unwrap();
    arch.impacts = 160;
    reduce(&mut arch, RANK_MAX, &CancelToken::default()).unwrap();
    let ground = Region::Cuboid { min_m: Point3::new(-1.0, -0.1, -1.0), max_m: Point3::new(1.0, 0.08, 1.0) };
    arch.anchor(&Anchors { regions: vec![ground], gravity_m_s2: None }, &CancelToken::default()).unwrap();
    let (point, inward) = struck::surface_point(&arch, [0.5, 1.0, 0.5]);
    let just = FractureRequest { threshold_only: true, ..FractureRequest::at(point, inward).seeded(1) };
    let just = struck::outcome(&arch, &just).unwrap().threshold().impulse_factor;
    let hard = |effects| FractureRequest { effects, ..FractureRequest::at(point, inward * (8.0 * just)).seeded(1) };
    let free = struck::outcome(&arch, &hard(EffectSet::default())).unwrap();
    let held = struck::outcome(&arch, &hard(EffectSet::default().with(EffectKind::Anchored))).unwrap();
    assert!(free.threshold().reduced_error.is_some(), "there is a basis");
    assert_eq!((held.threshold().reduced_error, held.degree_source()), (None, DegreeSource::ClosedForm));
}

#[test]
fn invalid_anchors_are_rejected_by_name() {
    let mut bar = bar_of(shapes::cuboid(SIZE), COARSE);
    let refused = |bar: &mut PreparedObject, regions: Vec<Region>| {
        let refused = bar.anchor(&Anchors { regions, gravity_m_s2: None }, &CancelToken::default()).unwrap_err();
        assert!(bar.held.is_none(), "it is as it was");
        refused
    };
    let far = Region::Ball { center_m: Point3::new(3.0, 0.0, 0.0), radius_m: 0.5 };
    let empty = refused(&mut bar, vec![end(), far]);
    let AnchorError::Empty { region: 1, object_m, .. } = &empty else { panic!("{empty}") };
    let sizes_m = [0, 1, 2].map(|axis| object_m[1][axis] - object_m[0][axis]);
    assert!(sizes_m.iter().zip(SIZE).all(|(found, wanted)| (found / wanted - 1.0).abs() < 0.2), "{object_m:?}");
    assert!(empty.to_string().contains("anchors[1]") && empty.to_string().contains("0.5 m"), "{empty}");
    assert!(empty.to_string().contains("move it into the object, which extends from ["), "{empty}");
    let all = refused(&mut bar, vec![Region::Ball { center_m: Point3::origin(), radius_m: 9.0 }]);
    let nodes = bar.solid(0).unwrap().lattice.nodes.len();
    assert!(matches!(all, AnchorError::Whole { nodes: found } if found == nodes), "{all}");
    // A ball that contains a single node, at a corner of the lattice.
    let corner = bar.frame.to_meters(&bar.solid(0).unwrap().lattice.nodes[0]);
    let single = Region::Ball { center_m: corner, radius_m: 1e-4 };
    let loose = refused(&mut bar, vec![single]);
    let line = matches!(loose, AnchorError::Loose { body: 0, source: ElasticityError::AnchorsInLine { nodes: 1 }, .. });
    assert!(line && loose.to_string().contains("anchors[0]"), "{loose}");
}

#[test]
fn effects_without_their_tables_are_rejected() {
    let refused = |bar: &PreparedObject, strike: &FractureRequest| struck::outcome(bar, strike).err().unwrap();
    let mut bar = bar_of(shapes::cuboid(SIZE), COARSE);
    let error = refused(&bar, &request(1.0, &HELD));
    assert!(matches!(error, FractureError::AnchorsUnprepared { effect: EffectKind::Anchored }), "{error}");
    bar.anchor(&Anchors { gravity_m_s2: None, ..anchors(end()) }, &CancelToken::default()).unwrap();
    let error = refused(&bar, &request(1.0, &HELD));
    assert!(matches!(error, FractureError::AnchorsUnprepared { effect: EffectKind::Gravity }), "{error}");
    // All of its load acts on nodes that do not move.
    let mut low = request(1.0, &HELD[..1]);
    low.contacts[0].point_m.x = -0.2;
    low.contacts[0].radius_m = Some(0.01);
    let wide = Region::Cuboid { min_m: Point3::new(-0.3, -0.3, -0.3), max_m: Point3::new(0.0, 0.3, 0.3) };
    bar.anchor(&anchors(wide), &CancelToken::default()).unwrap();
    let error = refused(&bar, &low);
    assert!(matches!(error, FractureError::Balanced { body: 0 }), "{error}");
}

/// The threshold scales the impulse only: the weight stays.
#[test]
fn the_threshold_scales_the_impact_but_not_the_weight() {
    let bar = bar(end());
    let only = |effects: &[EffectKind]| FractureRequest { threshold_only: true, ..request(1.0, effects) };
    let just = struck::outcome(&bar, &only(&HELD)).unwrap().threshold().impulse_factor;
    let light = struck::outcome(&bar, &only(&HELD[..1])).unwrap().threshold().impulse_factor;
    println!("{just} of the impact, {light} without weight");
    let e1 = |times: f64| struck::outcome(&bar, &FractureRequest { threshold_only: true, ..request(times, &HELD) });
    let found = e1(just).unwrap().threshold().e1_over_gamma;
    assert!((found - 1.0).abs() < 1e-4 && just != light, "{found}");
    // With a threshold far below the energy of its weight the bar breaks by itself.
    let weak = FractureRequest { gamma_j_m2: Some(1e-12), ..only(&HELD) };
    assert_eq!(struck::outcome(&bar, &weak).unwrap().threshold().impulse_factor, 0.0);
}

/// The arch of the shipped scene stands on its feet, and stays whole under its weight.
#[test]
fn the_shipped_arch_stands() {
    let scene = Scene::parse(include_str!("../../config/scenes/stone_arch.toml"), std::path::Path::new("")).unwrap();
    let object = &scene.objects["arch"];
    let (mesh, request) = object.bake("arch").unwrap();
    let coarse = BakeRequest { elastic_spacing: Some(0.06), crack_spacing: Some(0.05), kappa: Some(1.0), ..request };
    let mut arch = bake(mesh, &coarse, &CancelToken::default(), &mut |_| ()).unwrap();
    let anchored_nodes = arch.anchor_nodes(&object.terms.anchors).unwrap();
    assert!(
        anchored_nodes.counts.len() == 2 && anchored_nodes.counts.iter().all(|count| *count >= 8),
        "{:?}",
        anchored_nodes.counts
    );
    object.terms.anchor(&mut arch).unwrap();
    let effects = EffectSet::default().with(EffectKind::Tensile).with(EffectKind::Anchored).with(EffectKind::Gravity);
    let touch = FractureRequest {
        effects,
        ..FractureRequest::at(Point3::new(0.0, 1.0, 0.0), Vector3::new(0.0, -1e-9, 0.0)).seeded(1)
    };
    let outcome = struck::outcome(&arch, &touch).unwrap();
    println!("E_1/gamma of its weight {:.2e}", outcome.threshold().e1_over_gamma);
    assert!(outcome.meshes().is_none() && outcome.threshold().e1_over_gamma > 0.0);
}
