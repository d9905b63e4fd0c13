//! The daemon: lookup, bake, start, restart and end. All waiting is on a separate thread.

use super::Failure;
use rustix::process::{Pid, Signal, kill_process};
use shatter_client::{Client, Deadline, Object};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Scene of the set for `shatterd bake --scene`; fragments of a few nodes are too small for a game.
const SCENE: &str = r#"title = "Rapier host"

[objects.mug]
shape = "mug"
material = "terracotta"
quality = "draft"
effects = ["elastic", "interior", "release", "hulls"]
sites_max = 16

[objects.statue]
shape = "statue"
material = "plaster"
quality = "draft"
effects = ["elastic", "interior", "release", "hulls"]
sites_max = 24

[objects.vase]
quality = "draft"
effects = ["elastic", "interior", "release", "hulls"]
sites_max = 20
"#;

/// Objects of the set, in the order of prototypes.
pub const OBJECTS: [&str; 3] = ["mug", "statue", "vase"];

/// Time for the daemon to start.
const TIMEOUT: Duration = Duration::from_secs(60);

/// Time for the daemon to end on request.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);

/// Program of the daemon, and its folders and service name.
pub struct Place {
    program: PathBuf,
    databases: PathBuf,
    scene: PathBuf,
    service: String,
}

/// Connection with its objects, in the order of [`OBJECTS`].
pub struct ServiceLink {
    pub objects: Vec<Object>,
    /// Process id of the daemon.
    pub pid: u32,
}

/// Finds the program, and bakes the databases that do not exist.
pub fn provide(program: Option<PathBuf>, databases: &Path, service: String) -> Result<Place, Failure> {
    let own = std::env::current_exe()?;
    let beside = own.parent().and_then(Path::parent).map(|folder| folder.join("shatterd"));
    let program = program.or(beside).filter(|program| program.is_file());
    let program = program
        .ok_or("cannot find the program `shatterd`; build the workspace first, or name it with --shatterd FILE")?;
    std::fs::create_dir_all(databases)?;
    let scene = databases.join("host.toml");
    std::fs::write(&scene, SCENE)?;
    let bake =
        Command::new(&program).args(["bake", "--scene"]).arg(&scene).arg("--databases").arg(databases).status()?;
    if !bake.success() {
        return Err(format!("`shatterd bake` ended with {bake}").into());
    }
    if !databases.join("vase.shatter").is_file() {
        let mesh = databases.join("vase.obj");
        std::fs::write(&mesh, vase())?;
        let mut bake = Command::new(&program);
        bake.arg("bake").arg(&mesh).args([
            "--name",
            "vase",
            "--material",
            "ceramic",
            "--quality",
            "draft",
            "--databases",
        ]);
        let bake = bake.arg(databases).stdout(Stdio::null()).status()?;
        if !bake.success() {
            return Err(format!("`shatterd bake` ended with {bake}").into());
        }
    }
    Ok(Place { program, databases: databases.to_owned(), scene, service })
}

