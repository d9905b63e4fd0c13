//! `shatter load`: the service under requests from many client processes.
//!
//! Arrivals are open: every client process draws its own schedule in advance, and the latency of a request counts from its due time,
//! not from the time at which it could be sent. So a slow service cannot hide its delays (G. Tene, *How not to measure latency*).

mod ideal;
mod picture;
mod plan;
mod schedule;
mod tally;
mod worker;

pub use worker::run as work;

use plan::{ClientPlan, LoadTarget};
use serde_json::{Value, json};
use shatter_cli_common::cli_error::{CliError, document, note, out, size};
use shatter_cli_common::whole_number;
use shatter_client::{Client, Deadline, Error, ErrorKind};
use shatter_export::make_folder;
use shatter_fracture::pipeline::DEGREE_MAX;
use shatter_proto::text::counted;
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime};
use tally::{LoadTally, RequestEnd, RequestRecord};

/// Default number of sites per request.
const DEGREE: u32 = 20;

/// Time for client processes to connect before the first request is due.
const HEAD_START: Duration = Duration::from_millis(1500);

/// Time for client processes to report after the last result may arrive.
const MARGIN: Duration = Duration::from_secs(10);

/// Meaningful rates, requests per second.
const RATES: [f64; 2] = [1e-6, 1e6];

/// Meaningful durations of a run, s.
const SECONDS: [f64; 2] = [1e-3, 86_400.0];

/// Time that a command waits for a reply of the service.
const REPLY_TIMEOUT: Duration = Duration::from_secs(5);

/// Time that a client process waits for a result.
const RESULT_TIMEOUT: Duration = Duration::from_secs(120);

/// Deadline for a reply of the service.
fn reply() -> Deadline {
    Deadline::after(REPLY_TIMEOUT)
}

/// Arguments of `shatter load`.
#[derive(clap::Args)]
pub struct LoadArgs {
    /// Objects to strike, in equal parts [default: all that are ready]
    objects: Vec<String>,
    /// Number of client processes
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = whole_number::<u16>(1..=256))]
    clients: u16,
    /// Requests per second of all clients together; several rates, separated by commas, are run one after the other. Required without --closed
    #[arg(long, value_name = "PER_SECOND_TOTAL", value_delimiter = ',', required_unless_present = "closed", value_parser = rate)]
    rate: Vec<f64>,
    /// Closed loop instead of a rate: every client sends its next request as soon as the previous one has ended
    #[arg(long, conflicts_with = "rate")]
    closed: bool,
    /// Duration of each run in seconds
    #[arg(long, value_name = "S", default_value = "10", value_parser = seconds)]
    seconds: f64,
    /// Number of sites of every request [default: 20]
    #[arg(long, value_name = "N", value_parser = whole_number::<u32>(1..=DEGREE_MAX.into()))]
    degree: Option<u32>,
    /// Deadline of every request in milliseconds
    #[arg(long, value_name = "T", value_parser = milliseconds, allow_negative_numbers = true)]
    deadline_ms: Option<u64>,
    /// TOML file with the mix of requests: `[[strike]]` tables with `object` and optionally `weight` [default: 1] and `degree`
    /// [default: 20]
    #[arg(long, value_name = "FILE", conflicts_with_all = ["objects", "degree"])]
    mix: Option<PathBuf>,
    /// Seed of schedules and impacts
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder for load.json, load.csv with every request and, for several rates, load.svg
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document on stdout
    #[arg(long)]
    json: bool,
}

fn rate(text: &str) -> Result<f64, String> {
    within(text, RATES)
}

fn milliseconds(text: &str) -> Result<u64, String> {
    let wrong = || format!("must be a whole number of milliseconds, 1 to {}: 0 leaves no time for a result", u64::MAX);
    text.parse().ok().filter(|ms| *ms > 0).ok_or_else(wrong)
}

fn seconds(text: &str) -> Result<f64, String> {
    within(text, SECONDS)
}

fn within(text: &str, [least, most]: [f64; 2]) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(format!("must be a number from {least} to {most}")),
    }
}

