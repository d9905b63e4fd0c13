//! Metrics of the service: counters and times, as OpenMetrics text and as one row for `status`.

use hdrhistogram::Histogram as Times;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::{Registry, Unit};
use shatter_engine::object::ResultEnergies;
use shatter_proto::control::{Latency, ServiceStatusRow};
use shatter_proto::result::{EffectCost, StageCost, StageKind};
use shatter_proto::{Error, ErrorKind, FaultParty};
use std::sync::atomic::AtomicU64;
use std::time::Duration;

/// End of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobEnd {
    /// With a result.
    Completed,
    /// Refused by validation.
    Refused,
    /// Refused for lack of capacity.
    Busy,
    /// Its deadline passed, or would have passed.
    Late,
    /// Failed inside the service.
    Failed,
    /// Dropped by its client.
    Canceled,
}

impl JobEnd {
    const ALL: [Self; 6] = [Self::Completed, Self::Refused, Self::Busy, Self::Late, Self::Failed, Self::Canceled];

    /// End that corresponds to an error.
    pub fn of(error: &Error) -> Self {
        match (error.kind, error.kind.fault()) {
            (ErrorKind::Canceled, _) => Self::Canceled,
            (ErrorKind::Late, _) => Self::Late,
            (ErrorKind::Busy | ErrorKind::Stopping | ErrorKind::SharedMemory, _) => Self::Busy,
            (_, FaultParty::Service) => Self::Failed,
            _ => Self::Refused,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Refused => "refused",
            Self::Busy => "busy",
            Self::Late => "late",
            Self::Failed => "failed",
            Self::Canceled => "canceled",
        }
    }
}

type Label = [(&'static str, &'static str); 1];

/// Histograms by name.
type SpanTimes = Family<Label, Histogram, fn() -> Histogram>;

/// Reader of a gauge from a status row.
type GaugeReading = fn(&ServiceStatusRow) -> u64;

/// Gauges: name, description, unit, reader.
const GAUGES: &[(&str, &str, Option<Unit>, GaugeReading)] = &[
    ("running", "Requests computing", None, |row| row.running.into()),
    ("queued", "Requests waiting", None, |row| row.queued.into()),
    ("queue_max", "Maximum number of waiting requests", None, |row| row.queue_max.into()),
    ("clients", "Connected clients", None, |row| row.clients.into()),
    ("clients_max", "Maximum number of connected clients", None, |row| row.clients_max.into()),
    ("objects", "Objects ready", None, |row| row.objects_ready.into()),
    ("objects_loading", "Objects whose databases are being loaded", None, |row| row.objects_loading.into()),
    ("objects_failed", "Objects that could not be loaded", None, |row| row.objects_failed.into()),
    ("objects", "Memory of the objects", Some(Unit::Bytes), |row| row.memory_bytes),
    ("results_retained", "Results retained so that their fragments can be struck", None, |row| row.kept),
    ("results_retained", "Memory of the retained results", Some(Unit::Bytes), |row| row.kept_bytes),
    ("reloads", "Reloads of the databases", None, |row| row.reloads),
    ("pool_buckets", "Buckets for results", None, |row| row.buckets.into()),
    ("pool_buckets_unread", "Results that their clients have not read yet", None, |row| row.unread),
    ("pool_buckets_used_max", "Maximum number of buckets held or prepared at once", None, |row| row.buckets_used_max),
    ("pool", "Shared memory of the buckets", Some(Unit::Bytes), |row| row.buckets_bytes),
    ("restarts", "Daemons that served under this name before this one", None, |row| row.restarts),
    ("crashes", "Of these, those that crashed or were killed", None, |row| row.crashes),
    ("ending", "1 while the daemon is ending", None, |row| row.ending.into()),
    ("uptime", "Time since the daemon started", Some(Unit::Seconds), |row| row.uptime_ns / 1_000_000_000),
];

/// Counters and times since the daemon started.
pub struct Metrics {
    registry: Registry,
    ends: Family<Label, Counter>,
    energies: Family<Label, Counter>,
    energy_joules: Family<Label, Counter<f64, AtomicU64>>,
    stage_seconds: SpanTimes,
    effect_seconds: SpanTimes,
    strike_seconds: Histogram,
    gauges: Vec<(Gauge, GaugeReading)>,
    strike_times: Times<u64>,
    stage_times: Vec<Times<u64>>,
}

/// Histogram from 10 µs to 40 s.
fn seconds() -> Histogram {
    Histogram::new(exponential_buckets(1e-5, 2.0, 23))
}

/// Recorder of times up to ten minutes, with two significant digits.
fn times() -> Result<Times<u64>, Error> {
    Times::new_with_max(600_000_000_000, 2).map_err(|error| Error::new(ErrorKind::Failed, "metrics", error.to_string()))
}

