//! How the service goes: counters and times, as Prometheus text and as one row for `status`.

use hdrhistogram::Histogram as Times;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Registry, Unit};
use shatter_proto::control::{Latency, StatusRow};
use shatter_proto::result::{EffectCost, EnergySource, StageCost, StageKind};
use shatter_proto::{Error, ErrorKind, Fault};
use std::time::Duration;

/// How a strike ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobEnd {
    /// With an answer.
    Answered,
    /// With a refusal of the request.
    Refused,
    /// For want of room.
    Busy,
    /// Its deadline passed, or would have.
    Late,
    /// Inside the service.
    Failed,
    /// Nobody waited for it any more.
    Cancelled,
}

impl JobEnd {
    const ALL: [Self; 6] = [Self::Answered, Self::Refused, Self::Busy, Self::Late, Self::Failed, Self::Cancelled];

    /// The end that a refusal is.
    pub fn of(refusal: &Error) -> Self {
        match (refusal.kind, refusal.kind.fault()) {
            (ErrorKind::Cancelled, _) => Self::Cancelled,
            (ErrorKind::Late, _) => Self::Late,
            (ErrorKind::Busy | ErrorKind::Stopping | ErrorKind::SharedMemory, _) => Self::Busy,
            (_, Fault::Service) => Self::Failed,
            _ => Self::Refused,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Answered => "answered",
            Self::Refused => "refused",
            Self::Busy => "busy",
            Self::Late => "late",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }
}

type Label = [(&'static str, &'static str); 1];

/// Times by name.
type SpanTimes = Family<Label, Histogram, fn() -> Histogram>;

/// What a gauge shows of a status row.
type GaugeReading = fn(&StatusRow) -> u64;

/// What goes on now: name, meaning, unit, where it is read.
const GAUGES: &[(&str, &str, Option<Unit>, GaugeReading)] = &[
    ("running", "Strikes computing", None, |row| row.running.into()),
    ("queued", "Strikes waiting", None, |row| row.queued.into()),
    ("queue_max", "Strikes that may wait", None, |row| row.queue_max.into()),
    ("clients", "Clients connected", None, |row| row.clients.into()),
    ("clients_max", "Clients that may be connected", None, |row| row.clients_max.into()),
    ("objects", "Objects ready", None, |row| row.objects_ready.into()),
    ("objects_loading", "Objects whose databases are being loaded", None, |row| row.objects_loading.into()),
    ("objects_failed", "Objects that could not be loaded", None, |row| row.objects_failed.into()),
    ("objects", "Memory of the objects", Some(Unit::Bytes), |row| row.memory_bytes),
    ("answers_kept", "Answers kept so that their fragments can be struck", None, |row| row.kept),
    ("answers_kept", "Memory of the answers that are kept", Some(Unit::Bytes), |row| row.kept_bytes),
    ("reloads", "Times the databases were read again", None, |row| row.reloads),
    ("pool_buckets", "Buckets for answers", None, |row| row.buckets.into()),
    ("pool_buckets_unread", "Answers that their clients have not read yet", None, |row| row.unread),
    ("pool_buckets_used_max", "Most buckets that were held at once", None, |row| row.buckets_used_max),
    ("pool", "Shared memory that the buckets take up", Some(Unit::Bytes), |row| row.buckets_bytes),
    ("restarts", "Daemons that served under this name before this one", None, |row| row.restarts),
    ("crashes", "Of these, those that ended without a goodbye", None, |row| row.crashes),
    ("ending", "1 while the daemon is ending", None, |row| row.ending.into()),
    ("uptime", "Time since the daemon started", Some(Unit::Seconds), |row| row.uptime_ns / 1_000_000_000),
];

/// Counters and times since the daemon started.
pub struct Metrics {
    registry: Registry,
    ends: Family<Label, Counter>,
    energies: Family<Label, Counter>,
    stage_seconds: SpanTimes,
    effect_seconds: SpanTimes,
    strike_seconds: Histogram,
    gauges: Vec<(Gauge, GaugeReading)>,
    strike_times: Times<u64>,
    stage_times: Vec<Times<u64>>,
}

/// 10 µs to 40 s.
fn seconds() -> Histogram {
    Histogram::new(exponential_buckets(1e-5, 2.0, 23))
}

/// Up to ten minutes, to two digits.
fn times() -> Result<Times<u64>, Error> {
    Times::new_with_max(600_000_000_000, 2).map_err(|error| Error::new(ErrorKind::Failed, "metrics", error.to_string()))
}

impl Metrics {
    /// All zero.
    ///
    /// # Errors
    /// `failed` if a histogram cannot be made.
    pub fn new() -> Result<Self, Error> {
        let metrics = Self {
            registry: Registry::with_prefix("shatter"),
            ends: Family::default(),
            energies: Family::default(),
            stage_seconds: Family::new_with_constructor(seconds),
            effect_seconds: Family::new_with_constructor(seconds),
            strike_seconds: seconds(),
            gauges: Vec::new(),
            strike_times: times()?,
            stage_times: StageKind::ALL.iter().map(|_| times()).collect::<Result<_, _>>()?,
        };
        Ok(metrics.registered())
    }

