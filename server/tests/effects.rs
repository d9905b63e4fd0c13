//! Effects through the whole service: an effect that is off costs and changes nothing; one that is on does what its name promises.

mod support;

use shatter_client::{
    Bond, Contact, DegreeRule, Effect, EffectCost, Effects, ErrorKind, FractureResult, Fragment, FragmentVelocity,
    Impact, Lift, Object, StageCost, StageKind,
};
use shatter_engine::scene::Scene;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::{Arc, LazyLock};
use support::{InProcess, TestDirectory, bar, shatter_program, timeout};

/// Database of a bar, baked once for all tests: the bytes of the file.
static BAR: LazyLock<Vec<u8>> = LazyLock::new(|| bar(0.05));

/// Effects that change only their own section of the result. Two of them also copy vertices on seams, which the bar does not have.
const OUTPUTS: [Effect; 8] = [
    Effect::Release,
    Effect::Normals,
    Effect::Uv,
    Effect::Bonds,
    Effect::Debris,
    Effect::Hulls,
    Effect::Attributes,
    Effect::Skin,
];

/// The scene holds the bar below this x, m: the last 5 cm of its lower end.
const HELD_BELOW: f64 = -0.15;

fn start() -> (InProcess, Object) {
    start_with(None)
}

/// Starts a daemon with a scene that holds the bar if a request enables that, and that allows every effect.
fn start_held() -> (InProcess, Object) {
    start_held_in("interior")
}

/// As [`start_held`], with the tables of another lift.
fn start_held_in(lift: &str) -> (InProcess, Object) {
    // The effect `warp` needs an artist's controls: see the tests of warps.
    let names = Effect::ALL.into_iter().filter(|effect| *effect != Effect::Warp);
    let names = names.map(|effect| format!("\"{}\"", effect.name())).collect::<Vec<_>>().join(", ");
    let anchor = format!("{{ min = [-0.3, -0.3, -0.3], max = [{HELD_BELOW}, 0.3, 0.3] }}");
    let scene = format!("[objects.bar]\nlift = \"{lift}\"\nallow = [{names}]\nanchors = [{anchor}]");
    start_with(Some(Scene::parse(&scene, Path::new("")).unwrap()))
}

fn start_with(scene: Option<Scene>) -> (InProcess, Object) {
    let here = TestDirectory::new("effects");
    std::fs::write(here.databases().join("bar.shatter"), BAR.as_slice()).unwrap();
    let (name, load) = (scene.is_some().then_some("bar"), shatter_engine::wire::loader(scene));
    let daemon = InProcess::start_with(here, "", Arc::new(move |path, _| load(path, name)));
    let bar = daemon.connect().object("bar", timeout()).unwrap();
    (daemon, bar)
}

/// An impact on the end of the bar that breaks it.
fn base_impact() -> Impact {
    Impact::new([Contact::new([0.2, 0.0, 0.0]).impulse([-50.0, 3.0, 0.0]).radius(0.05)])
        .degree(DegreeRule::Sites(24))
        .seed(3)
}

fn strike(bar: &Object, impact: &Impact) -> FractureResult {
    bar.strike(impact).unwrap().wait(timeout()).unwrap()
}

/// The effect, and the effects that it needs.
fn needed(effect: Effect) -> Vec<Effect> {
    effect.needs().map_or(Vec::new(), needed).into_iter().chain([effect]).collect()
}

fn with(effects: &[Effect]) -> Impact {
    effects.iter().fold(base_impact(), |impact, effect| impact.enable(*effect))
}

/// Hashes of all sections except the one that reports which effects ran.
fn hashes(result: &FractureResult) -> BTreeMap<&'static str, String> {
    let sections = result.digest().sections.into_iter().filter(|section| section.name != "effects");
    sections.map(|section| (section.name, section.hash)).collect()
}

/// Sections of an output effect.
fn sections(effect: Effect) -> Vec<&'static str> {
    match effect {
        Effect::Release => vec!["velocities"],
        Effect::Uv => vec!["uvs"],
        Effect::Hulls => vec!["hulls", "hull_positions", "hull_indices"],
        // The bar has no materials.
        Effect::Attributes => vec!["outer_attributes"],
        Effect::Skin => vec!["skins", "skin_vertices", "skin_indices"],
        other => vec![other.name()],
    }
}

