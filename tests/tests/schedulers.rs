//! The job files of `config` under their schedulers.
//!
//! `cargo test --release --workspace --test suite schedulers:: -- --ignored --nocapture` bakes an array of shares under Slurm (Debian: slurm-wlm
//! and munge) and under HyperQueue (Python: hyperqueue), if these are installed. One share fails, one is canceled, both are submitted
//! again, and the merged bytes equal those of an undivided bake.

use serde_json::{Value, json};
use shatter_tests::fixture::{Fixture, program};
use shatter_tests::peers;
use std::ffi::OsStr;
use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

/// Number of queries of a scheduler, one per [`PAUSE`], before the test gives up.
const ROUNDS: usize = 600;

const PAUSE: Duration = Duration::from_millis(500);

/// Common options of all bakes of these tests, after mesh and name.
const COARSE: [&str; 4] = ["--elastic-spacing", "0.25", "--crack-spacing", "0.15"];

const EXAMPLES: &str = "40";

fn config(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("config").join(file)
}

/// A box and its undivided bake, which the merged one must equal.
fn box_and_whole(fixture: &Fixture) -> (String, Vec<u8>) {
    let mesh = fixture.path("box.obj");
    let text = "v 0 0 0\nv 0 0 .4\nv 0 .6 0\nv 0 .6 .4\nv 1 0 0\nv 1 0 .4\nv 1 .6 0\nv 1 .6 .4\n\
                f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
    fs::write(&mesh, text).unwrap();
    let (mesh, out) = (mesh.display().to_string(), fixture.path("whole").display().to_string());
    let arguments = [&["bake", &mesh, "--name", "box", "--examples", EXAMPLES, "--out", &out], &COARSE[..]].concat();
    fixture.ok("shatterd", &arguments);
    (mesh, fs::read(fixture.path("whole/box.shatter")).unwrap())
}

/// Creates a folder in place of a share's file: that share fails until the folder is gone.
fn obstacle(shares: &Path, share: usize) -> PathBuf {
    let obstacle = shares.join(format!("box.{share}-of-8.share"));
    fs::create_dir_all(&obstacle).unwrap();
    obstacle
}

/// `PATH` with the workspace's programs before all others.
fn path() -> String {
    let programs = program("shatterd");
    format!("{}:{}", programs.parent().unwrap().display(), std::env::var("PATH").unwrap_or_default())
}

/// A private Slurm: one machine that acts as two nodes of four processors.
struct Slurm<'a> {
    fixture: &'a Fixture,
    daemons: Vec<Child>,
}

impl<'a> Slurm<'a> {
    /// Starts it; `None`, after a line that CI counts, if a program is not installed.
    fn start(fixture: &'a Fixture) -> Option<Self> {
        let needed = ["munged", "slurmctld", "slurmd", "sbatch", "scontrol"];
        let lacks =
            |name: &&str| Command::new("which").arg(name).output().map_or(true, |found| !found.status.success());
        if let Some(missing) = needed.into_iter().find(lacks) {
            println!("skipped: no {missing} (Debian: slurm-wlm, munge)");
            return None;
        }
        let mut slurm = Self { fixture, daemons: Vec::new() };
        slurm.configure();
        let at = |name: &str| fixture.path(name).display().to_string();
        let keys = [
            format!("--key-file={}", at("munge.key")),
            format!("--socket={}", at("munge.sock")),
            format!("--pid-file={}", at("munged.pid")),
            format!("--log-file={}", at("munged.log")),
            format!("--seed-file={}", at("munge.seed")),
        ];
        slurm.spawn("munged", &[&["--foreground", "--force"], &keys.each_ref().map(String::as_str)[..]].concat());
        slurm.wait("munge's socket", |slurm| slurm.fixture.path("munge.sock").exists());
        slurm.spawn("slurmctld", &["-D", "-c", "-i"]);
        slurm.spawn("slurmd", &["-D", "-N", "n0"]);
        slurm.spawn("slurmd", &["-D", "-N", "n1"]);
        slurm.wait("two idle nodes", |slurm| {
            let states = slurm.output("sinfo", &["--noheader", "--Node", "--format=%t"]);
            states.lines().filter(|state| *state == "idle").count() == 2
        });
        Some(slurm)
    }

