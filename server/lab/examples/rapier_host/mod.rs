//! Parts of the host, and its main loop.

mod close_up;
mod film;
mod glaze;
mod glb;
mod pictures;
mod prototype;
mod service;
mod set;
mod strikes;
mod tally;
mod vessel;
mod world;

use film::Film;
use prototype::Prototype;
use service::DaemonSupervisor;
use set::Set;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use strikes::Strikes;
use tally::Tally;
use world::World;

/// Error of the host, as text.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Number of steps per picture of the film.
const FILM_STEPS: u32 = 4;

/// Headless Rapier simulation whose bodies break
#[derive(clap::Parser)]
pub struct Options {
    /// Set of the simulation
    #[arg(long, value_enum, default_value = "shelves")]
    set: Set,
    /// Duration of the simulation in seconds
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Folder for the output
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Name of the service; the host starts a daemon if none runs under that name
    #[arg(long, default_value = "rapier-host")]
    service: String,
    /// Folder of databases, baked if they do not exist [default: databases in the folder of --out]
    #[arg(long, value_name = "DIR")]
    databases: Option<PathBuf>,
    /// Program of the daemon [default: next to the folder of this program]
    #[arg(long, value_name = "FILE")]
    shatterd: Option<PathBuf>,
    /// Time of the simulation at which the daemon is killed, in seconds
    #[arg(long, value_name = "S")]
    kill_at: Option<f64>,
    /// Run as fast as possible instead of in real time; results then arrive later in the simulation
    #[arg(long)]
    fast: bool,
}

/// Runs the simulation and returns the contents of `summary.json`.
pub fn run(options: &Options) -> Result<serde_json::Value, Failure> {
    std::fs::create_dir_all(&options.out)?;
    let databases = options.databases.clone().unwrap_or_else(|| options.out.join("databases"));
    let place = service::provide(options.set, options.shatterd.clone(), &databases, options.service.clone())?;
    let mut supervisor = DaemonSupervisor::new(place);
    let line = supervisor.first()?;
    let prototypes: Vec<Prototype> = line.objects.iter().map(Prototype::of).collect::<Result<_, _>>()?;
    let steps = (options.seconds * f64::from(options.set.rate_hz())).round() as u32;
    // The same set without fracture, for comparison of the step times.
    let whole = played(&prototypes, None, steps, options);
    let result =
        played(&prototypes, Some(Strikes::new(line, &mut supervisor, options.set == Set::Vase)), steps, options);
    supervisor.end();
    let (tally, film) = &result;
    std::fs::write(options.out.join("film.glb"), glb::bytes(film)?)?;
    match options.set {
        Set::Shelves => std::fs::write(options.out.join("film.png"), pictures::sheet(film, options.seconds)?)?,
        Set::Vase => {
            let [still, animation] = close_up::pictures(film)?;
            std::fs::write(options.out.join("vase.png"), still)?;
            std::fs::write(options.out.join("vase-film.png"), animation)?;
        }
    }
    std::fs::write(options.out.join("steps.svg"), tally.plot(&whole.0)?)?;
    let summary = tally.summary(&whole.0, film);
    std::fs::write(options.out.join("summary.json"), format!("{summary:#}\n"))?;
    Ok(summary)
}

/// One run of the set, with fracture if there are `strikes`.
fn played(prototypes: &[Prototype], mut strikes: Option<Strikes<'_>>, steps: u32, options: &Options) -> (Tally, Film) {
    let dt_s = 1.0 / f64::from(options.set.rate_hz());
    let (mut film, mut tally) = (Film::default(), Tally::default());
    let mut world = World::new(prototypes, options.set, &mut film);
    tally.begin(&world);
    let begun = Instant::now();
    for step in 0..steps {
        let now_s = f64::from(step) * dt_s;
        let own = Instant::now();
        world.step(now_s);
        let mut spent = tally::Step { at_s: now_s, physics: own.elapsed(), ..Default::default() };
        if let Some(strikes) = &mut strikes {
            if options.kill_at.is_some_and(|at_s| (at_s..at_s + dt_s).contains(&now_s)) {
                strikes.kill_daemon();
            }
            strikes.turn(&mut world, &mut film, now_s, &mut spent, &mut tally);
        }
        spent.whole = own.elapsed();
        // Measuring, filming and waiting for real time are specific to this example.
        world.measure_births(&mut tally);
        tally.step(spent, &world);
        if step % FILM_STEPS == 0 {
            film.shoot(now_s, &world);
        }
        let due = begun + Duration::from_secs_f64(now_s + dt_s);
        if strikes.is_some() && !options.fast {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }
    tally.end(&world);
    (tally, film)
}
