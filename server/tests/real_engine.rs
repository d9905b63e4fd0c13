//! The real engine behind the real transport: a bar is baked, saved, loaded by the daemon and struck through the client. The tessellator's
//! output lies in shared memory.

mod support;

use shatter_client::{
    Contact, DegreeMethod, DegreeOrigin, DegreeRule, EffectCost, EnergySource, Error, ErrorKind, Impact, Object,
    OverrunCause, Quality, StageCost, StageKind, StopCriterion,
};
use shatter_engine::object::{self, EngineResult, Loader};
use shatter_engine::wire;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::pipeline::{StageObserver, Workspace};
use shatter_proto::control::ObjectRow;
use shatter_proto::layout::{SectionCounts, SectionsMut};
use shatter_proto::request::Request;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex};
use support::{InProcess, TestDirectory, bar, timeout, within};

/// Database of a bar, baked once for all tests: the bytes of the file.
static BAR: LazyLock<Vec<u8>> = LazyLock::new(|| bar(0.08));

/// Address ranges to which sections were written.
type Written = Arc<Mutex<Vec<Range<usize>>>>;

/// The real object, which records the addresses of its results.
struct StageLog(Arc<dyn object::ServedObject>, Written);

impl object::ServedObject for StageLog {
    fn row(&self) -> ObjectRow {
        self.0.row()
    }

    fn bytes(&self) -> usize {
        self.0.bytes()
    }

    fn result_bytes_max(&self) -> usize {
        self.0.result_bytes_max()
    }

    fn strike(
        &self,
        strike: &Request,
        workspace: &mut Workspace,
        token: &CancelToken,
        observer: &dyn StageObserver,
    ) -> Result<Box<dyn EngineResult>, Error> {
        let outcome = self.0.strike(strike, workspace, token, observer)?;
        Ok(Box::new(WatchedOutcome(outcome, self.1.clone())))
    }
}

struct WatchedOutcome(Box<dyn EngineResult>, Written);

impl EngineResult for WatchedOutcome {
    fn counts(&self) -> SectionCounts {
        self.0.counts()
    }

    fn write(&self, sections: &mut SectionsMut<'_>, observer: &dyn StageObserver) -> Result<(), Error> {
        let range = |start: usize, bytes: usize| start..start + bytes;
        self.1.lock().unwrap().extend([
            range(sections.positions.as_ptr() as usize, size_of_val(sections.positions)),
            range(sections.indices.as_ptr() as usize, size_of_val(sections.indices)),
            range(sections.merges.as_ptr() as usize, size_of_val(sections.merges)),
        ]);
        self.0.write(sections, observer)
    }
}

/// Starts a daemon with the bar; returns the object over a connection.
fn start(settings: &str) -> (InProcess, Object, Written) {
    let here = TestDirectory::new("real");
    std::fs::write(here.databases().join("bar.shatter"), BAR.as_slice()).unwrap();
    let written = Written::default();
    let (real, seen) = (wire::loader(None), written.clone());
    let loader: Loader = Arc::new(move |path: &Path, name| Ok(Arc::new(StageLog(real(path, name)?, seen.clone()))));
    let daemon = InProcess::start_with(here, settings, loader);
    let bar = daemon.connect().object("bar", timeout()).unwrap();
    (daemon, bar, written)
}

/// An impact on the end of the bar.
fn base_impact(impulse_ns: f64) -> Impact {
    Impact::new([Contact::new([0.2, 0.0, 0.0]).impulse([-impulse_ns, 0.0, 0.0]).radius(0.05)])
}

#[test]
fn the_tessellator_writes_into_the_mapped_segment() {
    let (daemon, bar, written) = start("");
    let result = bar.strike(&base_impact(50.0).degree(DegreeRule::Sites(12))).unwrap().wait(timeout()).unwrap();
    assert!(result.fragments().len() >= 12);
    let mapped = daemon.here.mapped();
    let written = written.lock().unwrap();
    assert_eq!(written.len(), 3);
    for range in written.iter() {
        assert!(!range.is_empty() && within(range, &mapped), "{range:x?} is not in {mapped:x?}");
    }
}