    fn configure(&self) {
        use std::os::unix::fs::PermissionsExt;
        let key = self.fixture.path("munge.key");
        // As munge requires: readable by its owner only; the key protects only this Slurm.
        fs::write(&key, [std::process::id().to_le_bytes(); 64].concat()).unwrap();
        fs::set_permissions(&key, fs::Permissions::from_mode(0o400)).unwrap();
        fs::set_permissions(self.fixture.path(""), fs::Permissions::from_mode(0o755)).unwrap();
        let ports: Vec<TcpListener> = (0..3).map(|_| TcpListener::bind("127.0.0.1:0").unwrap()).collect();
        let [control, n0, n1] = [0, 1, 2].map(|index: usize| ports[index].local_addr().unwrap().port());
        let user = text(Command::new("id").arg("-un"));
        let host = text(Command::new("hostname").arg("-s"));
        let root = self.fixture.path("").display().to_string();
        let root = root.trim_end_matches('/');
        let node = |name: &str, port: u16| {
            format!("NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=4 RealMemory=16384\n")
        };
        // Works without cgroup v2 and without an accounting database.
        let conf = format!(
            "ClusterName=shatter\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={control}\nSlurmUser={user}\n\
             SlurmdUser={user}\nAuthType=auth/munge\nAuthInfo=socket={root}/munge.sock\nCredType=cred/munge\n\
             SlurmctldPidFile={root}/slurmctld.pid\nSlurmdPidFile={root}/%n.pid\nSlurmctldLogFile={root}/slurmctld.log\n\
             SlurmdLogFile={root}/%n.log\nStateSaveLocation={root}/state\nSlurmdSpoolDir={root}/spool-%n\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nJobAcctGatherType=jobacct_gather/none\n\
             AccountingStorageType=accounting_storage/none\nSelectType=select/cons_tres\n\
             SelectTypeParameters=CR_Core_Memory\nMpiDefault=none\nReturnToService=2\nSlurmdParameters=config_overrides\n\
             SchedulerParameters=sched_interval=2,bf_interval=2\n{}{}\
             PartitionName=all Nodes=n0,n1 Default=YES State=UP\n",
            node("n0", n0),
            node("n1", n1)
        );
        fs::create_dir_all(self.fixture.path("state")).unwrap();
        fs::write(self.fixture.path("slurm.conf"), conf).unwrap();
    }

    fn command(&self, name: &str) -> Command {
        let mut command = Command::new(name);
        command.env("SLURM_CONF", self.fixture.path("slurm.conf")).current_dir(self.fixture.path(""));
        command.env("PATH", path()).env("SHATTER_OUT", self.fixture.path("shares")).env_remove("SHATTER_SHARDS");
        command
    }

    fn spawn(&mut self, name: &str, arguments: &[&str]) {
        let mut command = self.command(name);
        self.daemons.push(command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    }

    fn output(&self, name: &str, arguments: &[&str]) -> String {
        text(self.command(name).args(arguments))
    }

    #[track_caller]
    fn wait(&self, what: &str, done: impl Fn(&Self) -> bool) {
        for _ in 0..ROUNDS {
            if done(self) {
                return;
            }
            sleep(PAUSE);
        }
        let log = fs::read_to_string(self.fixture.path("slurmctld.log")).unwrap_or_default();
        panic!("no {what}: {log}");
    }

    /// Submits a job file; returns the job's number.
    #[track_caller]
    fn submit(&self, options: &[&str], file: &str, arguments: &[&str]) -> String {
        let file = config(file).display().to_string();
        let job = self.output("sbatch", &[&["--parsable"], options, &[&file], arguments].concat());
        assert!(!job.is_empty() && job.bytes().all(|byte| byte.is_ascii_digit()), "{job:?}");
        job
    }

    /// Final states of a job's tasks, by task, once all have ended.
    #[track_caller]
    fn ends(&self, job: &str) -> Vec<String> {
        self.wait(&format!("end of job {job}"), |slurm| {
            slurm.output("squeue", &["--noheader", "--job", job]).is_empty()
        });
        let output = self.output("scontrol", &["--oneliner", "show", "job", job]);
        let field = |line: &str, key: &str| -> Option<String> {
            line.split_whitespace().find_map(|word| word.strip_prefix(key)).map(str::to_owned)
        };
        let task = |line: &str| field(line, "ArrayTaskId=").and_then(|id| id.parse::<usize>().ok()).unwrap_or(0);
        let mut ends: Vec<(usize, String)> =
            output.lines().filter_map(|line| Some((task(line), field(line, "JobState=")?))).collect();
        ends.sort();
        ends.into_iter().map(|(_, state)| state).collect()
    }
}

impl Drop for Slurm<'_> {
    fn drop(&mut self) {
        for daemon in self.daemons.iter_mut().rev() {
            let pid = rustix::process::Pid::from_child(daemon);
            let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
            let _ = daemon.wait();
        }
    }
}

