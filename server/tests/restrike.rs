//! Requests against fragments of earlier results, through the whole service: the life of a handle, and its fragments.

mod support;

use serde_json::Value;
use shatter_client::{
    Client, Deadline, DegreeRule, Error, ErrorKind, FractureResult, Impact, Object, Progress, RetainedFragment, Status,
};
use shatter_proto::control::ControlRequest;
use shatter_proto::request::Contact;
use shatter_proto::request::{Request, RequestWire};
use std::sync::LazyLock;
use std::time::Duration;
use support::{Child, InProcess, RawPeer, TestDirectory, bar, eventually, shatter, shatterd, timeout};

/// Database of a bar, baked once for all tests: the bytes of the file.
static BAR: LazyLock<Vec<u8>> = LazyLock::new(|| bar(0.05));

fn place(name: &str) -> TestDirectory {
    let here = TestDirectory::new(name);
    here.database("bar", BAR.as_slice());
    here
}

/// Starts a daemon with the bar, and connects to it.
fn start(settings: &str) -> (InProcess, Client, Object) {
    let daemon = InProcess::start_with(place("again"), settings, shatter_engine::wire::loader(None));
    let service = daemon.connect();
    let bar = service.object("bar", timeout()).unwrap();
    (daemon, service, bar)
}

/// An impact on the end of the bar that breaks it.
fn base_impact() -> Impact {
    Impact::new([Contact::new([0.2, 0.0, 0.0]).impulse([-50.0, 3.0, 0.0]).radius(0.05)])
        .degree(DegreeRule::Sites(6))
        .seed(3)
}

fn strike(bar: &Object, impact: &Impact) -> FractureResult {
    bar.strike(impact).unwrap().wait(timeout()).unwrap()
}

fn refused(bar: &Object, impact: &Impact) -> Error {
    bar.strike(impact).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap()
}

fn status(service: &Client) -> Status {
    service.status(timeout()).unwrap()
}

/// The heaviest fragment of `result`, and an impact on the point of its surface with the largest x.
fn largest(result: &FractureResult) -> (u32, Impact) {
    let weight = |fragment: &shatter_client::Fragment<'_>| fragment.mass_kg();
    let fragment = result.fragments().max_by(|a, b| weight(a).total_cmp(&weight(b))).unwrap();
    let farthest = fragment.positions().iter().max_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
    let point = [0, 1, 2].map(|k| fragment.center_m()[k] + f64::from(farthest[k]));
    let impact =
        Impact::new([Contact::new(point).impulse([-40.0, 1.0, 2.0]).radius(0.05)]).degree(DegreeRule::Sites(7));
    (fragment.id(), impact)
}

/// Strikes the largest fragment of a kept result; its children have the volume of the parent.
#[track_caller]
fn check(bar: &Object, before: &FractureResult, kept: bool) -> FractureResult {
    let (fragment, impact) = largest(before);
    let impact = impact.from(before.handle().unwrap(), fragment);
    let children = strike(bar, &if kept { impact.keep() } else { impact });
    let parent = before.fragments().nth(fragment as usize).unwrap().volume_m3();
    let sum: f64 = children.fragments().map(|child| child.volume_m3()).sum();
    assert!(children.fragments().len() >= 7 && children.fragments().all(|child| child.is_closed()));
    assert!((sum / parent - 1.0).abs() < 1e-6, "{sum} of {parent}");
    let old = children.fragments().flat_map(|child| child.runs().collect::<Vec<_>>());
    assert!(old.filter(|run| run.is_crack && run.neighbor.is_none()).count() > 0, "sides of the first crack");
    assert_eq!(children.handle().is_some(), kept);
    children
}