fn sum(terms: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    terms.fold([0.0; 3], |sum, term| [0, 1, 2].map(|k| sum[k] + term[k]))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn disabled_effects_cost_nothing() {
    let (_daemon, bar) = start_held();
    let check = |impact: Impact, on: Effects| {
        let result = strike(&bar, &impact);
        assert!(result.effects().map(|cost| cost.effect).eq(Effect::ALL));
        for cost in result.effects() {
            assert_eq!(cost.has_run, on.has(cost.effect), "{} {impact:?}", cost.effect.name());
            assert!(cost.has_run || cost == EffectCost::idle(cost.effect), "{cost:?}");
        }
        let extra = result
            .digest()
            .sections
            .into_iter()
            .map(|section| section.name)
            .filter(|name| OUTPUTS.into_iter().any(|effect| sections(effect).contains(name)));
        let wanted = OUTPUTS.into_iter().filter(|effect| on.has(*effect)).flat_map(sections);
        assert_eq!(extra.collect::<Vec<_>>(), wanted.collect::<Vec<_>>());
    };
    // The request has a number of sites, so that the examples do not run.
    let usual = Effects::of([Effect::Elastic, Effect::Interior, Effect::Slivers]);
    check(base_impact(), usual);
    for effect in usual.iter() {
        check(base_impact().disable(effect), Effects::of(usual.iter().filter(|other| *other != effect)));
    }
    check(usual.iter().fold(base_impact(), Impact::disable), Effects::default());
    // The bar has neither controls nor a basis.
    let others = [Effect::Warp, Effect::Dynamics];
    for effect in Effect::ALL.into_iter().filter(|effect| !effect.default_on() && !others.contains(effect)) {
        check(with(&needed(effect)), Effects::of(usual.iter().chain(needed(effect))));
    }
    check(with(&OUTPUTS), Effects::of(usual.iter().chain(OUTPUTS)));
}

#[test]
fn without_elasticity_neither_solve_nor_basis_is_touched() {
    let (_daemon, bar) = start();
    let cheap = strike(&bar, &base_impact().disable(Effect::Elastic));
    let elasticity = cheap.stages().find(|cost| cost.stage == StageKind::Elasticity).unwrap();
    assert_eq!(elasticity, StageCost::idle(StageKind::Elasticity));
    assert_eq!(
        (cheap.summary().energy_source.name(), strike(&bar, &base_impact()).summary().energy_source.name()),
        ("falloff", "solve")
    );
    let wide = Contact::new([0.2, 0.0, 0.0]).impulse([-50.0, 3.0, 0.0]).radius(1e120);
    let weak = Impact::new([wide]).degree(DegreeRule::Sites(24)).seed(3).disable(Effect::Elastic);
    let error = bar.strike(&weak).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap();
    assert_eq!(error.kind, ErrorKind::Impulse, "{error}");
    let large = Contact::new([0.2, 0.0, 0.0]).impulse([-50.0, 3.0, 0.0]).radius(5.0);
    let error = bar.strike(&Impact::new([large])).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::ContactRadius, "contacts[0].radius_m"), "{error}");
    let diagonal = format!("a diagonal of {:.4} m", bar.facts().diagonal_m);
    assert!(error.message.contains("radius of 5.0000 m") && error.message.contains(&diagonal), "{error}");
    assert!(cheap.fragments().len() >= 24 && cheap.fragments().all(|fragment| fragment.is_closed()));
}

#[test]
fn outputs_change_no_other_section() {
    let (_daemon, bar) = start();
    for first in OUTPUTS {
        let before = hashes(&strike(&bar, &with(&[first])));
        for second in OUTPUTS.into_iter().filter(|second| *second != first) {
            let mut after = hashes(&strike(&bar, &with(&[first, second])));
            sections(second).into_iter().for_each(|name| assert!(after.remove(name).is_some(), "{name}"));
            assert_eq!(after, before, "{} after {}", second.name(), first.name());
        }
    }
}