/// Output of a command; empty if it fails.
fn text(command: &mut Command) -> String {
    let output = command.output().unwrap();
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

#[test]
#[ignore = "needs slurm-wlm and munge; a minute"]
fn slurm_bakes_what_an_undivided_bake_gives() {
    let fixture = Fixture::new();
    let (mesh, whole) = box_and_whole(&fixture);
    let Some(slurm) = Slurm::start(&fixture) else { return };
    let arguments = [&[mesh.as_str(), "box", EXAMPLES], &COARSE[..]].concat();
    let obstacle = obstacle(&fixture.path("shares"), 3);
    // Held until one task is canceled, so that it has not run.
    let job = slurm.submit(&["--hold"], "slurm/bake.sbatch", &arguments);
    let early = slurm.submit(&[&format!("--dependency=afterok:{job}")], "slurm/merge.sbatch", &["box"]);
    slurm.output("scancel", &[&format!("{job}_5")]);
    slurm.output("scontrol", &["release", &job]);
    let mut ends = slurm.ends(&job);
    println!("slurm, first: {ends:?}");
    // A task that is canceled before it ran may leave no record.
    ends.retain(|state| state != "CANCELED");
    let expected = ["COMPLETED", "COMPLETED", "COMPLETED", "FAILED", "COMPLETED", "COMPLETED", "COMPLETED"];
    assert_eq!(ends, expected);
    assert!(!fixture.path("shares/box.5-of-8.share").exists(), "task 5 did not run");
    assert_eq!(slurm.ends(&early), ["CANCELED"], "a merge after a failed share does not stay in the queue");

    fs::remove_dir(obstacle).unwrap();
    let again = slurm.submit(&["--array=3,5"], "slurm/bake.sbatch", &arguments);
    let dependency = format!("--dependency=afterok:{again}");
    let merge = slurm.submit(&[&dependency], "slurm/merge.sbatch", &["box", "merged"]);
    assert_eq!(slurm.ends(&merge), ["COMPLETED"]);
    println!("slurm, again: {:?}", slurm.ends(&again));
    assert!(fs::read(fixture.path("merged/box.shatter")).unwrap() == whole, "merged bytes are an undivided bake's");
}

#[test]
#[ignore = "needs Python's hyperqueue"]
fn hyperqueue_bakes_what_an_undivided_bake_gives() {
    let fixture = Fixture::new();
    let (mesh, whole) = box_and_whole(&fixture);
    let shares = fixture.path("shares");
    let obstacle = obstacle(&shares, 3);
    let run = |server: &str, tasks: &str| -> Option<Value> {
        let (server, script) = (fixture.path(server), config("hyperqueue/bake.sh"));
        let head: [&OsStr; 4] = [server.as_ref(), script.as_ref(), shares.as_ref(), tasks.as_ref()];
        let rest = [mesh.as_str(), "box", EXAMPLES].into_iter().chain(COARSE).map(OsStr::new);
        let arguments: Vec<&OsStr> = head.into_iter().chain(rest).collect();
        peers::hyperqueue(&arguments, &fixture.path(""), &path())
    };
    // Task 5 is not submitted the first time.
    let Some(first) = run("first", "0,1,2,3,4,6,7") else { return };
    println!("hyperqueue, first: {first}");
    assert_eq!(first["failed"], json!([3]));
    fs::remove_dir(obstacle).unwrap();
    let again = run("again", "3,5").unwrap();
    println!("hyperqueue, again: {again}");
    assert_eq!(again["failed"], json!([]));

    let mut merge = Command::new(config("hyperqueue/merge.sh"));
    merge.env("SHATTER_OUT", &shares).env("PATH", path()).arg("box").arg(fixture.path("merged"));
    assert!(merge.status().unwrap().success());
    assert!(fs::read(fixture.path("merged/box.shatter")).unwrap() == whole, "merged bytes are an undivided bake's");
}

#[test]
fn kubernetes_files_fit_the_schema() {
    let files = ["kubernetes/bake.yaml", "kubernetes/merge.yaml"].map(config);
    let Some(found) = peers::kubernetes(&files.each_ref().map(PathBuf::as_path)) else { return };
    assert_eq!((&found["files"], &found["wrong"]), (&json!(2), &json!([])), "{found}");
}
