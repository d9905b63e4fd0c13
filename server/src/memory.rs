//! Resident memory of this process, and release of free heap memory.

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

/// Returns free heap pages to the system, if the C library can.
///
/// After loading, about a tenth of an object's memory is free in the heap: 81 of 992 MB for the vase, 12 of 92 MB for the mug.
pub fn release_free() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: glibc declares it so in malloc.h.
        unsafe extern "C" {
            fn malloc_trim(pad: usize) -> std::ffi::c_int;
        }
        // SAFETY: glibc's function of that signature; it may be called at any time from any thread, and touches free memory only.
        unsafe { malloc_trim(0) };
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
