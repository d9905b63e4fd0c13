//! One request through the client, and the parts of its result that the page shows.

use super::object::{DemoTarget, RADIUS_M};
use super::{DemoError, RESULT_TIMEOUT, views};
use crate::report::{StageTime, significant};
use nalgebra::Vector3;
use shatter_client::{Contact, Deadline, FractureResult, Fragment, Impact, Object, StageCost, Summary};
use shatter_export::WriteReport;
use shatter_proto::text::counted;
use shatter_server::commands::interrupt;
use std::path::Path;

/// Seed of all random choices.
const SEED: u64 = 1;

/// Number of times that the same request is sent; the last result counts.
///
/// The first one allocates memory, and the daemon still measures costs when it begins to serve.
pub(super) const REPEATS: usize = 5;

/// Impulse of the threshold request, N·s; the result scales it.
const PROBE_NS: f64 = 1.0;

/// Data of a result that is kept after the result is released to the daemon.
pub(super) struct DemoImpact {
    /// Number of the request, from 1.
    pub number: usize,
    /// Impulse over the one that just breaks the object.
    pub factor: f64,
    /// Impulse, N·s.
    pub impulse_ns: Vector3<f64>,
    /// Summary of the result.
    pub summary: Summary,
    /// Name of the file with the fragments.
    pub file: String,
    /// Contents of that file.
    pub written: WriteReport,
    /// Sum of the fragments' volumes, m³.
    pub volume_m3: f64,
    /// Mass of the lightest and of the heaviest fragment, kg.
    pub masses_kg: [f64; 2],
    /// Number of fragments that an independent check finds closed.
    pub closed: usize,
    /// Times of the stages.
    pub stages: Vec<StageTime>,
    /// Time from sending the request to finding the result, ns.
    pub round_trip_ns: u64,
    /// Size of the result, bytes.
    pub bytes: u64,
    /// Picture of the fragments, moved apart; PNG.
    pub picture: Vec<u8>,
}

/// Impulse along the target's direction that just breaks the object, N·s.
pub(super) fn threshold_ns(object: &Object, target: &DemoTarget) -> Result<f64, DemoError> {
    let probe = impact(target, target.direction * PROBE_NS).threshold_only();
    let result = object.strike(&probe)?.wait(Deadline::after(RESULT_TIMEOUT))?;
    Ok(PROBE_NS * result.summary().threshold_impulse_factor)
}

fn impact(target: &DemoTarget, impulse_ns: Vector3<f64>) -> Impact {
    Impact::new([Contact::new(target.point_m.coords.into()).impulse(impulse_ns.into()).radius(RADIUS_M)]).seed(SEED)
}

impl DemoImpact {
    /// Sends the request, writes the fragments into `folder`, and draws them.
    pub fn strike(
        object: &Object,
        target: &DemoTarget,
        threshold_ns: f64,
        factor: f64,
        folder: &Path,
        number: usize,
    ) -> Result<Self, DemoError> {
        let impulse_ns = target.direction * (threshold_ns * factor);
        let request = impact(target, impulse_ns);
        let strike = || object.strike(&request)?.wait(Deadline::after(RESULT_TIMEOUT));
        for _ in 1..REPEATS {
            drop(strike()?);
        }
        let result = strike()?;
        if result.is_whole() {
            return Err(DemoError::StayedWhole { factor });
        }
        let file = format!("strike-{number}.glb");
        let writing = interrupt::writing();
        let written = result.write_glb(&folder.join(&file))?;
        drop(writing);
        let masses = || result.fragments().map(|fragment| fragment.mass_kg());
        Ok(Self {
            number,
            factor,
            impulse_ns,
            summary: result.summary(),
            file,
            written,
            volume_m3: result.fragments().map(|fragment| fragment.volume_m3()).sum(),
            masses_kg: [masses().fold(f64::INFINITY, f64::min), masses().fold(0.0, f64::max)],
            closed: result.fragments().filter(Fragment::is_closed).count(),
            stages: stages(&result),
            round_trip_ns: u64::try_from(result.round_trip().as_nanos()).unwrap_or(u64::MAX),
            bytes: result.bytes(),
            picture: result.with_views(|fragments| views::fragments_figure(fragments, target))?,
        })
    }

    /// Line for people.
    pub fn line(&self) -> String {
        format!(
            "{}  {} at {} times the impulse that just breaks the mug ({} N·s)",
            self.file,
            counted(self.written.fragments as u64, "fragment"),
            self.factor,
            significant(self.impulse_ns.norm(), 3)
        )
    }
}

fn stages(result: &FractureResult) -> Vec<StageTime> {
    let time = |cost: StageCost| StageTime {
        name: cost.stage.name().to_owned(),
        ns: cost.has_run.then(|| u64::try_from(cost.time.as_nanos()).unwrap_or(u64::MAX)),
    };
    result.stages().map(time).collect()
}