/// The tests above use the default lift; this one covers the other lifts.
#[test]
fn every_effect_works_in_every_lift() {
    // Euclidean distances need no table.
    let (_daemon, bar) = start_held_in("surface_diffusion");
    for lift in [Lift::Euclidean, Lift::SurfaceDiffusion] {
        let struck = |impact: Impact| {
            let result = strike(&bar, &impact.lift(lift));
            assert!(
                result.fragments().len() > 8 && result.fragments().all(|fragment| fragment.is_closed()),
                "{lift:?}"
            );
            result
        };
        let before = hashes(&struck(base_impact()));
        for effect in OUTPUTS {
            let mut after = hashes(&struck(with(&needed(effect))));
            let added = needed(effect).into_iter().flat_map(sections);
            added.for_each(|name| assert!(after.remove(name).is_some(), "{name} {lift:?}"));
            assert_eq!(after, before, "{} {lift:?}", effect.name());
        }
        for effect in [Effect::Tensile, Effect::Anchored, Effect::Gravity] {
            let result = struck(with(&needed(effect)));
            assert!(result.effects().any(|cost| cost.effect == effect && cost.has_run), "{} {lift:?}", effect.name());
            assert_ne!(hashes(&result)["positions"], before["positions"], "{} {lift:?}", effect.name());
        }
        assert!(struck(bar.even(16, timeout()).unwrap()).fragments().len() >= 16);
    }
}

#[test]
fn physics_changes_the_pieces() {
    let (_daemon, bar) = start();
    let usual = hashes(&strike(&bar, &base_impact()));
    for (what, impact) in [
        ("tensile", base_impact().enable(Effect::Tensile)),
        ("interior", base_impact().disable(Effect::Interior)),
        ("elastic", base_impact().disable(Effect::Elastic)),
    ] {
        assert_ne!(hashes(&strike(&bar, &impact))["positions"], usual["positions"], "{what}");
    }
    let straight = hashes(&strike(&bar, &base_impact().lift(Lift::Euclidean)));
    assert_eq!(hashes(&strike(&bar, &base_impact().disable(Effect::Interior))), straight);
    let (_daemon, held) = start_held();
    assert_eq!(hashes(&strike(&held, &base_impact())), usual, "no request asked to hold it");
    let [anchored, heavy] =
        [Effect::Anchored, Effect::Gravity].map(|effect| hashes(&strike(&held, &with(&needed(effect)))));
    assert_ne!(anchored["positions"], usual["positions"]);
    assert_ne!(heavy["positions"], anchored["positions"]);
}

#[test]
fn invalid_values_are_rejected_by_name() {
    let (_daemon, bar) = start();
    let refused = |impact: Impact| {
        let error = bar.strike(&impact).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap();
        (error.kind, error.at)
    };
    for (impact, at) in [
        (base_impact().enable(Effect::Uv).disable(Effect::Uv), "uv"),
        (base_impact().enable(Effect::Tensile).disable(Effect::Elastic), "tensile"),
        (base_impact().enable(Effect::Interior).lift(Lift::Euclidean), "interior"),
        (base_impact().disable(Effect::Interior).lift(Lift::Interior), "interior"),
        (base_impact().enable(Effect::Warp), "warp"),
        (base_impact().enable(Effect::Anchored), "anchored"),
        (base_impact().enable(Effect::Gravity), "gravity"),
        (base_impact().enable(Effect::Dynamics), "dynamics"),
    ] {
        assert_eq!(refused(impact), (ErrorKind::Effect, at.to_owned()));
    }
    let (_daemon, held) = start_held();
    let both = base_impact().enable(Effect::Anchored).enable(Effect::Dynamics);
    let error = held.strike(&both).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Effect, "dynamics"));
    assert!(error.message.contains("for its anchors") && error.message.contains("bake --scene"), "{error}");
}

/// Slivers of the finer diagram are merged unless the request disables that; volumes are kept, and all fragments are closed.
#[test]
fn slivers_become_part_of_their_neighbors() {
    let (_daemon, bar) = start();
    let many = base_impact().degree(DegreeRule::Sites(250));
    let sliver = 2.0 * (0.05 * bar.facts().diagonal_m).powi(3);
    let least = |result: &FractureResult| result.fragments().map(|own| own.volume_m3()).fold(f64::INFINITY, f64::min);
    let volume = |result: &FractureResult| result.fragments().map(|own| own.volume_m3()).sum::<f64>();
    let before = strike(&bar, &many.clone().disable(Effect::Slivers));
    let after = strike(&bar, &many);
    assert!(least(&before) < 0.5 * sliver, "there are slivers");
    assert!(after.fragments().len() < before.fragments().len());
    // Where a merge reduces a junction of three cracks to two, volumes change a little.
    assert!(least(&after) > 0.9 * sliver, "{} of {sliver}", least(&after));
    assert!((volume(&after) / volume(&before) - 1.0).abs() < 1e-6);
    assert!(after.fragments().all(|fragment| fragment.is_closed()));
}