#[test]
fn fragments_are_closed_and_weigh_what_the_bar_weighs() {
    let (_daemon, bar, _) = start("");
    let facts = bar.facts();
    assert_eq!((facts.name.as_str(), facts.material.as_str(), facts.bodies), ("bar", "glass", 1));
    let result = bar.strike(&base_impact(50.0).degree(DegreeRule::Sites(20))).unwrap().wait(timeout()).unwrap();
    assert!(result.fragments().all(|fragment| fragment.is_closed()));
    let volume: f64 = result.fragments().map(|fragment| fragment.volume_m3()).sum();
    let mass: f64 = result.fragments().map(|fragment| fragment.mass_kg()).sum();
    assert!((volume / facts.volume_m3 - 1.0).abs() < 1e-6, "{volume} of {}", facts.volume_m3);
    assert!((mass / (facts.volume_m3 * facts.density_kg_m3) - 1.0).abs() < 1e-6);
    let summary = result.summary();
    assert_eq!((summary.sites, summary.degree_origin), (20, DegreeOrigin::Forced));
    assert!(result.stages().all(|cost| cost.has_run || cost.stage == StageKind::Degree));
}

#[test]
fn twice_the_threshold_breaks_and_half_does_not() {
    let (_daemon, bar, _) = start("");
    let strike = |impact: Impact| bar.strike(&impact).unwrap().wait(timeout()).unwrap();
    let threshold_factor = strike(base_impact(1.0).threshold_only()).summary().threshold_impulse_factor;
    let whole = strike(base_impact(0.5 * threshold_factor));
    assert!(whole.is_whole());
    assert_eq!((whole.summary().fracture_degree, whole.summary().degree_origin.name()), (1, "threshold"));
    let ran: Vec<&str> = whole.stages().filter(|cost| cost.has_run).map(|cost| cost.stage.name()).collect();
    assert_eq!(ran, ["load", "elasticity", "threshold"]);
    let weak = strike(base_impact(0.01 * threshold_factor));
    assert_eq!(
        (weak.is_whole(), weak.summary().energy_source.name(), whole.summary().energy_source.name()),
        (true, "bounded", "solve")
    );
    assert!(weak.summary().e1_over_gamma >= 1e-4 && weak.summary().threshold_impulse_factor <= 100.0);
    let ran: Vec<&str> = weak.stages().filter(|cost| cost.has_run).map(|cost| cost.stage.name()).collect();
    assert_eq!(ran, ["load", "threshold"]);
    assert!(weak.stages().all(|cost| cost.has_run || cost == StageCost::idle(cost.stage)));
    assert!(weak.effects().all(|cost| cost == EffectCost::idle(cost.effect)));
    let result = strike(base_impact(2.0 * threshold_factor));
    assert!(result.fragments().len() >= 2 && result.summary().fracture_degree >= 2);
}

#[test]
fn results_do_not_depend_on_threads_or_concurrent_requests() {
    let digest = |threads: usize, other_requests: usize| {
        let (_daemon, bar, _) = start(&format!("[compute]\nthreads = {threads}\nrequests_at_once = 4"));
        let impact = base_impact(60.0).degree(DegreeRule::Sites(15)).seed(3);
        let _other_requests: Vec<_> =
            (0..other_requests).map(|seed| bar.strike(&base_impact(80.0).seed(seed as u64)).unwrap()).collect();
        bar.strike(&impact).unwrap().wait(timeout()).unwrap().digest()
    };
    let alone = digest(1, 0);
    for (threads, other_requests) in [(1, 3), (2, 0), (4, 3)] {
        assert_eq!(digest(threads, other_requests), alone, "{threads} threads, {other_requests} others");
    }
}

