//! Segments that nobody finishes. A process that dies between making a segment of shared memory and giving it a length leaves an
//! empty one, and whoever opens it waits for ever (iceoryx2 0.10.0, `dynamic_storage::posix_shared_memory`: an empty mapping is
//! the one case that looks at no timeout). An empty segment that somebody has been waiting for gets a byte: whoever opens it then
//! finds it unfinished, and says so. If its maker was only slow, it goes on as if nothing had been: a byte shortens nothing.

use crate::{Kind, Refusal, shared_memory};
use rustix::fs::{FallocateFlags, fallocate};
use std::collections::BTreeSet;
use std::fs::File;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::time::Duration;

/// A living process gives a segment its length within microseconds; one that is empty at two looks belongs to a dead or stopped one.
const LOOK: Duration = Duration::from_millis(100);

/// Frees calls of the transport from segments that nobody finishes, as long as it lives, on a thread of its own. The thread
/// sleeps but for ten looks a second at a counter; folders are read only while a call takes long.
pub struct Rescue {
    calls: Arc<AtomicUsize>,
    _lives: Sender<()>,
}

/// A call of the transport that may have to be freed.
pub struct Call(Arc<AtomicUsize>);

impl Drop for Call {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Rescue {
    /// For segments whose names begin with `prefix`. Errors: `failed`, when no thread can be started.
    pub fn new(prefix: &str) -> Result<Self, Refusal> {
        let calls = Arc::new(AtomicUsize::new(0));
        let (lives, ends) = mpsc::channel();
        let (under_way, prefix) = (calls.clone(), prefix.to_owned());
        let watch = move || {
            let mut empty = BTreeSet::new();
            while ends.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                empty = match under_way.load(Ordering::Relaxed) {
                    0 => BTreeSet::new(),
                    _ => grow_again_empty(Path::new(shared_memory::FOLDER), &prefix, &empty),
                };
            }
        };
        let thread = std::thread::Builder::new().name("shatter-rescue".into()).spawn(watch);
        thread.map_err(|error| Refusal::new(Kind::Failed, "threads", format!("no thread can be started: {error}")))?;
        Ok(Self { calls, _lives: lives })
    }

    /// Counts a call of the transport until what is returned is dropped.
    pub fn call(&self) -> Call {
        self.calls.fetch_add(1, Ordering::Relaxed);
        Call(self.calls.clone())
    }
}

/// Gives a byte to each segment of `folder` that was among the `empty` of the look before and still is; returns the empty ones.
fn grow_again_empty(folder: &Path, prefix: &str, empty: &BTreeSet<PathBuf>) -> BTreeSet<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let ours = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix));
    let now: BTreeSet<PathBuf> =
        ours.filter(|entry| entry.metadata().is_ok_and(|data| data.len() == 0)).map(|entry| entry.path()).collect();
    now.intersection(empty).for_each(|path| grow(path));
    now
}

/// Never shortens: the maker may give it its length at the same moment. A failure is tried again at the next look.
fn grow(path: &Path) {
    let no_follow = rustix::fs::OFlags::NOFOLLOW.bits() as i32;
    if let Ok(file) = File::options().write(true).custom_flags(no_follow).open(path) {
        let _ = fallocate(&file, FallocateFlags::empty(), 0, 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    fn segment(name: &str) -> PathBuf {
        let path = Path::new(shared_memory::FOLDER).join(format!("shatter_rescue_{}_{name}", std::process::id()));
        std::fs::write(&path, "").unwrap();
        path
    }

    fn length(path: &Path) -> u64 {
        std::fs::metadata(path).unwrap().len()
    }

    fn prefix() -> String {
        format!("shatter_rescue_{}_", std::process::id())
    }

    #[test]
    fn a_call_that_waits_for_an_empty_segment_is_freed_and_only_while_it_waits() {
        let rescue = Rescue::new(&prefix()).unwrap();
        let path = segment("waited");
        std::thread::sleep(LOOK * 4);
        assert_eq!(length(&path), 0, "grown though nobody waited");
        let (call, begun) = (rescue.call(), Instant::now());
        while length(&path) == 0 && begun.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(length(&path), 1);
        drop(call);
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn only_what_was_empty_before_grows_and_nothing_is_shortened() {
        let folder = tempfile::tempdir().unwrap();
        let make = |name: &str, bytes: usize| {
            let path = folder.path().join(name);
            std::fs::write(&path, vec![7; bytes]).unwrap();
            path
        };
        let (again, other, full) = (make("a_again", 0), make("b_other", 0), make("a_full", 9));
        let seen = grow_again_empty(folder.path(), "a_", &BTreeSet::new());
        assert_eq!((seen.len(), length(&again)), (1, 0));
        let fresh = make("a_fresh", 0);
        grow_again_empty(folder.path(), "a_", &seen);
        assert_eq!([&again, &other, &full, &fresh].map(|path| length(path)), [1, 0, 9, 0]);
        grow(&full);
        assert_eq!(std::fs::read(full).unwrap(), [7; 9]);
    }
}
