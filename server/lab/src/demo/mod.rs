//! `shatterd demo`: a generated mug, baked, served by a real daemon, struck three times through the real client, and shown on a
//! page.
//!
//! The demonstration takes no shortcut: the daemon is this program in a separate process, and the requests travel through shared
//! memory like those of any client. One quantity is computed in this process, with the same database and engine: the strain energy
//! that colors the intact mug, which results do not contain. The page states this.

mod daemon;
mod demo_impact;
mod energy;
mod error;
mod object;
mod page;
mod progress;
mod runtime_folder;
mod views;

pub use error::DemoError;
pub use object::NAME;

use crate::report;
use daemon::Daemon;
use demo_impact::DemoImpact;
use energy::SurfaceEnergy;
use object::DemoTarget;
use progress::DemoProgress;
use runtime_folder::RuntimeFolder;
use shatter_client::{Client, Deadline};
use shatter_export::{make_folder, write_whole};
use shatter_server::commands::interrupt;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Impulses of the requests over the one that just breaks the object: for few, some, and many fragments.
pub const IMPULSE_FACTORS: [f64; 3] = [2.0, 6.0, 25.0];

/// Name of the page in the output folder.
pub const PAGE: &str = "report.html";

/// Time for the daemon to start.
const START_TIMEOUT: Duration = Duration::from_secs(60);

/// Longest wait for a reply of the service.
const RESULT_TIMEOUT: Duration = Duration::from_secs(60);

/// Options of the demonstration.
#[derive(Clone, Debug)]
pub struct DemoOptions {
    /// Folder for the page and the fragments; created if needed.
    pub out: PathBuf,
    /// Folder for the baked object, which later runs reuse; created if needed.
    pub databases: PathBuf,
    /// Name of the service that the daemon opens.
    pub service: String,
    /// Program to start as the daemon.
    pub program: PathBuf,
}

/// Output of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct DemoFiles {
    /// Path of the page.
    pub page: PathBuf,
    /// Fragment files, one per request.
    pub files: Vec<PathBuf>,
    /// Lines for people, one per request.
    pub lines: Vec<String>,
    /// Whether an existing database was reused.
    pub reused: bool,
}

/// Runs the demonstration. In every case it ends the daemon, and removes a runtime folder that did not exist before.
pub fn run(options: &DemoOptions) -> Result<DemoFiles, DemoError> {
    let begun = Instant::now();
    let progress = DemoProgress::new();
    make_folder(&options.out)?;
    make_folder(&options.databases)?;
    let target = object::prepare(&options.databases, &progress)?;
    progress.step("start the daemon");
    // Created before the daemon, so that it is dropped after it.
    let runtime_folder = RuntimeFolder::of(&options.service)?;
    let daemon = Daemon::start(&options.program, &options.service, &options.databases, START_TIMEOUT)?;
    let pid = daemon.pid();
    let demo_impacts = strike(options, &target, &progress)?;
    progress.step("end the daemon");
    daemon.end()?;
    drop(runtime_folder);
    progress.step("strain energy");
    let energies = demo_impacts
        .iter()
        .map(|demo_impact| SurfaceEnergy::new(&target, demo_impact))
        .collect::<Result<Vec<_>, _>>()?;
    let pages = page::page(&target, pid, &demo_impacts, &energies, begun.elapsed(), &progress)?;
    let path = options.out.join(PAGE);
    let writing = interrupt::writing();
    write_whole(&path, report::html(&pages).as_bytes())?;
    drop(writing);
    progress.finish();
    Ok(DemoFiles {
        page: path,
        files: demo_impacts.iter().map(|demo_impact| options.out.join(&demo_impact.file)).collect(),
        lines: demo_impacts.iter().map(DemoImpact::line).collect(),
        reused: target.reused,
    })
}

/// Finds the impulse that just breaks the object, then sends requests with multiples of it.
fn strike(options: &DemoOptions, target: &DemoTarget, progress: &DemoProgress) -> Result<Vec<DemoImpact>, DemoError> {
    let service = Client::connect(&options.service, Deadline::after(START_TIMEOUT))?;
    let object = service.object(NAME, Deadline::after(RESULT_TIMEOUT))?;
    progress.step("find the threshold");
    let threshold_ns = demo_impact::threshold_ns(&object, target)?;
    let mut demo_impacts = Vec::with_capacity(IMPULSE_FACTORS.len());
    for (number, factor) in (1..).zip(IMPULSE_FACTORS) {
        progress.step(&format!("strike {number}: {factor} × the threshold"));
        demo_impacts.push(DemoImpact::strike(&object, target, threshold_ns, factor, &options.out, number)?);
    }
    Ok(demo_impacts)
}