#[test]
fn results_report_their_settings() {
    let (_daemon, bar, _) = start("");
    let strike = |impact: Impact| bar.strike(&impact).unwrap().wait(timeout()).unwrap().summary();
    let sites = base_impact(50.0).degree(DegreeRule::Sites(20));
    let game = strike(sites.clone());
    assert_eq!(
        (game.quality, game.degree_method, game.stop_criterion),
        (Some(Quality::Game), DegreeMethod::Sites, StopCriterion::Converged)
    );
    assert_eq!((game.tolerance, game.iterations_max), (2e-2, 200));
    assert_eq!(u64::from(game.crack_nodes), u64::from(bar.facts().crack_nodes));
    assert_eq!((game.energy_source, game.rank, game.energy_error), (EnergySource::Solve, 0, 0.0), "it has no basis");
    assert!(game.elastic_nodes > 0 && game.lift_modes > 0 && game.cvd_gap > 0.0 && !game.time.is_zero());
    let draft = strike(sites.clone().quality(Quality::Draft));
    assert_eq!((draft.quality, draft.tolerance, draft.iterations_max), (Some(Quality::Draft), 5e-2, 4));
    assert!(draft.iterations <= 8 && draft.cvd_gap > game.cvd_gap, "{draft:?}");
    let film = strike(base_impact(50.0).quality(Quality::Film).iterations(5));
    assert_eq!(
        (film.quality, film.degree_method, film.iterations_max),
        (Some(Quality::Film), DegreeMethod::Inferred, 5)
    );
    assert_eq!((film.iterations, film.stop_criterion), (5, StopCriterion::Iterations));
    let whole = strike(base_impact(1e-3).quality(Quality::Draft));
    assert_eq!(
        (whole.quality, whole.stop_criterion, whole.cvd_gap),
        (Some(Quality::Draft), StopCriterion::Complete, 0.0)
    );
}

#[test]
fn without_time_the_start_is_the_result_and_with_enough_nothing_changes() {
    let (_daemon, bar, _) = start("");
    let strike = |impact: &Impact| bar.strike(impact).unwrap().wait(timeout()).unwrap();
    let positions = |result: &shatter_client::FractureResult| {
        result.digest().sections.into_iter().find(|section| section.name == "positions").unwrap().hash
    };
    let sites = base_impact(50.0).degree(DegreeRule::Sites(20));
    let none = strike(&sites.clone().time_ms(1e-3));
    assert_eq!((none.summary().stop_criterion.name(), none.summary().iterations), ("time", 0));
    assert!(none.fragments().all(|fragment| fragment.is_closed()));
    let volume: f64 = none.fragments().map(|fragment| fragment.volume_m3()).sum();
    assert!((volume / bar.facts().volume_m3 - 1.0).abs() < 1e-6, "{volume}");
    assert_eq!(positions(&none), positions(&strike(&sites.clone().iterations(0))));
    let usual = strike(&sites);
    assert_ne!(positions(&none), positions(&usual));
    let hour = strike(&sites.clone().time_ms(3.6e6));
    assert_eq!((hour.summary().stop_criterion.name(), positions(&hour)), ("converged", positions(&usual)));
    let rough = strike(&sites.error(0.2)).summary();
    assert_eq!((rough.stop_criterion, rough.cvd_gap <= 0.2), (StopCriterion::ErrorMet, true), "{rough:?}");
    assert!(rough.iterations < usual.summary().iterations);
    // The limit of the basis under `game`, and the limit that a requested error sets.
    assert_eq!((usual.summary().reduced_error_max, rough.reduced_error_max), (0.1, 0.2));
    let late = strike(&base_impact(50.0).degree(DegreeRule::Optimized).time_ms(1e-3)).summary();
    assert_eq!(
        (late.stop_criterion, late.degree_method, late.degree_origin),
        (StopCriterion::Time, DegreeMethod::Optimized, DegreeOrigin::ClosedForm)
    );
    let with_error_target = strike(&base_impact(50.0).degree(DegreeRule::Verified).error(0.2)).summary();
    assert_eq!(
        (with_error_target.stop_criterion, with_error_target.degree_origin),
        (StopCriterion::ErrorMet, DegreeOrigin::Verified),
        "{with_error_target:?}"
    );
}

