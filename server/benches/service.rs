//! Cost that the service adds to the computation, in one run: the same strikes in this process and through the daemon, at saturation, at
//! 80 % of it and at three times it. `cargo bench --bench service` takes a generated mug, or the mesh file that
//! `SHATTER_BENCH_MESH` names; `SHATTER_BENCH_SECONDS` is the length of each of its parts (8).
//!
//! Ratios are of medians of alternating rounds: on a shared machine a second is not always a second.

#[path = "../tests/support/mod.rs"]
mod support;

use rayon::ThreadPool;
use serde_json::Value;
use shatter_client::{Client, Deadline, ErrorKind, Impact, Poll, Ticket};
use shatter_engine::object::ServedObject;
use shatter_engine::stage_profiler::StageProfiler;
use shatter_engine::wire::EngineObject;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake, load, save};
use shatter_fracture::pipeline::{PreparedObject, SurfaceKind, Workspace};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::{self, LengthUnit, RawMesh, UpAxis, shapes};
use shatter_proto::layout::Layout;
use shatter_proto::request::{Contact, DegreeRule, Request};
use shatter_proto::result::{AlignedBlock, ResultHeader};
use shatter_server::jobs::lanes;
use std::path::Path;
use std::sync::Barrier;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use support::{Child, InProcess, TestDirectory, shatter, shatterd, timeout};

const SITES: u32 = 50;
const CLIENTS: &str = "8";
const ROUNDS: usize = 5;
/// That of the daemon's threads.
const NICE: i32 = 5;

