//! `shatter status`.

use super::when::utc;
use super::{Failure, document, objects, out, reply};
use serde_json::{Map, Value, json};
use shatter_client::{Deadline, Latency, ObjectFacts, Shatter, Status};
use std::time::Duration;

/// Pause between two looks of `--watch`.
const PAUSE: Duration = Duration::from_secs(1);

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

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

/// Shows how the service goes.
pub fn run(service: &str, args: &Args) -> Result<(), Failure> {
    let connection = match args.wait {
        Some(wait) => Shatter::wait_for(service, Deadline::after(wait))?,
        None => Shatter::connect(service, reply())?,
    };
    loop {
        let (status, loaded) = (connection.status(reply())?, connection.objects(reply())?);
        match (args.json, args.watch) {
            (true, false) => document(&to_json(service, &status, &loaded))?,
            (true, true) => out(format_args!("{}\n", to_json(service, &status, &loaded)))?,
            (false, _) => screen(service, &status, &loaded)?,
        }
        if !args.watch {
            return Ok(());
        }
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
        "objects_outdated": row.objects_outdated,
        "memory_bytes": row.memory_bytes,
        "retired": row.retired,
        "retired_bytes": row.retired_bytes,
        "reloads": row.reloads,
        "read_unix_s": row.read_unix_ns as f64 * 1e-9,
        "threads": row.threads,
        "clients": row.clients,
        "running": row.running,
        "queued": row.queued,
        "queue_max": row.queue_max,
        "buckets": row.buckets,
        "bucket_bytes": row.bucket_bytes,
        "answered": row.answered,
        "refused": row.refused,
        "busy": row.busy,
        "failed": row.failed,
        "cancelled": row.cancelled,
        "strike": latency(&row.strike),
        "stages": stages,
        "objects": loaded.iter().map(objects::loaded).collect::<Vec<_>>(),
    })
}

fn screen(service: &str, status: &Status, loaded: &[ObjectFacts]) -> Result<(), Failure> {
    let row = status.row();
    out(format_args!(
        "{service}: pid {}, up {:.0} s, {} objects ready, {} failed, {} clients, {} threads\n",
        row.pid,
        row.uptime_ns as f64 * 1e-9,
        row.objects_ready,
        row.objects_failed,
        row.clients,
        row.threads
    ))?;
    out(format_args!(
        "strikes: {} running, {} of {} queued; {} answered, {} refused, {} busy, {} failed, {} cancelled\n",
        row.running, row.queued, row.queue_max, row.answered, row.refused, row.busy, row.failed, row.cancelled
    ))?;
    out(format_args!("answers: {} buckets of {:.1} MiB\n", row.buckets, row.bucket_bytes as f64 / 1_048_576.0))?;
    out(format_args!("{:14} {:>8} {:>9} {:>9} {:>9} {:>9}  ms\n", "", "count", "p50", "p90", "p99", "max"))?;
    for (name, times) in std::iter::once(("strike", &row.strike)).chain(status.stages()) {
        let ms = |ns: u64| ns as f64 * 1e-6;
        out(format_args!(
            "{name:14} {:8} {:9.3} {:9.3} {:9.3} {:9.3}\n",
            times.count,
            ms(times.p50_ns),
            ms(times.p90_ns),
            ms(times.p99_ns),
            ms(times.max_ns)
        ))?;
    }
    let mib = |bytes: u64| bytes as f64 / 1_048_576.0;
    out(format_args!(
        "databases: read {}, {} reloads; {:.1} MiB of memory, {:.1} MiB more in {} replaced objects still being struck\n",
        utc(Duration::from_nanos(row.read_unix_ns)),
        row.reloads,
        mib(row.memory_bytes),
        mib(row.retired_bytes),
        row.retired
    ))?;
    objects::table(loaded)
}