/// Runs the load and prints the results.
pub fn run(service: &str, args: &LoadArgs) -> Result<(), CliError> {
    let connection = Client::connect(service, reply())?;
    let targets = targets(&connection, args)?;
    let servers = connection.status(reply())?.threads.max(1) as usize;
    let rates: Vec<Option<f64>> = if args.closed { vec![None] } else { args.rate.iter().copied().map(Some).collect() };
    let mut runs = Vec::new();
    for rate in rates {
        let records = one(service, args, &targets, rate)?;
        runs.push((rate, LoadTally::of(&records, servers, args.seconds), records));
    }
    let report: Vec<Value> = runs.iter().map(|(rate, tally, _)| tally.document(*rate)).collect();
    let mut report =
        if report.len() == 1 { report.into_iter().next().unwrap_or_default() } else { json!({ "runs": report }) };
    let lost = lost(runs.iter().map(|(_, _, clients)| clients.as_slice()));
    let lost = lost.or_else(|| all_failed(runs.iter().flat_map(|(_, _, clients)| clients.iter().flatten().flatten())));
    if let Some(error) = &lost {
        report["error"] = error.document()["error"].clone();
    }
    if let Some(folder) = &args.out {
        write(folder, &report, &runs)?;
    }
    if args.json {
        document(&report)?;
    } else {
        out(format_args!("{}\n", LoadTally::HEAD))?;
        for (rate, tally, _) in &runs {
            out(format_args!("{}\n{}", tally.line(*rate), tally.complaints()))?;
        }
    }
    lost.map_or(Ok(()), |error| Err(CliError::Reported(error)))
}

/// Error for runs in which no request succeeded; its kind is the most frequent one.
fn all_failed<'a>(records: impl Iterator<Item = &'a RequestRecord>) -> Option<Error> {
    let (mut sent, mut kinds) = (0, BTreeMap::new());
    for record in records {
        let kind = match record.end {
            RequestEnd::Ok => return None,
            RequestEnd::Busy => ErrorKind::Busy.code(),
            RequestEnd::Late => ErrorKind::Late.code(),
            RequestEnd::Failed => record.why.unwrap_or(ErrorKind::Failed.code()),
        };
        sent += 1;
        *kinds.entry(kind).or_insert(0) += 1;
    }
    let (code, _) = kinds.into_iter().max_by_key(|(_, count)| *count)?;
    let kind = ErrorKind::from_code(code).unwrap_or(ErrorKind::Failed);
    Some(Error::new(
        kind,
        "strikes",
        format!("none of {} succeeded; most ended with `{}`", counted(sent, "request"), kind.name()),
    ))
}

/// Error for runs in which client processes ended without a report.
fn lost<'a>(runs: impl Iterator<Item = &'a [Option<Vec<RequestRecord>>]>) -> Option<Error> {
    let (lost, all) = runs.flatten().fold((0, 0), |(lost, all), report| (lost + u32::from(report.is_none()), all + 1));
    let message = format!(
        "{lost} of {all} client processes ended without a report, so the figures lack their requests; run it again"
    );
    (lost > 0).then(|| Error::new(ErrorKind::Failed, "clients", message))
}

fn targets(connection: &Client, args: &LoadArgs) -> Result<Vec<LoadTarget>, CliError> {
    if let Some(file) = &args.mix {
        return Ok(plan::mix(file)?);
    }
    let target = |object: String| LoadTarget { object, weight: 1.0, degree: args.degree.unwrap_or(DEGREE) };
    if !args.objects.is_empty() {
        return Ok(args.objects.iter().cloned().map(target).collect());
    }
    let ready = connection.objects(reply())?.into_iter().filter(|facts| facts.is_ready());
    let all: Vec<LoadTarget> = ready.map(|facts| target(facts.name)).collect();
    if all.is_empty() {
        return Err(Error::new(ErrorKind::UnknownObject, "", "the service has no object to strike").into());
    }
    Ok(all)
}

/// Runs one load; returns the records of all clients.
fn one(
    service: &str,
    args: &LoadArgs,
    targets: &[LoadTarget],
    rate: Option<f64>,
) -> Result<Vec<Option<Vec<RequestRecord>>>, CliError> {
    let begin = SystemTime::now() + HEAD_START;
    let plan = |client: u16| ClientPlan {
        targets: targets.to_vec(),
        rate: rate.map(|rate| rate / f64::from(args.clients)),
        seconds: args.seconds,
        deadline_ms: args.deadline_ms,
        seed: args.seed.wrapping_add(u64::from(client) << 32),
        begin_unix_ns: begin.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64),
    };
    let children = (0..args.clients).map(|client| start(service, &plan(client))).collect::<Result<Vec<_>, _>>()?;
    let late = Instant::now() + HEAD_START + Duration::from_secs_f64(args.seconds) + worker::TIMEOUT + MARGIN;
    let records = children.into_iter().map(|child| finish(child, late)).collect::<Result<Vec<_>, _>>()?;
    match records.iter().all(Option::is_none) {
        true => Err(failed("clients", "no client process reported its requests")),
        false => Ok(records),
    }
}

fn failed(at: &str, error: impl std::fmt::Display) -> CliError {
    Error::new(ErrorKind::Failed, at, format!("a client process: {error}")).into()
}