impl Metrics {
    /// Creates metrics that are all zero.
    ///
    /// # Errors
    /// `failed` if a histogram cannot be made.
    pub fn new() -> Result<Self, Error> {
        let metrics = Self {
            registry: Registry::with_prefix("shatter"),
            ends: Family::default(),
            energies: Family::default(),
            energy_joules: Family::default(),
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
        registry.register("requests", "Requests by their end", self.ends.clone());
        let help = "Results by source of their energy; bounded: the object stays whole, and no solve was needed";
        registry.register("energies", help, self.energies.clone());
        let help = "Energies of results: of the impactors, strain, new surface, release, and deficit; bounded results have no strain energy";
        registry.register_with_unit("energy", help, Unit::Joules, self.energy_joules.clone());
        let stages = self.stage_seconds.clone();
        registry.register_with_unit("stage", "Time per stage that ran", Unit::Seconds, stages);
        let effects = self.effect_seconds.clone();
        registry.register_with_unit("effect", "Time per effect that ran outside the stages", Unit::Seconds, effects);
        let strikes = self.strike_seconds.clone();
        registry.register_with_unit("strike", "Time from arrival to result", Unit::Seconds, strikes);
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

    /// Counts a request that ended before it began to compute.
    pub fn ended(&self, end: JobEnd) {
        self.ends.get_or_create(&[("end", end.name())]).inc();
    }

    /// Counts a request that computed, with the energies of its result. A result without energies is a hit of a ray: it is counted, but
    /// not timed.
    pub fn ran(
        &mut self,
        end: JobEnd,
        time: Duration,
        energies: Option<ResultEnergies>,
        stages: &[StageCost],
        effects: &[EffectCost],
    ) {
        self.ended(end);
        if end != JobEnd::Completed {
            return;
        }
        if let Some(ResultEnergies { source, impactor_j, strain_j, surface_j, released_j, deficit_j, .. }) = energies {
            self.energies.get_or_create(&[("source", source.name())]).inc();
            let parts = [impactor_j, strain_j, surface_j, released_j, deficit_j];
            for (part, energy_j) in ["impactor", "strain", "surface", "released", "deficit"].into_iter().zip(parts) {
                self.energy_joules.get_or_create(&[("part", part)]).inc_by(energy_j);
            }
            self.strike_seconds.observe(time.as_secs_f64());
            self.strike_times.saturating_record(nanoseconds(time));
        }
        for (stage, times) in stages.iter().zip(&mut self.stage_times) {
            if stage.has_run {
                let labels = [("stage", stage.stage.name())];
                self.stage_seconds.get_or_create(&labels).observe(stage.time.as_secs_f64());
                times.saturating_record(nanoseconds(stage.time));
            }
        }
        // The time of an effect inside a stage is part of the stage's time.
        for effect in effects.iter().filter(|cost| cost.has_run && !cost.time.is_zero()) {
            let labels = [("effect", effect.effect.name())];
            self.effect_seconds.get_or_create(&labels).observe(effect.time.as_secs_f64());
        }
    }

    /// OpenMetrics text; gauges are read from `now`.
    pub fn text(&self, now: &ServiceStatusRow) -> String {
        for (gauge, reading) in &self.gauges {
            gauge.set(i64::try_from(reading(now)).unwrap_or(i64::MAX));
        }
        let mut text = String::new();
        // Writing to a string fails only if a metric cannot be formatted; the text before it is still valid.
        if let Err(error) = encode(&mut text, &self.registry) {
            tracing::warn!(%error, "cannot write a metric");
        }
        text
    }

    /// Fills the counters and times of a status row.
    pub fn fill(&self, row: &mut ServiceStatusRow) {
        let [completed, refused, busy, late, failed, canceled] =
            JobEnd::ALL.map(|end| self.ends.get_or_create(&[("end", end.name())]).get());
        (row.completed, row.refused, row.busy, row.late) = (completed, refused, busy, late);
        (row.failed, row.canceled) = (failed, canceled);
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
    use shatter_proto::result::EnergySource;

    #[test]
    fn strikes_are_counted_and_timed() {
        let mut metrics = Metrics::new().unwrap();
        let (idle, mut stage) = (StageCost::idle(StageKind::Load), StageCost::idle(StageKind::Elasticity));
        stage.add(Duration::from_millis(5), 0);
        let energies = ResultEnergies {
            source: EnergySource::Solve,
            impactor_j: 2.0,
            strain_j: 1.5,
            surface_j: 0.25,
            released_j: 0.125,
            deficit_j: 0.0,
            stress_over_strength: 3.0,
        };
        let mut bonds = EffectCost::idle(Effect::Bonds);
        bonds.add(Duration::from_micros(70), 64);
        metrics.ran(JobEnd::Completed, Duration::from_millis(20), Some(energies), &[idle, stage], &[bonds]);
        metrics.ran(JobEnd::Failed, Duration::from_millis(20), None, &[idle, stage], &[bonds]);
        metrics.ran(JobEnd::Completed, Duration::from_millis(1), None, &[idle, idle], &[]);
        metrics.ended(JobEnd::Busy);
        let mut row = ServiceStatusRow::zeroed();
        metrics.fill(&mut row);
        assert_eq!((row.completed, row.failed, row.busy, row.refused), (2, 1, 1, 0));
        assert_eq!((row.strike.count, row.stages[0].count, row.stages[1].count), (1, 0, 1));
        assert!((4_900_000..5_200_000).contains(&row.stages[1].p99_ns), "{row:?}");
        let text = metrics.text(&row);
        for line in [
            "shatter_requests_total{end=\"busy\"} 1",
            "shatter_energies_total{source=\"solve\"} 1",
            "shatter_energy_joules_total{part=\"strain\"} 1.5",
            "shatter_energy_joules_total{part=\"released\"} 0.125",
            "shatter_strike_seconds_count 1",
            "shatter_stage_seconds_count{stage=\"elasticity\"} 1",
            "shatter_effect_seconds_count{effect=\"bonds\"} 1",
        ] {
            assert!(text.contains(line), "{text}");
        }
    }

    #[test]
    fn every_error_kind_has_a_request_outcome() {
        let end = |kind| JobEnd::of(&Error::new(kind, "", ""));
        assert_eq!(end(ErrorKind::Impulse), JobEnd::Refused);
        assert_eq!(end(ErrorKind::CorruptObject), JobEnd::Refused);
        assert_eq!(end(ErrorKind::Busy), JobEnd::Busy);
        assert_eq!(end(ErrorKind::Late), JobEnd::Late);
        assert_eq!(end(ErrorKind::Failed), JobEnd::Failed);
        assert_eq!(end(ErrorKind::Canceled), JobEnd::Canceled);
    }
}
