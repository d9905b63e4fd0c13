//! Records and statistics of requests.

use super::ideal;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use shatter_client::ErrorKind;
use std::collections::BTreeMap;

/// End of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RequestEnd {
    /// With a result.
    Ok,
    /// Refused for lack of capacity.
    Busy,
    /// Late.
    Late,
    /// With another error.
    Failed,
}

/// Record of one request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RequestRecord {
    /// Due time from the start of the run, µs.
    pub due_us: u64,
    /// Latency: from the due time to the end, µs.
    pub latency_us: u64,
    /// Sum of its stages, µs.
    pub service_us: u64,
    /// Round trip from sending minus its stages, µs.
    pub ipc_us: u64,
    /// End of the request.
    pub end: RequestEnd,
    /// Code of the error kind, if it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<u32>,
}

impl RequestRecord {
    /// Line of the CSV file.
    pub fn csv(&self) -> String {
        let Self { due_us, latency_us, service_us, ipc_us, end, .. } = self;
        let end = format!("{end:?}").to_lowercase();
        format!("{due_us},{latency_us},{service_us},{ipc_us},{end}")
    }
}

/// Statistics of one run.
pub struct LoadTally {
    sent: usize,
    counts: [usize; 4],
    /// Failed requests by error kind.
    failures: BTreeMap<&'static str, usize>,
    clients_lost: usize,
    throughput_hz: f64,
    latency: Times,
    refused: Times,
    ipc_p50: u64,
    ideal_p99: u64,
    per_client: Vec<usize>,
}

/// Order statistics of times, µs: a share q is the lowest time that at least the share q of all times do not exceed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Times {
    p50: u64,
    p90: u64,
    p99: u64,
    max: u64,
}