fn start(service: &str, plan: &ClientPlan) -> Result<Child, CliError> {
    let program = std::env::current_exe().map_err(|error| failed("program", error))?;
    let mut command = Command::new(program);
    command.args(["load-client", "--service", service]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().map_err(|error| failed("start", error))?;
    let text = serde_json::to_vec(plan).map_err(|error| failed("plan", error))?;
    if let Some(mut input) = child.stdin.take() {
        input.write_all(&text).map_err(|error| failed("plan", error))?;
    }
    Ok(child)
}

/// Report of a client process; `None`: it was killed, or does not end.
fn finish(mut child: Child, late: Instant) -> Result<Option<Vec<RequestRecord>>, CliError> {
    let output = child.stdout.take();
    let (sender, report) = std::sync::mpsc::channel();
    let read = move || {
        let mut text = Vec::new();
        let read = output.map(|mut output| output.read_to_end(&mut text));
        // After the time limit there is no receiver.
        let _ = sender.send(read.map(|read| read.map(|_| text)));
    };
    if let Err(error) = std::thread::Builder::new().spawn(read) {
        child.kill().map_err(|error| failed("end", error))?;
        child.wait().map_err(|error| failed("end", error))?;
        return Err(shatter_server::jobs::no_thread(&error).into());
    }
    let report = report.recv_timeout(late.saturating_duration_since(Instant::now()));
    if report.is_err() {
        child.kill().map_err(|error| failed("end", error))?;
    }
    child.wait().map_err(|error| failed("end", error))?;
    let Ok(Some(Ok(text))) = report else { return Ok(None) };
    match serde_json::from_slice(&text) {
        Ok(plan::ClientReport::Records(records)) => Ok(Some(records)),
        Ok(plan::ClientReport::Refused { kind, at, message }) => {
            let kind = ErrorKind::ALL.iter().copied().find(|known| known.name() == kind).unwrap_or(ErrorKind::Failed);
            Err(Error::new(kind, at, message).into())
        }
        Err(error) => {
            tracing::warn!(%error, "a client process was lost");
            Ok(None)
        }
    }
}

type Run = (Option<f64>, LoadTally, Vec<Option<Vec<RequestRecord>>>);

fn write(folder: &Path, report: &Value, runs: &[Run]) -> Result<(), CliError> {
    let refuse = |error: std::io::Error| {
        let at = folder.display().to_string();
        Error::new(ErrorKind::Output, at.clone(), format!("cannot write to {at}: {error}"))
    };
    let made = make_folder(folder);
    made.map_err(|error| Error::new(ErrorKind::Output, folder.display().to_string(), format!("{error} (--out)")))?;
    let put = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(refuse)?;
        note(format_args!("wrote {} ({})", path.display(), size(text.len() as u64)));
        Ok::<(), Error>(())
    };
    put("load.json", &format!("{report:#}\n"))?;
    let rates: Vec<(f64, &LoadTally)> = runs.iter().filter_map(|(rate, tally, _)| Some(((*rate)?, tally))).collect();
    match picture::svg(&rates) {
        Some(Ok(text)) => put("load.svg", &text)?,
        Some(Err(why)) => return Err(failed("picture", why)),
        None => {}
    }
    let mut text = "rate_hz,client,due_us,latency_us,service_us,ipc_us,end\n".to_owned();
    for (rate, _, clients) in runs {
        let rate = rate.map_or("closed".to_owned(), |rate| rate.to_string());
        for (client, records) in clients.iter().enumerate() {
            records.iter().flatten().for_each(|record| text.push_str(&format!("{rate},{client},{}\n", record.csv())));
        }
    }
    Ok(put("load.csv", &text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_run_without_results_reports_the_most_frequent_error() {
        let record = |end, why| RequestRecord { due_us: 0, latency_us: 1, service_us: 0, ipc_us: 0, end, why };
        let gone = record(RequestEnd::Failed, Some(ErrorKind::NoDaemon.code()));
        let busy = record(RequestEnd::Busy, None);
        assert_eq!(all_failed([gone, busy, gone].iter()).unwrap().kind, ErrorKind::NoDaemon);
        assert_eq!(all_failed([busy].iter()).unwrap().kind, ErrorKind::Busy);
        assert!(all_failed([gone, record(RequestEnd::Ok, None)].iter()).is_none());
        assert!(all_failed([].iter()).is_none());
    }

    #[test]
    fn lost_client_processes_are_counted_over_all_runs() {
        let (report, gone) = (Some(Vec::new()), None);
        assert_eq!(lost([&[report.clone(), report.clone()][..]].into_iter()), None);
        let error = lost([&[report.clone(), gone.clone()][..], &[report, gone][..]].into_iter()).unwrap();
        assert!(error.message.starts_with("2 of 4 client processes"), "{error}");
        assert_eq!(error.kind.exit_code(), 6);
    }
}
