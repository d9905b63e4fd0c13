//! One strike through the client, and what is kept of its answer.

use super::object::{DemoTarget, RADIUS_M};
use super::{ANSWER_PATIENCE, DemoError, views};
use crate::report::{StageTime, significant};
use nalgebra::Vector3;
use shatter_client::{Contact, Deadline, FractureResult, Fragment, Impact, Object, StageCost, Summary};
use shatter_export::WriteReport;
use shatter_server::commands::interrupt;
use std::path::Path;

/// Everything random follows from it.
const SEED: u64 = 1;

/// Times that the same strike is sent; the last answer counts. The first one allocates memory, and the daemon still measures what
/// strikes take when it begins to serve.
pub(super) const REPEATS: usize = 5;

/// Impulse with which the threshold is asked for, N·s; the answer scales it.
const PROBE_NS: f64 = 1.0;

/// What is kept of a strike once its answer is given back to the daemon.
pub(super) struct DemoStrike {
    /// 1, 2, 3.
    pub number: usize,
    /// Impulse over the one that just breaks the object.
    pub factor: f64,
    /// Impulse, N·s.
    pub impulse_ns: Vector3<f64>,
    /// The answer's own figures.
    pub summary: Summary,
    /// Name of the file with the fragments.
    pub file: String,
    /// What went into it.
    pub written: WriteReport,
    /// Sum of the fragments' volumes, m³.
    pub volume_m3: f64,
    /// Mass of the lightest and of the heaviest fragment, kg.
    pub masses_kg: [f64; 2],
    /// Fragments that an independent check of their triangles finds closed.
    pub closed: usize,
    /// Time per stage.
    pub stages: Vec<StageTime>,
    /// From sending the strike to finding the answer, ns.
    pub round_trip_ns: u64,
    /// Bytes of the answer.
    pub bytes: u64,
    /// The fragments moved apart, as PNG.
    pub picture: Vec<u8>,
}

/// The impulse along the target's direction that just breaks the object, N·s.
pub(super) fn threshold_ns(object: &Object, target: &DemoTarget) -> Result<f64, DemoError> {
    let probe = impact(target, target.direction * PROBE_NS).threshold_only();
    let answer = object.strike(&probe)?.wait(Deadline::after(ANSWER_PATIENCE))?;
    Ok(PROBE_NS * answer.summary().threshold_impulse_factor)
}

fn impact(target: &DemoTarget, impulse_ns: Vector3<f64>) -> Impact {
    Impact::new([Contact::new(target.point_m.coords.into()).impulse(impulse_ns.into()).radius(RADIUS_M)]).seed(SEED)
}

impl DemoStrike {
    /// Strikes, writes the fragments into `folder`, and draws them.
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
        let answer = || object.strike(&request)?.wait(Deadline::after(ANSWER_PATIENCE));
        for _ in 1..REPEATS {
            drop(answer()?);
        }
        let broken = answer()?;
        if broken.is_whole() {
            return Err(DemoError::StayedWhole { factor });
        }
        let file = format!("strike-{number}.glb");
        let writing = interrupt::writing();
        let written = broken.write_glb(&folder.join(&file))?;
        drop(writing);
        let masses = || broken.fragments().map(|fragment| fragment.mass_kg());
        Ok(Self {
            number,
            factor,
            impulse_ns,
            summary: broken.summary(),
            file,
            written,
            volume_m3: broken.fragments().map(|fragment| fragment.volume_m3()).sum(),
            masses_kg: [masses().fold(f64::INFINITY, f64::min), masses().fold(0.0, f64::max)],
            closed: broken.fragments().filter(Fragment::is_closed).count(),
            stages: stages(&broken),
            round_trip_ns: u64::try_from(broken.round_trip().as_nanos()).unwrap_or(u64::MAX),
            bytes: broken.bytes(),
            picture: broken.with_views(|fragments| views::broken(fragments, target))?,
        })
    }

    /// One line for people.
    pub fn line(&self) -> String {
        format!(
            "{}  {} fragments at {} times the impulse that just breaks the mug ({} N·s)",
            self.file,
            self.written.fragments,
            self.factor,
            significant(self.impulse_ns.norm(), 3)
        )
    }
}

fn stages(broken: &FractureResult) -> Vec<StageTime> {
    let time = |cost: StageCost| StageTime {
        name: cost.stage.name().to_owned(),
        ns: cost.has_run.then(|| u64::try_from(cost.time.as_nanos()).unwrap_or(u64::MAX)),
    };
    broken.stages().map(time).collect()
}
