//! A full `/dev/shm` kills with SIGBUS.
//!
//! **Symptom.** Segments are sparse files: a page exists once it is written, and where no page is left the kernel sends SIGBUS. The
//! transport neither checks for free space nor populates pages.
//!
//! **Reproduction** (iceoryx2 0.10.0). A `/dev/shm` of 64 MiB and a pool of eight buckets of 50 MiB: the pool is created, and the process
//! dies while it fills the second response. `MADV_POPULATE_WRITE` on the same range returns an error instead.
//!
//! **Upstream.** No issue known.
//!
//! **Delete.** This file, [`populated_pages`](super::populated_pages) and their calls before a segment is created or written, once the
//! transport populates pages itself and returns an error.

use rustix::io::Errno;
use rustix::mm::{Advice, madvise};
use shatter_proto::{Error, ErrorKind};
use std::ops::Range;
use std::path::Path;

/// Folder of shared memory.
const FOLDER: &str = crate::instance::SHARED_MEMORY;

/// Files that a connection needs, with some to spare.
const FILES: u64 = 64;

/// Bytes that a connection may need; a transport that does not get them dies of SIGBUS.
pub const CONNECTION_BYTES: u64 = 8 << 20;

/// Segments beyond this size are pools, of which only what is lent is populated.
const SEGMENT_MAX: usize = 16 * 1024 * 1024;

/// Bytes that shared memory can still take.
///
/// # Errors
/// `shared_memory`.
pub fn free_bytes() -> Result<u64, Error> {
    match rustix::fs::statvfs(FOLDER) {
        Ok(data) => Ok(data.f_bavail.saturating_mul(data.f_frsize)),
        Err(error) => Err(full(0, &error.to_string())),
    }
}

/// Refuses unless shared memory can take `bytes` more, in a few more files.
///
/// # Errors
/// `shared_memory`.
pub fn need(bytes: u64) -> Result<(), Error> {
    let free = free_bytes()?;
    if free < bytes {
        return Err(full(bytes, &format!("{free} are left")));
    }
    match rustix::fs::statvfs(FOLDER) {
        // A file system without a limit says that it has no files at all.
        Ok(data) if data.f_files > 0 && data.f_favail < FILES => Err(Error::new(
            ErrorKind::SharedMemory,
            FOLDER,
            format!("{FOLDER} can take {} more files, {FILES} are needed (df -i {FOLDER})", data.f_favail),
        )),
        _ => Ok(()),
    }
}

/// Makes the pages of `range` (addresses) exist; no byte changes.
///
/// # Errors
/// `shared_memory`; `transport` for addresses that are not mapped writable, or a segment that is cut short.
pub fn populate(range: Range<usize>) -> Result<(), Error> {
    let page = rustix::param::page_size();
    let start = range.start / page * page;
    let length = range.end.saturating_sub(start);
    // SAFETY: MADV_POPULATE_WRITE changes no byte: it faults pages in as a write would, and refuses addresses that are not
    // mapped, or not mapped writable. No Rust object is touched.
    let done = unsafe { madvise(start as *mut _, length, Advice::LinuxPopulateWrite) };
    match done {
        Ok(()) => Ok(()),
        // Before Linux 5.14 there is no such advice: look at what is left instead.
        Err(Errno::INVAL) => need(length as u64),
        Err(_) if need(length as u64).is_ok() => Err(torn(length)),
        Err(error) => Err(full(length as u64, &error.to_string())),
    }
}

/// Makes the pages of every segment exist that lies in `folder` and that this process has mapped writable; pools aside.
///
/// # Errors
/// Those of [`populate`].
pub fn populate_mapped(folder: &Path) -> Result<(), Error> {
    let maps = std::fs::read_to_string("/proc/self/maps").map_err(|error| full(0, &error.to_string()))?;
    maps.lines().filter_map(|line| writable(line, folder)).try_for_each(populate)
}

/// The addresses of a line of the memory map, if it is such a segment.
fn writable(line: &str, folder: &Path) -> Option<Range<usize>> {
    let (addresses, rest) = line.split_once(' ')?;
    let path = Path::new(rest.get(rest.find('/')?..)?);
    let (start, end) = addresses.split_once('-')?;
    let hex = |text| usize::from_str_radix(text, 16).ok();
    let range = hex(start)?..hex(end)?;
    (rest.starts_with("rw-s") && path.starts_with(folder) && range.len() <= SEGMENT_MAX).then_some(range)
}

/// The error for pages that cannot exist despite free space: the creator of the segment died before it reached its full length.
fn torn(length: usize) -> Error {
    Error::new(ErrorKind::Transport, FOLDER, format!("a segment of {length} bytes is cut short: its maker died"))
}

fn full(wanted: u64, why: &str) -> Error {
    let message = format!("{FOLDER} cannot take another {wanted} bytes: {why}");
    Error::new(ErrorKind::SharedMemory, FOLDER, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn populating_changes_no_byte() {
        let bytes = vec![7u8; 1 << 16];
        let start = bytes.as_ptr() as usize;
        populate(start..start + bytes.len()).unwrap();
        assert!(bytes.iter().all(|byte| *byte == 7));
        populate_mapped(Path::new("/dev/shm/of_no_service")).unwrap();
    }

    #[test]
    fn memory_that_cannot_exist_is_an_error_not_a_signal() {
        // Page zero is never mapped.
        assert_eq!(populate(0..4096).unwrap_err().kind, ErrorKind::Transport);
        assert_eq!(need(u64::MAX).unwrap_err().kind, ErrorKind::SharedMemory);
        assert!(free_bytes().unwrap() > 0);
    }

    #[test]
    fn only_small_writable_segments_of_the_folder_are_populated() {
        let line = |rights: &str, end: &str, name: &str| {
            format!("7f0000000000-{end} {rights} 00000000 00:1a 3   /dev/shm/{name}")
        };
        let found = |rights, end, name| writable(&line(rights, end, name), Path::new("/dev/shm/sh_ab")).is_some();
        assert!(found("rw-s", "7f0000001000", "sh_ab/s_1.connection"));
        assert!(!found("r--s", "7f0000001000", "sh_ab/s_1.data"));
        assert!(!found("rw-s", "7f0000001000", "sh_abc/s_1.data"));
        assert!(!found("rw-s", "7f0040000000", "sh_ab/s_1.data"));
        assert_eq!(writable("7f00-7f01 rw-p 0 0:0 0", Path::new("/dev/shm/sh_ab")), None);
    }
}