#[test]
fn fragments_are_struck_again_and_theirs_too() {
    let (daemon, service, bar) = start("");
    let plain = strike(&bar, &base_impact());
    assert_eq!((plain.handle(), status(&service).kept), (None, 0));
    let first = strike(&bar, &base_impact().keep());
    assert_eq!(first.digest(), plain.digest(), "keeping changes nothing in a result");
    let row = status(&service);
    assert!((row.kept, row.kept_bytes > 10_000) == (1, true), "{} bytes", row.kept_bytes);
    let second = check(&bar, &first, true);
    drop(check(&bar, &second, false));
    // Another connection of this user may use the handle, too.
    let other = daemon.connect().object("bar", timeout()).unwrap();
    let again = check(&other, &first, true);
    assert_eq!(again.digest(), second.digest());
    assert_ne!(again.handle(), second.handle());
    assert_eq!(status(&service).kept, 3);
    // An object that stays whole has no fragments.
    assert_eq!(strike(&bar, &base_impact().degree(DegreeRule::ClosedForm).gamma(1e30).keep()).handle(), None);
}

#[test]
fn results_on_fragments_tell_an_error_of_their_own() {
    let here = place("errors");
    let path = here.databases().join("bar.shatter");
    let whole = shatter_fracture::database::load(&path).unwrap().report.discretization_error().unwrap();
    let daemon = InProcess::start_with(here, "", shatter_engine::wire::loader(None));
    let bar = daemon.connect().object("bar", timeout()).unwrap();
    let first = strike(&bar, &base_impact().keep());
    assert_eq!(first.summary().discretization_error, Some(whole));
    let own = check(&bar, &first, false).summary().discretization_error.unwrap();
    assert!((whole + 0.02..1.0).contains(&own), "{own}, of the whole object {whole}");
}

#[test]
fn released_results_are_unavailable() {
    let (_daemon, service, bar) = start("");
    let handle = strike(&bar, &base_impact().keep()).handle().unwrap();
    service.release(handle, timeout()).unwrap();
    assert_eq!((status(&service).kept, status(&service).kept_bytes), (0, 0));
    let error = refused(&bar, &base_impact().from(handle, 0));
    assert_eq!((error.kind, error.at), (ErrorKind::UnknownHandle, handle.to_string()));
    assert_eq!(service.release(handle, timeout()).unwrap_err().kind, ErrorKind::UnknownHandle);
    let hold = service.retain(strike(&bar, &base_impact().keep()).handle().unwrap());
    assert_eq!(status(&service).kept, 1);
    drop(hold);
    assert_eq!(status(&service).kept, 0);
}

#[test]
fn retained_results_expire() {
    let (_daemon, service, bar) = start("[times]\nkept_s = 0.2");
    let handle = strike(&bar, &base_impact().keep()).handle().unwrap();
    eventually(|| format!("{:?}", status(&service).kept), || status(&service).kept == 0);
    assert_eq!(refused(&bar, &base_impact().from(handle, 0)).kind, ErrorKind::UnknownHandle);
}

#[test]
fn the_oldest_retained_result_is_evicted() {
    let (_daemon, service, bar) = start("[results]\nkept_max = 2");
    let kept: Vec<FractureResult> = (0..3).map(|seed| strike(&bar, &base_impact().seed(seed).keep())).collect();
    assert_eq!(status(&service).kept, 2);
    assert_eq!(refused(&bar, &base_impact().from(kept[0].handle().unwrap(), 0)).kind, ErrorKind::UnknownHandle);
    kept[1..].iter().for_each(|result| drop(check(&bar, result, false)));
    let (_daemon, service, bar) = start("[results]\nkept_max = 0");
    assert_eq!((strike(&bar, &base_impact().keep()).handle(), status(&service).kept), (None, 0));
}