impl Times {
    fn of(values: impl Iterator<Item = u64>) -> Self {
        let mut sorted: Vec<u64> = values.collect();
        sorted.sort_unstable();
        let at = |percent: usize| sorted.get((sorted.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        let [p50, p90, p99, max] = [50, 90, 99, 100].map(|percent| at(percent).unwrap_or_default());
        Self { p50, p90, p99, max }
    }
}

impl LoadTally {
    /// Header of a table of [`Self::line`]s.
    pub const HEAD: &str =
        "   rate/s    sent      ok    busy    late  failed    ok/s   p50 ms   p90 ms   p99 ms   max ms  ideal p99";

    /// Statistics of a run from the records of all clients (`None` for a lost one); `servers` is the size of the ideal queue.
    pub fn of(clients: &[Option<Vec<RequestRecord>>], servers: usize, seconds: f64) -> Self {
        let all = || clients.iter().flatten().flatten();
        let ended = |end: RequestEnd| all().filter(move |record| record.end == end);
        let counts =
            [RequestEnd::Ok, RequestEnd::Busy, RequestEnd::Late, RequestEnd::Failed].map(|end| ended(end).count());
        let served: Vec<(u64, u64)> = ended(RequestEnd::Ok).map(|record| (record.due_us, record.service_us)).collect();
        // A run lasts until its last result.
        let last =
            ended(RequestEnd::Ok).map(|record| record.due_us + record.latency_us).max().unwrap_or(0) as f64 * 1e-6;
        let refused_records = all().filter(|record| matches!(record.end, RequestEnd::Busy | RequestEnd::Late));
        let mut failures = BTreeMap::new();
        for code in all().filter_map(|record| record.why) {
            *failures.entry(ErrorKind::from_code(code).unwrap_or(ErrorKind::Failed).name()).or_default() += 1;
        }
        Self {
            sent: all().count(),
            counts,
            failures,
            clients_lost: clients.iter().filter(|client| client.is_none()).count(),
            throughput_hz: counts[0] as f64 / last.max(seconds),
            latency: Times::of(ended(RequestEnd::Ok).map(|record| record.latency_us)),
            refused: Times::of(refused_records.map(|record| record.latency_us)),
            ipc_p50: Times::of(ended(RequestEnd::Ok).map(|record| record.ipc_us)).p50,
            ideal_p99: Times::of(ideal::sojourns(served, servers).into_iter()).p99,
            per_client: clients
                .iter()
                .map(|records| records.iter().flatten().filter(|record| record.end == RequestEnd::Ok).count())
                .collect(),
        }
    }

    /// Results per second.
    pub fn throughput_hz(&self) -> f64 {
        self.throughput_hz
    }

    /// Median and 99th percentile of the latency, ms.
    pub fn latency_ms(&self) -> (f64, f64) {
        (self.latency.p50 as f64 * 1e-3, self.latency.p99 as f64 * 1e-3)
    }

    /// 99th percentile of the latency in an ideal queue, ms.
    pub fn ideal_ms(&self) -> f64 {
        self.ideal_p99 as f64 * 1e-3
    }

    /// JSON document of `load --json`.
    pub fn document(&self, rate: Option<f64>) -> Value {
        let [ok, busy, late, failed] = self.counts;
        let Times { p50, p90, p99, max } = self.latency;
        let refused = self.refused;
        json!({
            "rate_hz": rate,
            "sent": self.sent,
            "ok": ok,
            "busy": busy,
            "late": late,
            "failed": failed,
            "failures": self.failures,
            "clients_lost": self.clients_lost,
            "throughput_hz": self.throughput_hz,
            "latency_us": { "p50": p50, "p90": p90, "p99": p99, "max": max },
            "refusal_us": { "p50": refused.p50, "p99": refused.p99, "max": refused.max },
            "ipc_share_us_p50": self.ipc_p50,
            "ideal_queue_p99_us": self.ideal_p99,
            "per_client_ok": self.per_client,
        })
    }

    /// Lines about failures, if there were any.
    pub fn complaints(&self) -> String {
        let mut text = String::new();
        if !self.failures.is_empty() {
            let kinds: Vec<String> = self.failures.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
            text = format!("          failed: {}\n", kinds.join(", "));
        }
        if self.clients_lost > 0 {
            text.push_str(&format!(
                "          {} client processes were lost, with their requests\n",
                self.clients_lost
            ));
        }
        text
    }

    /// Line of a table for people.
    pub fn line(&self, rate: Option<f64>) -> String {
        let rate = rate
            .map_or("closed".to_owned(), |rate| if rate < 1.0 { format!("{rate:.2e}") } else { format!("{rate:.1}") });
        let [ok, busy, late, failed] = self.counts;
        let ms = |us: u64| us as f64 * 1e-3;
        let Times { p50, p90, p99, max } = self.latency;
        format!(
            "{rate:>9} {:>7} {ok:>7} {busy:>7} {late:>7} {failed:>7} {:>7.1} {:>8.2} {:>8.2} {:>8.2} {:>8.2} {:>10.2}",
            self.sent,
            self.throughput_hz,
            ms(p50),
            ms(p90),
            ms(p99),
            ms(max),
            ms(self.ideal_p99)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_counted_by_outcome_and_client() {
        let why = |end| (end == RequestEnd::Failed).then_some(ErrorKind::Lost.code());
        let record =
            |due_us, end| RequestRecord { due_us, latency_us: 2000, service_us: 1500, ipc_us: 100, end, why: why(end) };
        let first = (0..100).map(|k| record(10_000 * k, RequestEnd::Ok)).collect();
        let second = vec![
            record(0, RequestEnd::Busy),
            record(5, RequestEnd::Late),
            record(9, RequestEnd::Failed),
            record(400, RequestEnd::Ok),
        ];
        let tally = LoadTally::of(&[Some(first), Some(second), None], 2, 1.0);
        let report = tally.document(Some(104.0));
        assert_eq!((&report["sent"], &report["ok"], &report["busy"]), (&104.into(), &101.into(), &1.into()));
        assert_eq!((&report["late"], &report["failed"]), (&1.into(), &1.into()));
        assert_eq!(report["per_client_ok"], json!([100, 1, 0]));
        assert_eq!((&report["failures"], &report["clients_lost"]), (&json!({ "lost": 1 }), &1.into()));
        assert_eq!(tally.complaints().lines().count(), 2);
        assert_eq!(report["throughput_hz"], 101.0);
        for (times, quantile) in [("latency_us", "p50"), ("latency_us", "max"), ("refusal_us", "p99")] {
            let found = report[times][quantile].as_f64().unwrap();
            assert!((found / 2000.0 - 1.0).abs() < 2e-3, "{times} {quantile}: {found}");
        }
        assert!((report["ideal_queue_p99_us"].as_f64().unwrap() / 1500.0 - 1.0).abs() < 2e-3);
        assert_eq!(
            tally.line(None).split_whitespace().count(),
            LoadTally::HEAD.split("  ").filter(|part| !part.is_empty()).count()
        );
    }
}
