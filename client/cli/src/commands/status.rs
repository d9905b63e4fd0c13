//! `shatter status`.

use super::time_of_day::utc;
use super::wait::{seconds, until};
use super::{CliError, document, objects, out, reply};
use serde_json::{Map, Value, json};
use shatter_client::{Client, Deadline, Error, Latency, ObjectFacts, ObjectState, Status};
use shatter_proto::text::counted;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Pause between two updates of `--watch`.
const PAUSE: Duration = Duration::from_secs(1);

/// Control sequence that clears a terminal and moves to its first line.
const CLEAR: &str = "\x1b[2J\x1b[H";

/// Arguments of `shatter status`.
#[derive(clap::Args)]
pub struct Args {
    /// Print the status again every second until interrupted
    #[arg(long)]
    watch: bool,
    /// Longest wait for the service to be ready, s. A daemon that runs without replying is waited for at least 5 s
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    wait: Option<Duration>,
    /// Print one JSON document on stdout (one per line with --watch)
    #[arg(long)]
    json: bool,
}

/// Prints the state of the service.
pub fn run(service: &str, args: &Args) -> Result<(), CliError> {
    let deadline = args.wait.map(Deadline::after);
    // A daemon that ends or starts in between is not ready: the wait goes on.
    let (connection, (status, loaded)) = until(deadline, || read_state(service, deadline))?;
    if args.watch {
        return watch(service, &connection, args.json);
    }
    if args.json {
        return document(&to_json(service, &status, &loaded));
    }
    out(format_args!("{}", screen(service, &status, &loaded, None)))
}

type ServiceState = (Status, Vec<ObjectFacts>);

/// Connects and queries the service once. With a deadline it waits for a daemon.
fn read_state(service: &str, deadline: Option<Deadline>) -> Result<(Client, ServiceState), Error> {
    let connection = match deadline {
        Some(deadline) => Client::wait_for(service, deadline)?,
        None => Client::connect(service, reply())?,
    };
    let state = state_of(&connection)?;
    Ok((connection, state))
}

/// Queries status and list, one after the other. Objects are counted in the list, so that both agree if objects change in between.
fn state_of(connection: &Client) -> Result<ServiceState, Error> {
    let (status, loaded) = (connection.status(reply())?, connection.objects(reply())?);
    Ok((counted_in(status, &loaded), loaded))
}

/// `status` with the numbers of objects of the list `loaded`.
fn counted_in(mut status: Status, loaded: &[ObjectFacts]) -> Status {
    let count = |is_counted: &dyn Fn(&ObjectFacts) -> bool| loaded.iter().filter(|own| is_counted(own)).count() as u32;
    status.objects_ready = count(&|own| own.is_ready());
    status.objects_loading = count(&|own| own.state == ObjectState::Loading);
    status.objects_failed = loaded.len() as u32 - status.objects_ready - status.objects_loading;
    status.objects_outdated = count(&|own| own.is_ready() && own.error.is_some());
    status
}

/// Prints the state again and again; daemons may end and start meanwhile.
fn watch(service: &str, connection: &Client, json: bool) -> Result<(), CliError> {
    let mut last: Option<(Instant, Status)> = None;
    loop {
        let looked = state_of(connection);
        let text = match &looked {
            Ok((status, loaded)) if json => format!("{}\n", to_json(service, status, loaded)),
            Ok((status, loaded)) => screen(service, status, loaded, last.as_ref()),
            Err(error) if json => format!("{}\n", error.document()),
            Err(error) => format!("{service}: {error}\n"),
        };
        last = looked.ok().map(|(status, _)| (Instant::now(), status));
        let clear = if !json && std::io::stdout().is_terminal() { CLEAR } else { "" };
        out(format_args!("{clear}{text}"))?;
        std::thread::sleep(PAUSE);
    }
}

fn latency(latency: &Latency) -> Value {
    json!({
        "count": latency.count,
        "p50_ns": latency.p50_ns,
        "p90_ns": latency.p90_ns,
        "p99_ns": latency.p99_ns,
        "max_ns": latency.max_ns,
    })
}

