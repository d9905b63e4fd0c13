//! `shatter status`.

use super::time_of_day::utc;
use super::wait::{seconds, until};
use super::{CliError, document, objects, out, reply};
use serde_json::{Map, Value, json};
use shatter_client::{Client, Deadline, Error, Latency, ObjectFacts, Status};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Pause between two looks of `--watch`.
const PAUSE: Duration = Duration::from_secs(1);

/// Clears a terminal, and goes to its first line.
const CLEAR: &str = "\x1b[2J\x1b[H";

/// Arguments of `shatter status`.
#[derive(clap::Args)]
pub struct Args {
    /// Look again every second until interrupted.
    #[arg(long)]
    watch: bool,
    /// Wait up to this long for the service to be ready, s.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    wait: Option<Duration>,
    /// Print one JSON document (one per line with --watch).
    #[arg(long)]
    json: bool,
}

/// Shows how the service goes.
pub fn run(service: &str, args: &Args) -> Result<(), CliError> {
    let deadline = args.wait.map(Deadline::after);
    // A daemon that ends or begins while it is asked is not the one that is waited for.
    let (connection, (status, loaded)) = until(deadline, || look(service, deadline))?;
    if args.watch {
        return watch(service, &connection, args.json);
    }
    if args.json {
        return document(&to_json(service, &status, &loaded));
    }
    out(format_args!("{}", screen(service, &status, &loaded, None)))
}

type Seen = (Status, Vec<ObjectFacts>);

/// Connects, waiting for a daemon until the deadline if there is one, and asks once.
fn look(service: &str, deadline: Option<Deadline>) -> Result<(Client, Seen), Error> {
    let connection = match deadline {
        Some(deadline) => Client::wait_for(service, deadline)?,
        None => Client::connect(service, reply())?,
    };
    let seen = (connection.status(reply())?, connection.objects(reply())?);
    Ok((connection, seen))
}

/// Looks again and again; daemons may come and go meanwhile.
fn watch(service: &str, connection: &Client, json: bool) -> Result<(), CliError> {
    let mut last: Option<(Instant, Status)> = None;
    loop {
        let looked = connection.status(reply()).and_then(|status| Ok((status, connection.objects(reply())?)));
        let text = match &looked {
            Ok((status, loaded)) if json => format!("{}\n", to_json(service, status, loaded)),
            Ok((status, loaded)) => screen(service, status, loaded, last.as_ref()),
            Err(refusal) if json => format!("{}\n", refusal.document()),
            Err(refusal) => format!("{service}: {refusal}\n"),
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
    let row = status.row();
    let stages: Map<String, Value> = status.stages().map(|(name, times)| (name.to_owned(), latency(times))).collect();
    json!({
        "service": service,
        "pid": row.pid,
        "uptime_s": row.uptime_ns as f64 * 1e-9,
        "objects_ready": row.objects_ready,
        "objects_failed": row.objects_failed,
        "objects_loading": row.objects_loading,
        "objects_outdated": row.objects_outdated,
        "memory_bytes": row.memory_bytes,
        "retired": row.retired,
        "retired_bytes": row.retired_bytes,
        "kept": row.kept,
        "kept_bytes": row.kept_bytes,
        "reloads": row.reloads,
        "read_unix_s": row.read_unix_ns as f64 * 1e-9,
        "threads": row.threads,
        "clients": row.clients,
        "clients_max": row.clients_max,
        "running": row.running,
        "queued": row.queued,
        "queue_max": row.queue_max,
        "buckets": row.buckets,
        "bucket_bytes": row.bucket_bytes,
        "unread": row.unread,
        "buckets_used_max": row.buckets_used_max,
        "buckets_bytes": row.buckets_bytes,
        "restarts": row.restarts,
        "crashes": row.crashes,
        "ending": row.ending != 0,
        "answered": row.answered,
        "refused": row.refused,
        "busy": row.busy,
        "late": row.late,
        "failed": row.failed,
        "cancelled": row.cancelled,
        "strike": latency(&row.strike),
        "stages": stages,
        "objects": loaded.iter().map(objects::loaded).collect::<Vec<_>>(),
    })
}

/// One screen of text; `last` is the look before this one, for rates.
fn screen(service: &str, status: &Status, loaded: &[ObjectFacts], last: Option<&(Instant, Status)>) -> String {
    let row = status.row();
    let mib = |bytes: u64| bytes as f64 / 1_048_576.0;
    let mut text = format!(
        "{service}: {}pid {}, up {:.0} s, {} objects ready, {} loading, {} failed, {} of {} clients, {} threads; {} restarts, {} of them after crashes\n",
        if row.ending == 0 { "" } else { "ending, " },
        row.pid,
        row.uptime_ns as f64 * 1e-9,
        row.objects_ready,
        row.objects_loading,
        row.objects_failed,
        row.clients,
        row.clients_max,
        row.threads,
        row.restarts,
        row.crashes
    );
    text += &format!(
        "strikes: {} running, {} of {} queued; {} answered{}, {} refused, {} busy, {} late, {} failed, {} cancelled\n",
        row.running,
        row.queued,
        row.queue_max,
        row.answered,
        last.map(|last| rate(last, status)).unwrap_or_default(),
        row.refused,
        row.busy,
        row.late,
        row.failed,
        row.cancelled
    );
    text += &format!(
        "answers: {} buckets of {:.1} MiB, {} unread; at most {} were held at once, {:.1} MiB exist; {} kept to be struck again, {:.1} MiB\n",
        row.buckets,
        mib(row.bucket_bytes),
        row.unread,
        row.buckets_used_max,
        mib(row.buckets_bytes),
        row.kept,
        mib(row.kept_bytes)
    );
    text += &format!("{:14} {:>8} {:>9} {:>9} {:>9} {:>9}  ms\n", "", "count", "p50", "p90", "p99", "max");
    for (name, times) in std::iter::once(("strike", &row.strike)).chain(status.stages()) {
        let [p50, p90, p99, max] = [times.p50_ns, times.p90_ns, times.p99_ns, times.max_ns].map(|ns| ns as f64 * 1e-6);
        text += &format!("{name:14} {:8} {p50:9.3} {p90:9.3} {p99:9.3} {max:9.3}\n", times.count);
    }
    text += &format!(
        "databases: read {}, {} reloads; {:.1} MiB of memory, {:.1} MiB more in {} replaced objects still being struck\n",
        utc(Duration::from_nanos(row.read_unix_ns)),
        row.reloads,
        mib(row.memory_bytes),
        mib(row.retired_bytes),
        row.retired
    );
    text + &objects::table(loaded)
}

/// Answers per second since the last look at the same daemon.
fn rate((then, last): &(Instant, Status), status: &Status) -> String {
    let (before, now) = (last.row(), status.row());
    if before.pid != now.pid {
        return String::new();
    }
    format!(" ({:.0}/s)", now.answered.saturating_sub(before.answered) as f64 / then.elapsed().as_secs_f64())
}