/// Every cell is a sliver where fragments must be larger than the object.
#[test]
fn a_result_of_one_piece_and_a_long_contact_are_warned_of() {
    let scene = Scene::parse("[objects.bar]\nvolume_min_m3 = 0.02", Path::new("")).unwrap();
    let (daemon, _) = start_with(Some(scene));
    let strike = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-50,3,0", "--degree", "8"];
    let reported = |more: &[&str]| {
        let output = shatter_program(&daemon.here).args([&strike, more].concat()).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let warning = reported(&[]);
    assert!(warning.contains("in one piece: all 8 cells") && warning.contains("--disable slivers"), "{warning}");
    assert_eq!(reported(&["--disable", "slivers"]), "");
    assert_eq!(reported(&["--disable", "slivers", "--surface", "lattice"]), "");
    let other = reported(&["--disable", "slivers", "--surface", "exact"]);
    assert!(other.contains("lattice's surface") && other.contains("`shatterd inspect bar` prints why"), "{other}");
    let whole = ["impact", "bar", "--point", "0.2,0,0", "--impulse=-1e-3,0,0", "--duration-s", "2"];
    let output = shatter_program(&daemon.here).args(whole).output().unwrap();
    let (result, warning) = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).into();
    assert!(result.contains("to break it: ") && result.contains("times this impulse"), "{result}");
    assert!(result.contains("stays whole") && warning.contains("--duration-s takes seconds"), "{result}{warning}");
    let is_bound = result.contains("energy: bounded from above");
    assert!(is_bound && result.contains("to break it: at least ") && result.contains("by the bound"), "{result}");
}

/// Area vector and area of the part of a fragment's surface that faces `neighbor`, from the mesh that the client receives.
fn face(fragment: &Fragment<'_>, neighbor: u32) -> ([f64; 3], f64) {
    let positions = fragment.positions();
    let runs = fragment.runs().filter(|run| run.neighbor == Some(neighbor));
    let triangles = runs.flat_map(|run| run.indices.chunks_exact(3).collect::<Vec<_>>());
    triangles.fold(([0.0; 3], 0.0), |(vector, area), triangle| {
        let [a, b, c] = [0, 1, 2].map(|k| positions[triangle[k] as usize].map(f64::from));
        let edge = |to: [f64; 3]| [0, 1, 2].map(|k| to[k] - a[k]);
        let own = cross(edge(b), edge(c)).map(|x| 0.5 * x);
        ([0, 1, 2].map(|k| vector[k] + own[k]), area + norm(own))
    })
}

#[test]
fn bonds_are_the_cracks_that_fragments_share() {
    let (_daemon, bar) = start();
    let result = strike(&bar, &with(&[Effect::Bonds]));
    let fragments: Vec<Fragment<'_>> = result.fragments().collect();
    let pairs: usize = fragments.iter().map(|own| own.runs().filter(|run| run.neighbor.is_some()).count()).sum();
    assert_eq!(2 * result.bonds().len(), pairs);
    let half = bar.facts().diagonal_m;
    for bond in result.bonds() {
        let (lower, upper) = (bond.fragment, bond.neighbor.unwrap());
        for (own, other, sign) in [(lower, upper, 1.0), (upper, lower, -1.0)] {
            let (vector, area) = face(&fragments[own as usize], other);
            assert!((area / bond.area_m2 - 1.0).abs() < 1e-5, "{area} of {}", bond.area_m2);
            let along: f64 = (0..3).map(|k| sign * vector[k] * bond.normal[k]).sum();
            assert!((along - norm(vector)).abs() < 1e-5 * bond.area_m2, "{vector:?} {:?}", bond.normal);
        }
        assert!((norm(bond.normal) - 1.0).abs() < 1e-12 && norm(bond.centroid_m) < half, "{bond:?}");
    }
}