fn to_json(service: &str, status: &Status, loaded: &[ObjectFacts]) -> Value {
    let stages: Map<String, Value> =
        status.stage_times.iter().map(|(stage, times)| (stage.name().to_owned(), latency(times))).collect();
    json!({
        "service": service,
        "pid": status.pid,
        "uptime_s": status.uptime.as_secs_f64(),
        "objects_ready": status.objects_ready,
        "objects_failed": status.objects_failed,
        "objects_loading": status.objects_loading,
        "objects_outdated": status.objects_outdated,
        "memory_bytes": status.memory_bytes,
        "retired": status.retired,
        "retired_bytes": status.retired_bytes,
        "kept": status.kept,
        "kept_bytes": status.kept_bytes,
        "reloads": status.reloads,
        "read_unix_s": status.read_unix.as_secs_f64(),
        "threads": status.threads,
        "clients": status.clients,
        "clients_max": status.clients_max,
        "running": status.running,
        "queued": status.queued,
        "queue_max": status.queue_max,
        "buckets": status.buckets,
        "bucket_bytes": status.bucket_bytes,
        "unread": status.unread,
        "buckets_used_max": status.buckets_used_max,
        "buckets_bytes": status.buckets_bytes,
        "restarts": status.restarts,
        "crashes": status.crashes,
        "ending": status.is_ending,
        "completed": status.completed,
        "refused": status.refused,
        "busy": status.busy,
        "late": status.late,
        "failed": status.failed,
        "canceled": status.canceled,
        "strike": latency(&status.request_times),
        "stages": stages,
        "objects": loaded.iter().map(objects::loaded).collect::<Vec<_>>(),
    })
}

/// One screen of text; `last` is the state at the update before, for rates.
fn screen(service: &str, status: &Status, loaded: &[ObjectFacts], last: Option<&(Instant, Status)>) -> String {
    let mib = |bytes: u64| bytes as f64 / 1_048_576.0;
    let mut text = format!(
        "{service}: {}pid {}, up {:.0} s, {} ready, {} loading, {} failed, {} of {}, {}; {}, {} of them after crashes\n",
        if status.is_ending { "ending, " } else { "" },
        status.pid,
        status.uptime.as_secs_f64(),
        counted(status.objects_ready.into(), "object"),
        status.objects_loading,
        status.objects_failed,
        status.clients,
        counted(status.clients_max.into(), "client"),
        counted(status.threads.into(), "thread"),
        counted(status.restarts, "restart"),
        status.crashes
    );
    text += &format!(
        "requests: {} running, {} of {} queued; {} completed{}, {} refused, {} busy, {} late, {} failed, {} canceled\n",
        status.running,
        status.queued,
        status.queue_max,
        status.completed,
        last.map(|last| rate(last, status)).unwrap_or_default(),
        status.refused,
        status.busy,
        status.late,
        status.failed,
        status.canceled
    );
    text += &format!(
        "results: {} of {:.1} MiB, {} unread; at most {} were held or prepared at once, {:.1} MiB exist; {} kept for later requests, {:.1} MiB\n",
        counted(status.buckets.into(), "bucket"),
        mib(status.bucket_bytes),
        status.unread,
        status.buckets_used_max,
        mib(status.buckets_bytes),
        status.kept,
        mib(status.kept_bytes)
    );
    text += &format!("{:14} {:>8} {:>9} {:>9} {:>9} {:>9}  ms\n", "", "count", "p50", "p90", "p99", "max");
    let stages = status.stage_times.iter().map(|(stage, times)| (stage.name(), times));
    for (name, times) in std::iter::once(("strike", &status.request_times)).chain(stages) {
        let [p50, p90, p99, max] = [times.p50_ns, times.p90_ns, times.p99_ns, times.max_ns].map(|ns| ns as f64 * 1e-6);
        text += &format!("{name:14} {:8} {p50:9.3} {p90:9.3} {p99:9.3} {max:9.3}\n", times.count);
    }
    text += &format!(
        "databases: read {}, {}; {:.1} MiB of memory, {:.1} MiB more in {} still in use\n",
        utc(status.read_unix),
        counted(status.reloads, "reload"),
        mib(status.memory_bytes),
        mib(status.retired_bytes),
        counted(status.retired, "replaced or removed object")
    );
    text + &objects::table(loaded)
}

/// Results per second since the last update, of the same daemon.
fn rate((then, last): &(Instant, Status), status: &Status) -> String {
    if last.pid != status.pid {
        return String::new();
    }
    format!(" ({:.0}/s)", status.completed.saturating_sub(last.completed) as f64 / then.elapsed().as_secs_f64())
}