#[test]
fn engine_errors_name_the_offending_contact() {
    let (_daemon, bar, _) = start("");
    let error = |impact: Impact| bar.strike(&impact).and_then(|mut ticket| ticket.wait(timeout())).err().unwrap();
    let check = |impact: Impact, kind: ErrorKind, at: &str| {
        let error = error(impact);
        assert_eq!((error.kind, error.at.as_str()), (kind, at), "{error}");
    };
    check(
        Impact::new([Contact::new([1.0, 0.0, 0.0]).impulse([1.0, 0.0, 0.0])]),
        ErrorKind::ContactTooFar,
        "contacts[0].point_m",
    );
    for point in [[0.0, 3.0, 0.0], [1e200, 0.0, 0.0]] {
        let first = Contact::new([0.2, 0.0, 0.0]).impulse([-1.0, 0.0, 0.0]).radius(0.05);
        let impact = Impact::new([first, Contact::new(point).impulse([1.0; 3])]);
        check(impact, ErrorKind::ContactTooFar, "contacts[1].point_m");
    }
    check(base_impact(1e145).gamma(1e-30), ErrorKind::Gamma, "inf");
    check(base_impact(1.0).degree(DegreeRule::Sites(513)), ErrorKind::Degree, "513");
    check(base_impact(1.0).error(-1.0), ErrorKind::Budget, "error_max");
    check(base_impact(1.0).time_ms(f64::NAN), ErrorKind::Budget, "time_ms_max");
    check(base_impact(50.0).degree(DegreeRule::Sites(30)).fragments_max(5), ErrorKind::CapExceeded, "fragments_max");
}

#[test]
fn a_damaged_database_is_named_and_the_other_served() {
    let here = TestDirectory::new("damaged");
    std::fs::write(here.databases().join("bar.shatter"), BAR.as_slice()).unwrap();
    let mut damaged = BAR.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    std::fs::write(here.databases().join("flipped.shatter"), damaged).unwrap();
    std::fs::write(here.databases().join("cut.shatter"), &BAR[..middle]).unwrap();
    let daemon = InProcess::start_with(here, "", wire::loader(None));
    let service = daemon.connect();
    for name in ["flipped", "cut"] {
        let error = service.object(name, timeout()).err().unwrap();
        assert_eq!(error.kind, ErrorKind::CorruptObject, "{error}");
        assert!(error.message.contains(&format!("{name}.shatter")), "{error}");
    }
    let bar = service.object("bar", timeout()).unwrap();
    assert!(!bar.strike(&base_impact(50.0).degree(DegreeRule::Sites(3))).unwrap().wait(timeout()).unwrap().is_whole());
}

/// If no setting can be lowered any more, the request misses its time; the result and the command report by how much and why.
#[test]
fn a_time_that_cannot_be_kept_is_told_with_its_reason() {
    let here = TestDirectory::new("missed");
    here.database("bar", support::bar(0.05));
    let _daemon = support::Child::start(&mut support::shatterd(&here));
    let point = ["impact", "bar", "--point", "0.2,0,0", "--impulse", "-50,0,0", "--degree", "6", "--elastic", "solve"];
    let strike = |time: &str| {
        let mut command = support::shatter_program(&here);
        let out = command.args(point).args(["--time-ms", time, "--json"]).output().unwrap();
        let document: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
        (document["missed_time"].clone(), String::from_utf8(out.stderr).unwrap())
    };
    let (missed, note) = strike("0.001");
    assert!(missed["by_ms"].as_f64().is_some_and(|ms| ms > 0.0), "{missed}");
    assert!(OverrunCause::ALL.iter().any(|cause| missed["reason"] == cause.name()), "{missed}");
    assert!(note.contains("exceeded its time") && note.contains(missed["message"].as_str().unwrap()), "{note}");
    let (kept, note) = strike("60000");
    assert!(kept.is_null() && note.is_empty(), "{kept} {note}");
}