    fn registered(mut self) -> Self {
        let registry = &mut self.registry;
        registry.register("strikes", "Strikes by how they ended", self.ends.clone());
        let help = "Answers by where their energy came from; bounded: the object stays whole, and nothing had to be solved for";
        registry.register("energies", help, self.energies.clone());
        let stages = self.stage_seconds.clone();
        registry.register_with_unit("stage", "Time per stage that ran", Unit::Seconds, stages);
        let effects = self.effect_seconds.clone();
        registry.register_with_unit("effect", "Time per effect that ran beside the stages", Unit::Seconds, effects);
        let strikes = self.strike_seconds.clone();
        registry.register_with_unit("strike", "Time from arrival to answer", Unit::Seconds, strikes);
        for (name, help, unit, reading) in GAUGES {
            let gauge = Gauge::default();
            match unit {
                Some(unit) => registry.register_with_unit(*name, *help, unit.clone(), gauge.clone()),
                None => registry.register(*name, *help, gauge.clone()),
            }
            self.gauges.push((gauge, *reading));
        }
        self
    }

    /// Counts a strike that ended before it began.
    pub fn ended(&self, end: JobEnd) {
        self.ends.get_or_create(&[("end", end.name())]).inc();
    }

    /// Counts a strike that ran; `energy` names where its answer's energy came from.
    pub fn ran(
        &mut self,
        end: JobEnd,
        time: Duration,
        energy: Option<EnergySource>,
        stages: &[StageCost],
        effects: &[EffectCost],
    ) {
        self.ended(end);
        if end != JobEnd::Answered {
            return;
        }
        if let Some(source) = energy {
            self.energies.get_or_create(&[("source", source.name())]).inc();
        }
        self.strike_seconds.observe(time.as_secs_f64());
        self.strike_times.saturating_record(nanoseconds(time));
        for (stage, times) in stages.iter().zip(&mut self.stage_times) {
            if stage.has_run {
                let labels = [("stage", stage.stage.name())];
                self.stage_seconds.get_or_create(&labels).observe(stage.time.as_secs_f64());
                times.saturating_record(nanoseconds(stage.time));
            }
        }
        // What an effect takes as part of a stage is counted there.
        for effect in effects.iter().filter(|cost| cost.has_run && !cost.time.is_zero()) {
            let labels = [("effect", effect.effect.name())];
            self.effect_seconds.get_or_create(&labels).observe(effect.time.as_secs_f64());
        }
    }

    /// Prometheus text; what goes on now is taken from `now`.
    pub fn text(&self, now: &StatusRow) -> String {
        for (gauge, reading) in &self.gauges {
            gauge.set(i64::try_from(reading(now)).unwrap_or(i64::MAX));
        }
        let mut text = String::new();
        // Writing to a string fails only if a metric cannot be shown; what was written by then is still good.
        if let Err(error) = encode(&mut text, &self.registry) {
            tracing::warn!(%error, "metrics");
        }
        text
    }

    /// Fills the counters and times of a status row.
    pub fn fill(&self, row: &mut StatusRow) {
        let [answered, refused, busy, late, failed, cancelled] =
            JobEnd::ALL.map(|end| self.ends.get_or_create(&[("end", end.name())]).get());
        (row.answered, row.refused, row.busy, row.late) = (answered, refused, busy, late);
        (row.failed, row.cancelled) = (failed, cancelled);
        row.strike = latency(&self.strike_times);
        for (slot, times) in row.stages.iter_mut().zip(&self.stage_times) {
            *slot = latency(times);
        }
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

fn latency(times: &Times<u64>) -> Latency {
    Latency {
        count: times.len(),
        p50_ns: times.value_at_quantile(0.5),
        p90_ns: times.value_at_quantile(0.9),
        p99_ns: times.value_at_quantile(0.99),
        max_ns: times.max(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use shatter_proto::effect::Effect;

    #[test]
    fn strikes_are_counted_and_timed() {
        let mut metrics = Metrics::new().unwrap();
        let (idle, mut stage) = (StageCost::idle(StageKind::Load), StageCost::idle(StageKind::Elasticity));
        stage.add(Duration::from_millis(5), 0);
        let mut bonds = EffectCost::idle(Effect::Bonds);
        bonds.add(Duration::from_micros(70), 64);
        metrics.ran(JobEnd::Answered, Duration::from_millis(20), Some(EnergySource::Bounded), &[idle, stage], &[bonds]);
        metrics.ran(JobEnd::Failed, Duration::from_millis(20), None, &[idle, stage], &[bonds]);
        metrics.ended(JobEnd::Busy);
        let mut row = StatusRow::zeroed();
        metrics.fill(&mut row);
        assert_eq!((row.answered, row.failed, row.busy, row.refused), (1, 1, 1, 0));
        assert_eq!((row.strike.count, row.stages[0].count, row.stages[1].count), (1, 0, 1));
        assert!((4_900_000..5_200_000).contains(&row.stages[1].p99_ns), "{row:?}");
        let text = metrics.text(&row);
        for line in [
            "shatter_strikes_total{end=\"busy\"} 1",
            "shatter_energies_total{source=\"bounded\"} 1",
            "shatter_stage_seconds_count{stage=\"elasticity\"} 1",
            "shatter_effect_seconds_count{effect=\"bonds\"} 1",
        ] {
            assert!(text.contains(line), "{text}");
        }
    }

    #[test]
    fn every_refusal_has_an_end() {
        let end = |kind| JobEnd::of(&Error::new(kind, "", ""));
        assert_eq!(end(ErrorKind::Impulse), JobEnd::Refused);
        assert_eq!(end(ErrorKind::CorruptObject), JobEnd::Refused);
        assert_eq!(end(ErrorKind::Busy), JobEnd::Busy);
        assert_eq!(end(ErrorKind::Late), JobEnd::Late);
        assert_eq!(end(ErrorKind::Failed), JobEnd::Failed);
        assert_eq!(end(ErrorKind::Cancelled), JobEnd::Cancelled);
    }
}