/// Area of the part of a fragment's outer surface that the scene holds, by the centroids of triangles that the client receives.
fn held_area(fragment: &Fragment<'_>) -> f64 {
    let (positions, [x, ..]) = (fragment.positions(), fragment.center_m());
    let runs = fragment.runs().filter(|run| run.neighbor.is_none());
    let triangles = runs.flat_map(|run| run.indices.chunks_exact(3).collect::<Vec<_>>());
    let area = |triangle: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| positions[triangle[k] as usize].map(f64::from));
        let edge = |to: [f64; 3]| [0, 1, 2].map(|k| to[k] - a[k]);
        let held = (a[0] + b[0] + c[0]) / 3.0 + x <= HELD_BELOW;
        if held { 0.5 * norm(cross(edge(b), edge(c))) } else { 0.0 }
    };
    triangles.map(area).sum()
}

#[test]
fn fragments_in_anchors_are_bonded_to_the_world() {
    let (_daemon, bar) = start_held();
    let outputs = [Effect::Bonds, Effect::Release];
    let result = strike(&bar, &with(&[&outputs[..], &[Effect::Anchored]].concat()));
    let world: Vec<Bond> = result.bonds().filter(Bond::is_with_world).collect();
    let [seen, reported]: [f64; 2] =
        [result.fragments().map(|own| held_area(&own)).sum(), world.iter().map(|bond| bond.area_m2).sum()];
    assert!((reported / seen - 1.0).abs() < 1e-4, "{reported} of {seen}");
    for fragment in result.fragments() {
        let bond = world.iter().find(|bond| bond.fragment == fragment.id());
        let velocity = fragment.velocity().unwrap();
        assert_eq!(norm(velocity.linear_m_s) + norm(velocity.angular_rad_s) == 0.0, bond.is_some());
        let (own, reported) = (held_area(&fragment), bond.map_or(0.0, |bond| bond.area_m2));
        assert!((own - reported).abs() < 1e-4 * seen, "fragment {}: {reported} of {own}", fragment.id());
    }
    assert!(!world.is_empty() && world.len() < result.fragments().len());
    let free = strike(&bar, &with(&outputs));
    assert!(!free.bonds().any(|bond| bond.is_with_world()));
}

#[test]
fn normals_have_length_one_and_point_out_of_their_fragment() {
    let (_daemon, bar) = start();
    let result = strike(&bar, &with(&[Effect::Normals]));
    for fragment in result.fragments() {
        let (positions, normals) = (fragment.positions(), fragment.normals());
        assert_eq!(positions.len(), normals.len());
        assert!(normals.iter().all(|normal| (norm(normal.map(f64::from)) - 1.0).abs() < 1e-6));
        let mut agree = 0.0;
        let mut all = 0.0;
        for triangle in fragment.indices().chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| positions[triangle[k] as usize].map(f64::from));
            let edge = |to: [f64; 3]| [0, 1, 2].map(|k| to[k] - a[k]);
            let area = cross(edge(b), edge(c));
            for corner in triangle {
                let normal = normals[*corner as usize].map(f64::from);
                agree += (0..3).map(|k| normal[k] * area[k]).sum::<f64>();
                all += norm(area);
            }
        }
        assert!(agree > 0.8 * all, "{agree} of {all}");
    }
}

/// The fragments of a crack, and a point on it.
type Spot = ([u32; 2], [i64; 3]);

#[test]
fn both_sides_of_a_crack_have_the_same_texture() {
    let (_daemon, bar) = start();
    let result = strike(&bar, &with(&[Effect::Uv]));
    let mut sides: HashMap<Spot, Vec<[f32; 2]>> = HashMap::new();
    for fragment in result.fragments() {
        let center = fragment.center_m();
        for run in fragment.runs() {
            let uvs = &fragment.uvs()[run.vertex_first as usize..][..run.positions.len()];
            let Some(neighbor) = run.neighbor else {
                assert!(uvs.iter().all(|uv| *uv == [0.0; 2]));
                continue;
            };
            let pair = [fragment.id().min(neighbor), fragment.id().max(neighbor)];
            for (position, uv) in run.positions.iter().zip(uvs) {
                let place = [0, 1, 2].map(|k| ((f64::from(position[k]) + center[k]) * 1e5).round() as i64);
                sides.entry((pair, place)).or_default().push(*uv);
            }
        }
    }
    let pairs: Vec<_> = sides.values().filter(|uvs| uvs.len() == 2).collect();
    assert!(pairs.len() > 100);
    assert!(pairs.iter().all(|uvs| uvs[0] == uvs[1]), "bit for bit");
}

