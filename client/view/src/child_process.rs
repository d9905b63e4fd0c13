//! A child process that ends with this one.

use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

/// Time for a process to end on request.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);

/// Pause between two checks of a process that is ending.
const PAUSE: Duration = Duration::from_millis(10);

/// A child process. Dropping it asks the process to end, and kills it by its id after a time limit.
pub(crate) struct ChildProcess(Child);

impl ChildProcess {
    /// Starts `command`.
    ///
    /// # Errors
    /// Those of the system.
    pub fn start(command: &mut Command) -> std::io::Result<Self> {
        command.spawn().map(Self)
    }

    /// The process itself.
    pub fn child(&mut self) -> &mut Child {
        &mut self.0
    }

    /// Its exit status, if it has ended.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.0.try_wait().ok().flatten()
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        if self.ended().is_some() {
            return;
        }
        let pid = rustix::process::Pid::from_child(&self.0);
        // The process may have ended already.
        let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
        let deadline = Instant::now() + STOP_TIMEOUT;
        while Instant::now() < deadline {
            if self.ended().is_some() {
                return;
            }
            std::thread::sleep(PAUSE);
        }
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_ends_when_it_is_dropped() {
        let mut process = ChildProcess::start(Command::new("sleep").arg("600")).unwrap();
        let pid = rustix::process::Pid::from_child(process.child());
        assert!(process.ended().is_none());
        drop(process);
        assert!(rustix::process::test_kill_process(pid).is_err());
    }
}
