//! Resident memory of this process, and release of free heap memory.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
use std::sync::{Mutex, PoisonError};

/// Resident memory of this process by what backs it, bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResidentMemory {
    /// Heap and stacks.
    pub anonymous: u64,
    /// The program and its libraries.
    pub file: u64,
    /// Shared memory: results.
    pub shared: u64,
}

impl ResidentMemory {
    /// Current values from the kernel; `None` if it does not report them.
    pub fn now() -> Option<Self> {
        Self::parse(&std::fs::read_to_string("/proc/self/status").ok()?)
    }

    /// Reads the lines of `/proc/PID/status`, whose unit is 1024 bytes.
    fn parse(status: &str) -> Option<Self> {
        let bytes = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
            line.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
        };
        Some(Self { anonymous: bytes("RssAnon")?, file: bytes("RssFile")?, shared: bytes("RssShmem")? })
    }

    /// Sum of all parts.
    pub fn total(&self) -> u64 {
        self.anonymous + self.file + self.shared
    }
}

/// Returns free heap pages to the system, if the C library can, also those at the end of the heap of the calling thread.
///
/// After loading, about a tenth of an object's memory is free in the heap: 81 of 992 MB for the vase, 12 of 92 MB for the mug.
pub fn release_free() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: glibc declares it so in malloc.h.
        unsafe extern "C" {
            fn malloc_trim(pad: usize) -> std::ffi::c_int;
        }
        // `malloc_trim` keeps the end of the heaps of all threads but the main one. Freeing a block there releases it.
        let loading = LoadGuard::begin();
        drop(std::hint::black_box(Vec::<u8>::with_capacity(END_BYTES)));
        // SAFETY: glibc's function of that signature; it may be called at any time from any thread, and touches free memory only.
        unsafe { malloc_trim(0) };
        drop(loading);
    }
}

/// Size of a block whose release lets glibc trim the end of a thread's heap: more than 64 KiB, and too small for pages of its own.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const END_BYTES: usize = 128 << 10;

/// Number of databases that are being loaded.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
static LOADS: Mutex<usize> = Mutex::new(0);

/// Guard of a load: tables that stay are allocated apart from memory that is soon free again.
///
/// The C library gives blocks beyond a threshold pages of their own. The threshold rises with the blocks that are freed, so that tables
/// would lie between free blocks, whose pages they keep: 17 % of the memory of the mug. After the load the threshold is the highest, as
/// freed blocks make it, because requests would pay for new pages.
pub struct LoadGuard(());

impl LoadGuard {
    /// Begins a load.
    pub fn begin() -> Self {
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        {
            let mut loads = LOADS.lock().unwrap_or_else(PoisonError::into_inner);
            *loads += 1;
            set_thresholds(LOAD_THRESHOLD);
        }
        Self(())
    }
}

impl Drop for LoadGuard {
    fn drop(&mut self) {
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        {
            let mut loads = LOADS.lock().unwrap_or_else(PoisonError::into_inner);
            *loads -= 1;
            if *loads == 0 {
                set_thresholds(THRESHOLD_MAX);
            }
        }
    }
}

/// Size from which a block has pages of its own during loads, bytes.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const LOAD_THRESHOLD: i32 = 256 << 10;

/// As [`LOAD_THRESHOLD`], outside of loads: the highest that glibc sets by itself.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const THRESHOLD_MAX: i32 = 32 << 20;

/// Sets the size from which a block has pages of its own; twice as much may be free at the end of the heap, as glibc sets it by itself.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn set_thresholds(bytes: i32) {
    const M_TRIM_THRESHOLD: i32 = -1;
    const M_MMAP_THRESHOLD: i32 = -3;
    // SAFETY: glibc declares it so in malloc.h.
    unsafe extern "C" {
        fn mallopt(parameter: std::ffi::c_int, value: std::ffi::c_int) -> std::ffi::c_int;
    }
    // SAFETY: glibc's function of that signature, which locks the heap; it may be called at any time from any thread.
    unsafe {
        mallopt(M_MMAP_THRESHOLD, bytes);
        mallopt(M_TRIM_THRESHOLD, 2 * bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_kernel_are_read() {
        let status = "VmRSS:\t   99292 kB\nRssAnon:\t   74680 kB\nRssFile:\t   13488 kB\nRssShmem:\t   11124 kB\n";
        let found = ResidentMemory::parse(status).unwrap();
        assert_eq!(found, ResidentMemory { anonymous: 74_680 << 10, file: 13_488 << 10, shared: 11_124 << 10 });
        assert_eq!(found.total(), 99_292 << 10);
        assert_eq!(ResidentMemory::parse("VmRSS:\t12 kB"), None);
    }

    /// Bytes that the process no longer holds after 32 MB of tables of a load are freed.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    fn released_by_tables() -> u64 {
        let resident = || ResidentMemory::now().unwrap().anonymous;
        // Freed, this block would raise the threshold beyond the tables.
        drop(vec![1_u8; 24 << 20]);
        let loading = LoadGuard::begin();
        // Temporary blocks between tables: without pages of their own, the tables would hold what lies before them.
        let mut tables = Vec::new();
        for _ in 0..32 {
            let temporary = vec![1_u8; 4 << 20];
            tables.push(vec![1_u8; 1 << 20]);
            drop(temporary);
        }
        let full = resident();
        drop(tables);
        let released = full.saturating_sub(resident());
        drop(loading);
        released
    }

    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    #[test]
    fn tables_of_a_load_have_pages_of_their_own() {
        // Other tests of the process may take memory meanwhile.
        assert!((0..5).any(|_| released_by_tables() > 24 << 20), "pages of freed tables stay resident");
    }

    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    #[test]
    fn free_pages_are_given_back() {
        // Blocks below the size for which the allocator uses separate mappings, and in total more than noise.
        let many: Vec<Vec<u8>> = (0..1_000).map(|_| vec![1; 64 << 10]).collect();
        let last = vec![1; 64 << 10];
        let full = ResidentMemory::now().unwrap().anonymous;
        drop(many);
        release_free();
        let left = ResidentMemory::now().unwrap().anonymous;
        assert!(left + (32 << 20) < full && last[0] == 1, "{left} of {full} bytes are left");
    }
}