/// Earthenware vase as OBJ: a profile rotated about +y, 0.3 m high. Its walls of 16 mm suit coarse lattices.
fn vase() -> String {
    let (steps, around, wall_m, height_m) = (40_u32, 64_u32, 0.016, 0.3);
    let radius = |t: f64| 0.062 + 0.026 * (std::f64::consts::TAU * (0.85 * t + 0.1)).sin();
    let share = |k: u32| f64::from(k) / f64::from(steps);
    let floor = 0.02 / height_m;
    let outside = (0..=steps).map(|k| [radius(share(k)), height_m * share(k)]);
    let inside = (0..=steps).map(|k| 1.0 - (1.0 - floor) * share(k)).map(|t| [radius(t) - wall_m, height_m * t]);
    let profile: Vec<[f64; 2]> = outside.chain(inside).collect();
    let mut text = format!("v 0 0 0\nv 0 {} 0\n", height_m * floor);
    for [r, y] in &profile {
        for angle in (0..around).map(|k| std::f64::consts::TAU * f64::from(k) / f64::from(around)) {
            text += &format!("v {} {y} {}\n", r * angle.cos(), -r * angle.sin());
        }
    }
    // OBJ numbers start at 1: the two points on the axis, then ring by ring.
    let at = |ring: u32, k: u32| 3 + ring * around + k % around;
    let last = profile.len() as u32 - 1;
    for k in 0..around {
        text += &format!("f 1 {} {}\nf 2 {} {}\n", at(0, k + 1), at(0, k), at(last, k), at(last, k + 1));
        for ring in 0..last {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    text
}

/// Thread that connects to the daemon, and starts one if necessary.
pub struct DaemonSupervisor {
    /// Channel for requests of a connection; closed at the end.
    ask: Option<Sender<Option<ServiceLink>>>,
    lines: Receiver<Result<ServiceLink, Failure>>,
    thread: Option<JoinHandle<()>>,
}

impl DaemonSupervisor {
    pub fn new(place: Place) -> Self {
        let (ask, asked) = channel();
        let (send, lines) = channel();
        let thread = std::thread::spawn(move || {
            let mut child = None;
            // The loop ends when the host drops its sender.
            while let Ok(former) = asked.recv() {
                let sent = send.send(line(&place, &mut child));
                drop(former);
                if sent.is_err() {
                    break;
                }
            }
            child.into_iter().for_each(end);
        });
        Self { ask: Some(ask), lines, thread: Some(thread) }
    }

    /// Waits for the first connection.
    pub fn first(&mut self) -> Result<ServiceLink, Failure> {
        self.want(None);
        self.lines.recv()?
    }

    /// Requests a connection without waiting. The thread also cleans up after the former one.
    pub fn want(&self, former: Option<ServiceLink>) {
        // If the thread has ended, the host continues without fracture.
        let _ = self.ask.as_ref().map(|ask| ask.send(former));
    }

    /// The requested connection, if it is ready; never waits.
    pub fn line(&self) -> Option<Result<ServiceLink, Failure>> {
        self.lines.try_recv().ok()
    }

    /// Ends the daemon, if this host started it.
    pub fn end(mut self) {
        self.ask = None;
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Connects to the daemon; starts one if no daemon runs.
fn line(place: &Place, child: &mut Option<Child>) -> Result<ServiceLink, Failure> {
    let deadline = Instant::now() + TIMEOUT;
    loop {
        match connected(place) {
            Ok(line) => return Ok(line),
            Err(error) if Instant::now() > deadline => return Err(error),
            Err(_) => {}
        }
        let ended = match child {
            Some(child) => child.try_wait()?.is_some(),
            None => true,
        };
        if ended {
            let mut serve = Command::new(&place.program);
            serve.args(["serve", "--log", "warn", "--service", &place.service, "--databases"]).arg(&place.databases);
            serve.arg("--scene").arg(&place.scene).stdin(Stdio::null()).stdout(Stdio::null());
            *child = Some(serve.spawn()?);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn connected(place: &Place) -> Result<ServiceLink, Failure> {
    let timeout = Deadline::after(Duration::from_secs(20));
    let service = Client::connect(&place.service, timeout)?;
    let objects = OBJECTS.iter().map(|name| service.object(name, timeout)).collect::<Result<_, _>>()?;
    Ok(ServiceLink { objects, pid: service.status(timeout)?.pid })
}

/// Asks the daemon to end and waits; kills it after the time limit.
fn end(mut child: Child) {
    // It may have ended already.
    let _ = kill_process(Pid::from_child(&child), Signal::TERM);
    let deadline = Instant::now() + STOP_TIMEOUT;
    while Instant::now() < deadline {
        if !matches!(child.try_wait(), Ok(None)) {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let _ = child.kill();
    let _ = child.wait();
}

/// Kills the daemon, to simulate a crash.
pub fn kill(pid: u32) {
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw);
    let _ = pid.map(|pid| kill_process(pid, Signal::KILL));
}