#[test]
fn release_conserves_momentum() {
    let (_daemon, bar) = start();
    let result = strike(&bar, &with(&[Effect::Release]));
    let parts: Vec<_> = result
        .fragments()
        .map(|own| (own.mass_kg(), own.center_m(), own.inertia_kg_m2(), own.velocity().unwrap()))
        .collect();
    let momenta = || parts.iter().map(|(mass, _, _, velocity)| velocity.linear_m_s.map(|v| v * mass));
    let linear = sum(momenta());
    let angular = sum(parts.iter().map(|(mass, center, inertia, velocity)| {
        let [xx, yy, zz, xy, xz, yz] = *inertia;
        let w = velocity.angular_rad_s;
        let spin = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(|row| (0..3).map(|k| row[k] * w[k]).sum::<f64>());
        let orbit = cross(*center, velocity.linear_m_s.map(|v| v * mass));
        [0, 1, 2].map(|k| spin[k] + orbit[k])
    }));
    let scale: f64 = momenta().map(norm).sum();
    assert!(scale > 0.0);
    assert!(norm(linear) < 1e-9 * scale, "{linear:?} of {scale}");
    assert!(norm(angular) < 1e-9 * scale * bar.facts().diagonal_m, "{angular:?} of {scale}");
    // The fragment nearest to the contact is the fastest, and moves away.
    let speed = |own: &FragmentVelocity| norm(own.linear_m_s);
    let fastest = parts.iter().max_by(|a, b| speed(&a.3).total_cmp(&speed(&b.3))).unwrap();
    assert!(fastest.1[0] > 0.1, "{:?}", fastest.1);
}

#[test]
fn debris_lies_on_cracks() {
    let (_daemon, bar) = start();
    let result = strike(&bar, &with(&[Effect::Debris]));
    let fragments: Vec<Fragment<'_>> = result.fragments().collect();
    assert!(result.debris().len() > 100);
    let spacing = 0.05 * bar.facts().diagonal_m;
    for point in result.debris() {
        let run = fragments[point.fragment as usize].runs().find(|run| run.neighbor == Some(point.neighbor)).unwrap();
        let distance = |position: &[f32; 3]| norm([0, 1, 2].map(|k| f64::from(position[k] - point.position_m[k])));
        let nearest = run.positions.iter().map(distance).fold(f64::INFINITY, f64::min);
        assert!(nearest < spacing, "{nearest} of {spacing}");
        assert!((norm(point.normal.map(f64::from)) - 1.0).abs() < 1e-6);
        assert!(f64::from(point.size_m) > 0.09 * spacing && f64::from(point.size_m) < 1.01 * spacing);
    }
}

/// Hulls at the client: closed, within the limits, and around their fragments.
#[test]
fn hulls_come_with_every_fragment() {
    let (_daemon, bar) = start();
    assert!(strike(&bar, &base_impact()).fragments().all(|fragment| fragment.hull().is_none()));
    let result = strike(&bar, &with(&[Effect::Hulls]));
    for fragment in result.fragments() {
        let hull = fragment.hull().unwrap();
        let (vertices, faces) = (hull.positions.len(), hull.indices.len() / 3);
        assert!(faces <= 64 && 2 * vertices == faces + 4, "{vertices} vertices, {faces} faces");
        assert!((0.9..=1.0).contains(&hull.coverage), "{}", hull.coverage);
        assert!((0.0..0.02).contains(&hull.margin_m), "{}", hull.margin_m);
        let least = |positions: &[[f32; 3]], k: usize| positions.iter().map(|p| p[k]).fold(f32::INFINITY, f32::min);
        let slack = 0.05 * bar.facts().diagonal_m as f32;
        assert!((0..3).all(|k| (least(hull.positions, k) - least(fragment.positions(), k)).abs() < slack));
    }
    let file = tempfile::tempdir().unwrap();
    let path = file.path().join("bar.hulls.glb");
    let written = result.write_hulls_glb(&path).unwrap();
    assert_eq!((written.fragments, written.closed), (result.fragments().len(), result.fragments().len()));
    assert_eq!(strike(&bar, &base_impact()).write_hulls_glb(&path).unwrap_err().kind, ErrorKind::Output);
}