#[test]
fn unknown_handles_are_rejected_by_name() {
    let (_daemon, _service, bar) = start("");
    let result = strike(&bar, &base_impact().keep());
    let handle = result.handle().unwrap();
    let count = result.fragments().len() as u32;
    for (impact, kind, at) in [
        (base_impact().from(handle, count), ErrorKind::UnknownFragment, count.to_string()),
        (base_impact().from(handle, u32::MAX), ErrorKind::UnknownFragment, u32::MAX.to_string()),
        (base_impact().from(handle + 1, 0), ErrorKind::UnknownHandle, (handle + 1).to_string()),
        (base_impact().from(0, 0), ErrorKind::UnknownHandle, "0".to_owned()),
    ] {
        let error = refused(&bar, &impact);
        assert_eq!((error.kind, &error.at), (kind, &at), "{error}");
        assert!(!kind.retry() && kind.fault() == shatter_client::FaultParty::Caller);
    }
    let off = Impact::new([Contact::new([0.0, 3.0, 0.0]).impulse([0.0, -1.0, 0.0])]).from(handle, 0);
    let off = refused(&bar, &off);
    assert!(off.kind == ErrorKind::ContactTooFar && off.message.starts_with("fragment 0: contact 0 is "), "{off}");
    assert!(off.message.contains("Nearest surface point") && !off.message.contains("--unit"), "{off}");
    let lift = refused(&bar, &base_impact().lift(shatter_client::Lift::SurfaceDiffusion).from(handle, 0));
    assert_eq!((lift.kind, lift.at.as_str()), (ErrorKind::Lift, "surface_diffusion"));
}

#[test]
fn a_handle_keeps_the_version_of_its_object() {
    let (daemon, service, bar) = start("[databases]\nwatch_ms = 10");
    let first = strike(&bar, &base_impact().keep());
    daemon.here.database("bar", support::bar(0.08));
    let generation = || service.object("bar", timeout()).unwrap().facts().generation;
    eventually(generation, || generation() == 2);
    assert_eq!(status(&service).retired, 1);
    drop(check(&bar, &first, false));
    service.release(first.handle().unwrap(), timeout()).unwrap();
    eventually(|| status(&service).retired, || status(&service).retired == 0);
}

#[test]
fn a_restart_forgets_handles() {
    let (mut daemon, _, bar) = start("");
    let handle = strike(&bar, &base_impact().keep()).handle().unwrap();
    daemon.end().unwrap();
    daemon.again();
    let bar = daemon.connect().object("bar", timeout()).unwrap();
    assert_ne!(strike(&bar, &base_impact().keep()).handle(), Some(handle));
    assert_eq!(refused(&bar, &base_impact().from(handle, 0)).kind, ErrorKind::UnknownHandle);
}

#[test]
fn the_command_line_strikes_a_fragment() {
    let here = place("line");
    let _daemon = Child::start(&mut shatterd(&here));
    let run = |more: &[&str]| {
        let base_impact = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-50,3,0", "--radius-m", "0.05"];
        let (code, out) = shatter(&here, &[&base_impact[..], &["--degree", "6", "--json"], more].concat());
        (code, serde_json::from_str::<Value>(&out).unwrap())
    };
    let (code, first) = run(&["--keep"]);
    let handle = first["handle"].as_u64().unwrap();
    assert!(code == 0 && handle < 1 << 53);
    let fragments = first["fragments"].as_array().unwrap();
    let volume = |fragment: &Value| fragment["volume_m3"].as_f64().unwrap();
    let x = |fragment: &Value| fragment["center_m"][0].as_f64().unwrap();
    let struck = fragments.iter().max_by(|a, b| x(a).total_cmp(&x(b))).unwrap();
    let (code, second) = run(&["--from", &format!("{handle}/{}", struck["id"])]);
    let children = second["fragments"].as_array().unwrap();
    let sum: f64 = children.iter().map(volume).sum();
    assert_eq!((code, &second["handle"]), (0, &Value::Null), "{second}");
    assert!((sum / volume(struck) - 1.0).abs() < 1e-6 && children.iter().all(|child| child["closed"] == true));
    let (code, unknown) = run(&["--from", &format!("{}/0", handle + 9)]);
    assert_eq!((code, unknown["error"]["kind"].as_str()), (3, Some("unknown_handle")), "{unknown}");
    let (code, usage) = run(&["--from", "7"]);
    assert_eq!((code, usage["error"]["kind"].as_str()), (2, Some("usage")), "{usage}");
}

