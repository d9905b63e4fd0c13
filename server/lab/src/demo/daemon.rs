//! The daemon of the demonstration as a child process.

use super::DemoError;
use rustix::process::{Pid, Signal, kill_process};
use shatter_server::commands::interrupt;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Time for the daemon to end on request.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);

/// Pause between two checks of a process that is ending.
const PAUSE: Duration = Duration::from_millis(10);

/// Running daemon. Dropping it kills the process by its id.
pub(super) struct Daemon {
    child: Child,
}

impl Daemon {
    /// Starts `program serve` and waits until it prints that it serves.
    pub fn start(program: &Path, service: &str, databases: &Path, timeout: Duration) -> Result<Self, DemoError> {
        let mut command = Command::new(program);
        command.args(["serve", "--service", service, "--log", "warn", "--databases"]).arg(databases);
        Self::spawn(command, timeout)
    }

    fn spawn(mut command: Command, timeout: Duration) -> Result<Self, DemoError> {
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().map_err(DemoError::Process)?;
        interrupt::child(Some(Pid::from_child(&child)));
        let mut daemon = Self { child };
        let Some(stdout) = daemon.child.stdout.take() else {
            return Err(DemoError::Process(std::io::ErrorKind::BrokenPipe.into()));
        };
        let lines = lines(stdout);
        let deadline = Instant::now() + timeout;
        loop {
            match lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(line) if line.trim() == "ready" => return Ok(daemon),
                Ok(_) => {}
                Err(RecvTimeoutError::Timeout) => return Err(DemoError::DaemonSilent { seconds: timeout.as_secs() }),
                Err(RecvTimeoutError::Disconnected) => {
                    let status = daemon.child.wait().map_err(DemoError::Process)?;
                    return Err(DemoError::DaemonEnded(status));
                }
            }
        }
    }

    /// Process id.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Asks the process to end and waits for it; kills it after the time limit.
    pub fn end(mut self) -> Result<(), DemoError> {
        kill_process(Pid::from_child(&self.child), Signal::TERM).map_err(|error| DemoError::Process(error.into()))?;
        let deadline = Instant::now() + STOP_TIMEOUT;
        while Instant::now() < deadline {
            if self.child.try_wait().map_err(DemoError::Process)?.is_some() {
                return Ok(());
            }
            std::thread::sleep(PAUSE);
        }
        self.child.kill().map_err(DemoError::Process)
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        interrupt::child(None);
        if let Ok(None) = self.child.try_wait() {
            // The process may have ended already.
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Lines that the daemon prints; stdout is read to its end, so that the daemon never blocks on writing.
fn lines(stdout: ChildStdout) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stdout).lines().map_while(Result::ok) {
            // Once the daemon is ready there is no receiver.
            let _ = sender.send(line);
        }
    });
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::process::test_kill_process;

    const TIMEOUT: Duration = Duration::from_secs(20);

    /// Starts a process that runs `script` in place of a daemon.
    fn start(script: &str, timeout: Duration) -> Result<Daemon, DemoError> {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        Daemon::spawn(command, timeout)
    }

    fn lives(pid: u32) -> bool {
        let pid = Pid::from_raw(i32::try_from(pid).unwrap()).unwrap();
        test_kill_process(pid).is_ok()
    }

    #[test]
    fn a_daemon_that_is_ready_runs_until_it_is_ended() {
        let daemon = start("echo starting; echo ready; exec sleep 600", TIMEOUT).unwrap();
        let pid = daemon.pid();
        assert!(lives(pid));
        daemon.end().unwrap();
        assert!(!lives(pid));
    }

    #[test]
    fn a_daemon_that_is_dropped_is_ended_too() {
        let daemon = start("echo ready; exec sleep 600", TIMEOUT).unwrap();
        let pid = daemon.pid();
        drop(daemon);
        assert!(!lives(pid));
    }

    #[test]
    fn a_daemon_that_does_not_come_up_is_named() {
        let ended = start("echo no; exit 3", TIMEOUT).err().unwrap();
        assert!(matches!(ended, DemoError::DaemonEnded(status) if status.code() == Some(3)), "{ended}");
        let silent = start("exec sleep 600", Duration::from_millis(50)).err().unwrap();
        assert!(matches!(silent, DemoError::DaemonSilent { .. }), "{silent}");
        let missing = Daemon::start(Path::new("/no/such/program"), "test", Path::new("/"), TIMEOUT).err().unwrap();
        assert!(matches!(missing, DemoError::Process(_)), "{missing}");
    }
}
