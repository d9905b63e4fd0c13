//! Rays, bounds and nearest surface points through the whole service and on the command line.

mod support;

use serde_json::Value;
use shatter_client::{Client, Contact, Convention, DegreeRule, Error, ErrorKind, FractureResult, Impact, Object, Ray};
use std::sync::LazyLock;
use support::{InProcess, TestDirectory, bar, shatter, timeout};

/// Database of a bar of 0.4 × 0.2 × 0.2 m around the origin, baked once for all tests: the bytes of the file.
static BAR: LazyLock<Vec<u8>> = LazyLock::new(|| bar(0.05));

/// Largest distance of the crack lattice from the surface of the bar, m.
const DEVIATION_M: f64 = 0.012;

fn start() -> (InProcess, Client, Object) {
    let here = TestDirectory::new("aim");
    here.database("bar", BAR.as_slice());
    let daemon = InProcess::start_with(here, "", shatter_engine::wire::loader(None));
    let service = daemon.connect();
    let bar = service.object("bar", timeout()).unwrap();
    (daemon, service, bar)
}

fn ray(origin_m: [f64; 3], direction: [f64; 3]) -> Ray {
    Ray { origin_m, direction }
}

fn impact(contact: impl Into<Contact>) -> Impact {
    Impact::new([contact.into().impulse([-50.0, 3.0, 0.0])]).degree(DegreeRule::Sites(6)).seed(3)
}

fn strike(bar: &Object, impact: &Impact) -> FractureResult {
    bar.strike(impact).unwrap().wait(timeout()).unwrap()
}

fn refused(bar: &Object, impact: &Impact) -> Error {
    bar.strike(impact).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap()
}

#[track_caller]
fn near(found: [f64; 3], wanted: [f64; 3], within: f64) {
    let off = (0..3).map(|k| (found[k] - wanted[k]).powi(2)).sum::<f64>().sqrt();
    assert!(off <= within, "{found:?} instead of {wanted:?}");
}

/// Hash of the positions of a result.
fn shape(result: &FractureResult) -> String {
    let digest = result.digest();
    digest.sections.iter().find(|section| section.name == "positions").unwrap().hash.clone()
}

#[test]
fn a_ray_hits_the_nearest_surface_and_strikes_there() {
    let (_daemon, _, bar) = start();
    let aimed = ray([1.0, 0.03, 0.02], [-2.0, 0.0, 0.0]);
    let hit = bar.aim(aimed, timeout()).unwrap();
    near(hit.point_m, [0.2, 0.03, 0.02], DEVIATION_M);
    assert!((hit.distance_m - 0.8).abs() < DEVIATION_M && hit.normal[0] > 0.7 && hit.body == 0, "{hit:?}");
    let along = strike(&bar, &impact(aimed));
    let at = strike(&bar, &impact(Contact::new(hit.point_m)));
    assert_eq!((along.hit(), at.hit()), (Some(hit), None));
    assert_eq!(shape(&along), shape(&at));
    let inside = bar.aim(ray([0.0; 3], [0.0, 1.0, 0.0]), timeout()).unwrap();
    near(inside.point_m, [0.0, 0.1, 0.0], DEVIATION_M);
    assert!(inside.normal[1] > 0.7, "the normal is outward for a ray from inside, too: {inside:?}");
}

#[test]
fn rays_are_in_the_coordinates_of_the_connection() {
    let (_daemon, service, bar) = start();
    let ours = bar.aim(ray([1.0, 0.03, 0.02], [-1.0, 0.0, 0.0]), timeout()).unwrap();
    let unreal = service.with_convention(Convention::UNREAL).object("bar", timeout()).unwrap();
    let to = Convention::UNREAL;
    let aimed = ray(to.vector([1.0, 0.03, 0.02]), to.direction([-1.0, 0.0, 0.0]));
    let hit = unreal.aim(aimed, timeout()).unwrap();
    near(hit.point_m, to.vector(ours.point_m), 1e-9);
    near(hit.normal, to.direction(ours.normal), 1e-12);
    assert!((hit.distance_m - 100.0 * ours.distance_m).abs() < 1e-9);
    let far = refused(&unreal, &impact(Contact::new(to.vector([0.5, 0.03, 0.02]))));
    near(nearest(&far), to.vector([0.2, 0.03, 0.02]), 100.0 * DEVIATION_M);
    let beside = ray(to.vector([1.0, 0.15, 0.0]), to.direction([-1.0, 0.0, 0.0]));
    for error in [far, unreal.aim(beside, timeout()).unwrap_err()] {
        assert!(error.message.contains(" cm") && !error.message.contains(" m "), "{error}");
    }
}