/// With real processes: requests that were sent before a release find the result, however fast the release follows.
#[test]
fn a_release_overtakes_no_strike_of_the_same_client() {
    let here = place("ordered");
    let _daemon = Child::start(&mut shatterd(&here));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let bar = service.object("bar", timeout()).unwrap();
    for round in 0..6 {
        let before = strike(&bar, &base_impact().keep());
        let (fragment, impact) = largest(&before);
        let impact = impact.from(before.handle().unwrap(), fragment);
        let mut tickets: Vec<_> = (0..3).map(|_| bar.strike(&impact).unwrap()).collect();
        let released = service.release(before.handle().unwrap(), timeout());
        assert_eq!(released, Ok(()), "round {round}");
        for ticket in &mut tickets {
            assert!(ticket.wait(timeout()).is_ok(), "round {round}");
        }
        assert_eq!(refused(&bar, &impact).kind, ErrorKind::UnknownHandle);
    }
}

/// With real processes: a request that is canceled before the daemon looks for it never arrives, and no release waits for it.
#[test]
fn a_release_waits_for_no_canceled_strike() {
    let here = place("canceled");
    let _daemon = Child::start(&mut shatterd(&here));
    let service = Client::connect_at(&here.place, timeout()).unwrap();
    let bar = service.object("bar", timeout()).unwrap();
    // Less than the daemon waits for a request that never arrives.
    let deadline = || Deadline::after(Duration::from_secs(4));
    for round in 0..3 {
        let before = strike(&bar, &base_impact().keep());
        drop(bar.strike(&base_impact()).unwrap());
        assert_eq!(service.release(before.handle().unwrap(), deadline()), Ok(()), "round {round}");
    }
}

/// A release that arrives before the request that it follows waits for the request; raw messages force this order.
#[test]
fn a_release_waits_for_the_strike_that_it_follows() {
    let (daemon, service, bar) = start("");
    let before = strike(&bar, &base_impact().keep());
    let (handle, (fragment, impact)) = (before.handle().unwrap(), largest(&before));
    let (peer, listener) = (RawPeer::open(&daemon.here.place), [7; 16]);
    let asked = peer.ask(ControlRequest::Release { handle, after: 1 }.wire(listener));
    // A later question that was answered was also admitted later.
    assert_eq!(status(&service).kept, 1);
    assert_eq!(peer.reply(&asked), None);
    let contact = Contact::new([0.0; 3]).impulse([1.0; 3]);
    let strike = Request { object: "bar".into(), contacts: vec![contact], ..Request::default() };
    let strike = Request { from: Some(RetainedFragment { handle, fragment }), ..strike };
    let sent = peer.send(RequestWire { sequence: 1, ..strike.wire(listener).unwrap() });
    assert_ne!(peer.outcome(&sent).err().flatten(), Some(ErrorKind::UnknownHandle));
    eventually(|| "the release has a reply", || peer.reply(&asked) == Some(Ok(())));
    assert_eq!(refused(&bar, &impact.from(handle, fragment)).kind, ErrorKind::UnknownHandle);
}

/// The same for a question about progress, which can overtake its request.
#[test]
fn progress_never_says_that_a_strike_ended_which_has_not_arrived() {
    let here = TestDirectory::new("progress");
    here.database("slow", "slow");
    let daemon = InProcess::start(here, "");
    let slow = daemon.connect().object("slow", timeout()).unwrap();
    for round in 0..50 {
        let mut ticket = slow.strike(&Impact::new([Contact::new([0.0; 3]).impulse([-1.0, 0.0, 0.0])])).unwrap();
        let deadline = timeout();
        while !matches!(ticket.progress(), Progress::Computing { .. }) {
            assert!(ticket.progress() != Progress::Ended && !deadline.passed(), "round {round}");
        }
    }
}