fn seconds() -> f64 {
    std::env::var("SHATTER_BENCH_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(8.0)
}

fn mesh() -> RawMesh {
    match std::env::var_os("SHATTER_BENCH_MESH") {
        Some(path) => surface::read(path.as_ref(), LengthUnit::M, UpAxis::Y).unwrap(),
        None => shapes::mug(),
    }
}

fn database(folder: &Path) -> PreparedObject {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let ceramic = materials.get("ceramic").unwrap().clone();
    let request =
        BakeRequest { seed: 1, surface: SurfaceKind::Lattice, ..BakeRequest::new("bench", "ceramic", ceramic) };
    let file = folder.join("bench.shatter");
    save(&bake(mesh(), &request, &CancelToken::default(), &mut |_| {}).unwrap(), &file).unwrap();
    load(&file).unwrap()
}

/// An impact somewhere on the surface, towards the middle.
fn request(served: &EngineObject, number: usize) -> Request {
    let prepared = served.prepared();
    let body = &prepared.bodies[0];
    let face = &body.topology.boundary[number.wrapping_mul(7919) % body.topology.boundary.len()];
    let point_m = prepared.frame.to_meters(&body.crack.nodes[face.nodes[0] as usize]);
    let impulse_ns = (prepared.frame.center_m - point_m).normalize().into();
    let contact = Contact {
        point_m: point_m.coords.into(),
        ray: None,
        impulse_ns,
        duration_s: None,
        radius_m: None,
        partner: None,
    };
    let object = "bench".to_owned();
    Request {
        object,
        contacts: vec![contact],
        degree: DegreeRule::Sites(SITES),
        seed: number as u64,
        ..Request::default()
    }
}

/// Computes one result from request to bytes, as the daemon's threads do; returns its length, and time of all stages.
fn strike_in_process(
    served: &EngineObject,
    number: usize,
    workspace: &mut Workspace,
    payload: &mut Vec<AlignedBlock>,
) -> (u64, u64) {
    let clock = StageProfiler::default();
    let strike = request(served, number);
    let outcome = served.strike(&strike, workspace, &CancelToken::default(), &clock).unwrap();
    let layout = Layout::new(&outcome.counts()).unwrap();
    payload.resize(payload.len().max(layout.blocks()), bytemuck::Zeroable::zeroed());
    let _header: ResultHeader = layout.header(0);
    outcome.write(&mut layout.split(&mut payload[..layout.blocks()]).unwrap(), &clock).unwrap();
    let stages: Duration = clock.stages().iter().map(|cost| cost.time).sum();
    (layout.used_bytes(), stages.as_nanos() as u64)
}

/// Strikes per second of as many strikes side by side as there are threads, each on one of them.
fn in_process(served: &EngineObject, lanes: &[ThreadPool]) -> (f64, u64, Duration) {
    let (done, bytes, busy) = (AtomicUsize::new(0), AtomicU64::new(0), AtomicU64::new(0));
    let (begun, length) = (Instant::now(), Duration::from_secs_f64(seconds()));
    let work = || {
        let (mut workspace, mut payload) = (Workspace::default(), Vec::new());
        while begun.elapsed() < length {
            let number = done.fetch_add(1, Ordering::Relaxed);
            let (used, ns) = strike_in_process(served, number, &mut workspace, &mut payload);
            bytes.fetch_add(used, Ordering::Relaxed);
            busy.fetch_add(ns, Ordering::Relaxed);
        }
    };
    std::thread::scope(|scope| lanes.iter().for_each(|lane| _ = scope.spawn(|| lane.install(work))));
    let count = done.load(Ordering::Relaxed);
    let each = Duration::from_nanos(busy.load(Ordering::Relaxed) / count as u64);
    (count as f64 / begun.elapsed().as_secs_f64(), bytes.load(Ordering::Relaxed) / count as u64, each)
}

/// One run of the load tool.
fn loaded(here: &TestDirectory, clients: &str, how: &[&str]) -> Value {
    let (seconds, sites) = (seconds().to_string(), SITES.to_string());
    let all = ["load", "bench", "--clients", clients, "--seconds", &seconds, "--degree", &sites, "--json"];
    let (code, text) = shatter(here, &[&all, how].concat());
    assert_eq!(code, 0, "{text}");
    serde_json::from_str(&text).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Results of the slowest client over those of the fastest.
fn fairness(report: &Value) -> f64 {
    let each: Vec<f64> = report["per_client_ok"].as_array().unwrap().iter().map(number).collect();
    each.iter().copied().fold(f64::INFINITY, f64::min) / each.iter().copied().fold(0.0, f64::max)
}

fn main() {
    // `cargo test` may run benches to see that they begin.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    let here = TestDirectory::new("bench");
    let served = EngineObject::whole(database(&here.databases()));
    served.finish().unwrap();
    let lanes = lanes(std::thread::available_parallelism().map_or(1, usize::from), NICE).unwrap();
    let daemon = Child::start(&mut shatterd(&here));
    let saturation = saturated(&here, &served, &lanes);
    steady(&here, 0.8 * saturation);
    overloaded(&here);
    for (name, apart) in [("enough for all", 1.5), ("enough for half", 0.5)] {
        wall(&here, name, Duration::from_secs_f64(apart / saturation));
    }
    let report = loaded(&here, "1", &["--closed"]);
    println!(
        "one client: round trip less stages, median {} us, of which the machine sleeps most",
        report["ipc_share_us_p50"]
    );
    assert_eq!(daemon.terminate().code(), Some(0));
    let (us, bytes) = share();
    println!("round trip less stages, back to back: median {us:.0} us for {bytes} bytes (wanted: 150 for 1 MB)");
}

/// Throughput at saturation, beside the same requests in this process; results per second.
fn saturated(here: &TestDirectory, served: &EngineObject, lanes: &[ThreadPool]) -> f64 {
    let (mut ratios, mut through, mut fair) = (Vec::new(), Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        let with = || loaded(here, CLIENTS, &["--closed", "--seed", &round.to_string()]);
        // By turns the one and the other first: a machine that slows down favors neither.
        let ((rate, bytes, each), report) = match round % 2 {
            0 => (in_process(served, lanes), with()),
            _ => {
                let report = with();
                (in_process(served, lanes), report)
            }
        };
        println!(
            "round {round}: in process {rate:.1}/s ({:.1} ms each, {bytes} bytes), {CLIENTS} clients {:.1}/s, slowest/fastest {:.2}",
            each.as_secs_f64() * 1e3,
            number(&report["throughput_hz"]),
            fairness(&report)
        );
        ratios.push(number(&report["throughput_hz"]) / rate);
        through.push(number(&report["throughput_hz"]));
        fair.push(fairness(&report));
    }
    let saturation = median(through);
    println!("throughput through the service over in process: {:.3} (wanted: 0.9)", median(ratios));
    println!("slowest client over fastest: {:.3} (wanted: 0.8)", median(fair));
    saturation
}

/// Four fifths of that, beside an ideal queue.
fn steady(here: &TestDirectory, rate: f64) {
    let mut ratios = Vec::new();
    for round in 0..ROUNDS {
        let report = loaded(here, CLIENTS, &["--rate", &rate.to_string(), "--seed", &round.to_string()]);
        let (p99, ideal) = (number(&report["latency_us"]["p99"]), number(&report["ideal_queue_p99_us"]));
        println!(
            "at 80 %, round {round}: {} of {} ok, p99 {:.1} ms, ideal queue {:.1} ms",
            report["ok"],
            report["sent"],
            p99 * 1e-3,
            ideal * 1e-3
        );
        ratios.push(p99 / ideal);
    }
    println!("at 80 %: p99 over that of the ideal queue: {:.2} (wanted: 1.5)", median(ratios));
}

/// Three times as much as it can do, after as much as it can do.
fn overloaded(here: &TestDirectory) {
    let (mut goodput, mut refused) = (Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        let seed = round.to_string();
        let saturation = number(&loaded(here, CLIENTS, &["--closed", "--seed", &seed])["throughput_hz"]);
        let report = loaded(here, CLIENTS, &["--rate", &(3.0 * saturation).to_string(), "--seed", &seed]);
        let within = |share: &str| number(&report["refusal_us"][share]) * 1e-3;
        println!(
            "at 300 %, round {round}: {:.1}/s of {saturation:.1}/s; {} of {} ok, {} busy, refused within {:.2} ms (median), {:.2} ms (99 of 100)",
            number(&report["throughput_hz"]),
            report["ok"],
            report["sent"],
            report["busy"],
            within("p50"),
            within("p99")
        );
        goodput.push(number(&report["throughput_hz"]) / saturation);
        refused.push((within("p50"), within("p99")));
    }
    println!("at 300 %: goodput over saturation: {:.3} (wanted: 0.9)", median(goodput));
    let (half, nearly_all) = refused.into_iter().unzip();
    println!(
        "at 300 %: refused within {:.2} ms (median; wanted: 2), {:.2} ms (99 of 100; wanted: 10)",
        median(half),
        median(nearly_all)
    );
}

/// Forty impacts at once from four clients, whose deadlines lie so far apart.
fn wall(here: &TestDirectory, name: &str, apart: Duration) {
    const CLIENTS: usize = 4;
    const ALL: u32 = 40;
    let together = Barrier::new(CLIENTS);
    let client = |first: usize| {
        let service = Client::connect_at(&here.place, timeout()).unwrap();
        let bench = service.object("bench", timeout()).unwrap();
        together.wait();
        let begun = Instant::now();
        let send = |rank: u32| {
            let deadline = (4 + rank) * apart;
            let impact = Impact::new([Contact::new(bench.facts().center_m)
                .impulse([1.0, 0.0, 0.0])
                .radius(bench.facts().diagonal_m)]);
            let impact = impact.degree(DegreeRule::Sites(SITES)).seed(rank.into()).deadline(deadline);
            (Instant::now() + deadline, bench.strike(&impact).unwrap())
        };
        let mut tickets: Vec<(Instant, Ticket)> = (first as u32..ALL).step_by(CLIENTS).map(send).collect();
        let sent = begun.elapsed();
        let mut ends = Vec::new();
        while !tickets.is_empty() {
            tickets.retain_mut(|(deadline, ticket)| match ticket.poll() {
                Ok(Poll::Pending) => true,
                ended => {
                    ends.push((
                        ended.map(drop).map_err(|error| error.kind),
                        Instant::now().saturating_duration_since(*deadline),
                    ));
                    false
                }
            });
            service.wait_for_reply(Deadline::ms(1));
        }
        (sent, ends)
    };
    let (sent, ends): (Vec<Duration>, Vec<_>) = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..CLIENTS).map(|first| scope.spawn(move || client(first))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).unzip()
    });
    let ends: Vec<(Result<(), ErrorKind>, Duration)> = ends.into_iter().flatten().collect();
    let of = |end: Result<(), ErrorKind>| {
        ends.iter().filter(move |(found, _)| *found == end).map(|(_, over)| over.as_secs_f64() * 1e3)
    };
    let most = |end| of(end).fold(0.0, f64::max);
    println!(
        "forty at once ({name}), sent within {:.2} ms: {} answered (at most {:.2} ms late), {} refused as late (at most {:.2} ms after)",
        sent.iter().max().unwrap().as_secs_f64() * 1e3,
        of(Ok(())).count(),
        most(Ok(())),
        of(Err(ErrorKind::Late)).count(),
        most(Err(ErrorKind::Late))
    );
    assert_eq!(of(Ok(())).count() + of(Err(ErrorKind::Late)).count(), ALL as usize, "{ends:?}");
}

/// Median time of a round trip outside the stages, µs, for requests that only write a result, and the length of that result.
fn share() -> (f64, u64) {
    let here = TestDirectory::new("share");
    here.database("large", "large 1000");
    let daemon = InProcess::start(here, "");
    let large = daemon.connect().object("large", timeout()).unwrap();
    let mut bytes = 0;
    let mut once = || {
        let result = large
            .strike(&Impact::new([Contact::new([0.0; 3]).impulse([1.0, 0.0, 0.0])]))
            .unwrap()
            .wait(timeout())
            .unwrap();
        bytes = result.bytes();
        let stages: Duration = result.stages().map(|cost| cost.time).sum();
        (result.round_trip().as_secs_f64() - stages.as_secs_f64()) * 1e6
    };
    let times = (0..2000).map(|_| once()).collect();
    (median(times), bytes)
}