/// The nearest surface point that a message names, m.
fn nearest(error: &Error) -> [f64; 3] {
    let reported = error.message.split("in the request's coordinates: ").nth(1).unwrap_or_else(|| panic!("{error}"));
    let numbers: Vec<f64> = reported.split(';').next().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

#[test]
fn a_missing_ray_reports_its_closest_distance() {
    let (_daemon, _, bar) = start();
    let missed = bar.aim(ray([1.0, 0.15, 0.0], [-1.0, 0.0, 0.0]), timeout()).unwrap_err();
    assert_eq!((missed.kind, missed.at.as_str()), (ErrorKind::RayMissed, "contacts[0].ray"), "{missed}");
    let by: f64 = missed.message.split("by ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((by - 0.05).abs() < DEVIATION_M, "{missed}");
    let away = bar.aim(ray([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), timeout()).unwrap_err();
    assert_eq!(away.kind, ErrorKind::RayMissed, "a ray does not hit what is behind it");
    for distance_m in [1e13, 1e15, 1e200] {
        let far = bar.aim(ray([distance_m, 0.0, 0.0], [-1.0, 0.0, 0.0]), timeout()).unwrap_err();
        assert_eq!((far.kind, far.at.as_str()), (ErrorKind::Ray, "contacts[0].point_m"), "{far}");
    }
    near(bar.aim(ray([1e8, 0.0, 0.0], [-1.0, 0.0, 0.0]), timeout()).unwrap().point_m, [0.2, 0.0, 0.0], DEVIATION_M);
    for direction in [[0.0; 3], [f64::NAN, 0.0, 0.0]] {
        assert_eq!(bar.aim(ray([1.0, 0.0, 0.0], direction), timeout()).unwrap_err().kind, ErrorKind::Ray);
    }
    let aimed = Contact::from(ray([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0])).impulse([-1.0, 0.0, 0.0]);
    let beside = Contact::new([0.2, 0.0, 0.0]).impulse([-50.0, 3.0, 0.0]);
    assert_eq!(refused(&bar, &Impact::new([aimed, beside])).kind, ErrorKind::Ray);
    let far = refused(&bar, &impact(Contact::new([0.5, 0.03, 0.02])));
    assert_eq!(far.kind, ErrorKind::ContactTooFar);
    for part in ["contact 0 is 0.", "m from the surface", "(radius + lattice spacing)", "another --unit or --up"] {
        assert!(far.message.contains(part), "{far}");
    }
    near(nearest(&far), [0.2, 0.03, 0.02], DEVIATION_M);
    assert!(strike(&bar, &impact(Contact::new(nearest(&far)))).fragments().len() > 1);
}

#[test]
fn fragments_are_aimed_at_too() {
    let (_daemon, _, bar) = start();
    let result = strike(&bar, &impact(Contact::new([0.2, 0.0, 0.0])).keep());
    let handle = result.handle().unwrap();
    let largest = result.fragments().max_by(|a, b| a.mass_kg().total_cmp(&b.mass_kg())).unwrap();
    let center = largest.center_m();
    let down = ray([center[0], 1.0, center[2]], [0.0, -1.0, 0.0]);
    let hit = bar.aim_at_fragment(handle, largest.id(), down, timeout()).unwrap();
    assert!(hit.point_m[1] > center[1] && hit.point_m[1] < 0.1 + DEVIATION_M, "{hit:?} above {center:?}");
    let again = impact(down).from(handle, largest.id());
    assert_eq!(strike(&bar, &again).hit(), Some(hit));
    let none = bar.aim_at_fragment(handle, 9999, down, timeout()).unwrap_err();
    assert_eq!(none.kind, ErrorKind::UnknownFragment);
}

#[test]
fn the_command_line_aims_lists_bounds_and_names_the_nearest() {
    let (daemon, service, _) = start();
    let here = &daemon.here;
    let json = |arguments: &[&str]| -> (i32, Value) {
        let (code, text) = shatter(here, &[arguments, &["--json"]].concat());
        (code, serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}")))
    };
    let [low, high] = service.objects(timeout()).unwrap()[0].bounds_m;
    near(low, [-0.2, -0.1, -0.1], DEVIATION_M);
    near(high, [0.2, 0.1, 0.1], DEVIATION_M);
    let (_, listed) = json(&["list"]);
    assert_eq!(listed["objects"][0]["bounds_m"], serde_json::json!([low, high]));
    assert_eq!(listed["objects"][0]["state"], "ready");
    let (_, text) = shatter(here, &["list"]);
    assert!(
        text.contains("ready") && text.contains(&format!("{:.4},{:.4},{:.4}", high[0], high[1], high[2])),
        "{text}"
    );
    let ray = ["--ray", "1,0.03,0.02,-1,0,0"];
    let (code, struck) = json(&[&["impact", "bar", "--impulse-ns", "50", "--degree", "6"][..], &ray].concat());
    assert_eq!((code, struck["hit"]["surface"].as_str()), (0, Some("lattice")), "{struck}");
    assert!((struck["hit"]["point_m"][0].as_f64().unwrap() - 0.2).abs() < DEVIATION_M, "{struck}");
    let (code, tested) = json(&[&["threshold", "bar"][..], &ray].concat());
    assert_eq!((code, tested["direction"][0].as_f64()), (0, Some(-1.0)), "{tested}");
    let along_x = ["--point", "0.2,0,0", "--direction", "-1,0,0"];
    let (_, text) = shatter(here, &[&["threshold", "bar"][..], &along_x].concat());
    assert!(text.trim_end().ends_with("N·s"), "{text}");
    let breaking = |target: &[&str]| json(&[&["threshold", "bar"][..], target].concat()).1["impulse_ns"].as_f64();
    let straight = ["--lift", "euclidean"];
    let impulse_ns = breaking(&[&along_x[..], &straight].concat()).unwrap();
    assert_ne!(breaking(&along_x), Some(impulse_ns), "the lift is part of the threshold");
    for (factor, breaks) in [(0.98, false), (1.02, true)] {
        let impulse = format!("-{},0,0", factor * impulse_ns);
        let strike = ["impact", "bar", "--point", "0.2,0,0", "--impulse", &impulse];
        let (_, result) = json(&[&strike[..], &straight].concat());
        assert_eq!(result["fragments"].as_array().unwrap().len() > 1, breaks, "{factor}: {result}");
    }
    let strike = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-50,0,0", "--degree", "3", "--keep"];
    let (_, kept) = json(&strike);
    let of_fragment = format!("{}/0", kept["handle"]);
    let center: Vec<String> =
        kept["fragments"][0]["center_m"].as_array().unwrap().iter().map(ToString::to_string).collect();
    let impulse_ns =
        breaking(&["--from", &of_fragment, "--point", &center.join(","), "--direction", "-1,0,0"]).unwrap();
    assert!(impulse_ns > 0.0 && Some(impulse_ns) != breaking(&along_x), "{impulse_ns}");
    let (code, missed) = json(&["impact", "bar", "--impulse-ns", "1", "--ray", "1,1,1,1,0,0"]);
    assert_eq!((code, missed["error"]["kind"].as_str()), (3, Some("ray_missed")), "{missed}");
    let (code, typo) = json(&["threshold", "bra", "--point", "0,0,0", "--direction", "0,-1,0"]);
    let message = typo["error"]["message"].as_str().unwrap();
    assert!(code == 3 && message.contains("did you mean `bar`?"), "{message}");
}
