//! Several objects of a scene that share one database, with real processes and a real object.

mod support;

use rustix::process::Signal;
use serde_json::Value;
use shatter_client::{Client, Contact, DegreeRule, Effect, ErrorKind, Impact, ObjectFacts};
use std::process::{Command, Stdio};
use support::{Child, TestDirectory, bar, shatter, shatterd, timeout};

/// A scene of two objects, made from `databases`.
fn scene(databases: [&str; 2]) -> String {
    let [near, far] = databases;
    format!(
        "[objects.near]\ndatabase = \"{near}\"\neffects = [\"elastic\", \"interior\", \"bonds\"]\n\
         [objects.far]\ndatabase = \"{far}\"\neffects = []\nsites_max = 30\nfragments_max = 64\nbytes_max = 4000000"
    )
}

/// Starts a daemon that serves both objects from these files, and reads them again only on demand.
fn serve(databases: [&str; 2], files: &[(&str, &[u8])]) -> (TestDirectory, Child, Client) {
    let here = TestDirectory::new("cast");
    files.iter().for_each(|(name, bytes)| here.database(name, bytes));
    let (scene, config) =
        (here.file("scene.toml", &scene(databases)), here.file("config.toml", "[databases]\nwatch_ms = 0"));
    let daemon = Child::start(shatterd(&here).arg("--scene").arg(scene).arg("--config").arg(config));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    (here, daemon, service)
}

fn base_impact() -> Impact {
    Impact::new([Contact::new([0.2, 0.0, 0.0]).impulse([-50.0, 3.0, 0.0]).radius(0.05)])
        .degree(DegreeRule::Sites(24))
        .seed(3)
}

/// Hashes of the results of both objects.
fn hashes(service: &Client) -> [String; 2] {
    ["near", "far"].map(|name| {
        let object = service.object(name, timeout()).unwrap();
        let result = object.strike(&base_impact()).unwrap().wait(timeout()).unwrap();
        let elastic = result.effects().any(|cost| cost.effect == Effect::Elastic && cost.has_run);
        assert_eq!((elastic, result.bonds().len() == 0), (name == "near", name == "far"));
        result.digest().output_hash
    })
}

/// Facts of the objects `near` and `far`.
fn facts(service: &Client) -> [ObjectFacts; 2] {
    let objects = service.objects(timeout()).unwrap();
    assert_eq!(objects.iter().map(|facts| facts.name.as_str()).collect::<Vec<_>>(), ["far", "near"]);
    ["near", "far"].map(|name| objects.iter().find(|facts| facts.name == name).unwrap().clone())
}

#[test]
fn objects_of_one_database_answer_as_if_each_had_its_own_and_are_replaced_together() {
    let [coarse, fine] = [0.07, 0.06].map(bar);
    let apart = |bytes: &[u8]| {
        let (_here, daemon, service) = serve(["one", "two"], &[("one", bytes), ("two", bytes)]);
        let both = hashes(&service);
        drop(service);
        assert_eq!(daemon.terminate().code(), Some(0));
        both
    };
    let (here, daemon, service) = serve(["bar", "bar"], &[("bar", &coarse)]);
    assert_eq!(hashes(&service), apart(&coarse));
    let [near, far] = facts(&service);
    assert!(near.memory_bytes > far.memory_bytes, "{} and {}", near.memory_bytes, far.memory_bytes);
    assert_eq!(service.status(timeout()).unwrap().memory_bytes, near.memory_bytes + far.memory_bytes);
    assert_eq!((far.degree_max, far.fragments_max, far.bytes_max), (30, Some(64), Some(4_000_000)));
    assert_eq!((near.fragments_max, near.bytes_max), (None, None));
    let (_, text) = shatter(&here, &["list", "--json"]);
    let listed: Value = serde_json::from_str(&text).unwrap();
    let [listed_far, listed_near] = [0, 1].map(|row| &listed["objects"][row]);
    assert_eq!((&listed_far["object"], &listed_far["fragments_max"]), (&"far".into(), &64.into()));
    assert_eq!((&listed_far["bytes_max"], &listed_near["bytes_max"]), (&4_000_000.into(), &Value::Null));
    let refused = service.object("far", timeout()).unwrap().strike(&base_impact().enable(Effect::Bonds));
    assert_eq!(refused.and_then(|mut ticket| ticket.wait(timeout())).err().unwrap().kind, ErrorKind::Effect);
    assert_eq!(service.object("bar", timeout()).err().unwrap().kind, ErrorKind::UnknownObject);

    here.database("bar", &fine);
    daemon.signal(Signal::HUP);
    support::eventually(
        || format!("{:?}", facts(&service)),
        || facts(&service).iter().all(|facts| facts.generation == 2),
    );
    assert_eq!(hashes(&service), apart(&fine));
    drop(service);
    assert_eq!(daemon.terminate().code(), Some(0));
}

#[test]
fn a_database_that_is_not_there_is_named() {
    let here = TestDirectory::new("cast");
    here.database("bar", bar(0.08));
    let file = here.file("scene.toml", &scene(["bar", "bowl"]));
    let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut command);
    let run = |arguments: &[&str], command: &mut Command| {
        let out = command.args(arguments).stdin(Stdio::null()).output().unwrap();
        (out.status.code().unwrap(), [out.stdout, out.stderr].map(|bytes| String::from_utf8(bytes).unwrap()))
    };
    let (code, [_, error]) = run(&["serve", "--scene", file.to_str().unwrap()], &mut command);
    assert!(code == 3 && error.contains("`bowl`") && error.contains("bowl.shatter is missing; bake it"), "{error}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_shatterd"));
    here.aim(&mut command);
    let databases = here.databases();
    let (code, [out, error]) =
        run(&["check", file.to_str().unwrap(), "--databases", databases.to_str().unwrap()], &mut command);
    assert_eq!(code, 0, "{error}");
    assert!(out.contains("bowl.shatter: not baked yet") && out.contains("bar.shatter)"), "{out}");
}
