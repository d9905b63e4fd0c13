//! A counting allocator.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts the bytes that are allocated now, and all that were ever allocated.
pub struct Counting {
    out: AtomicUsize,
    ever: AtomicUsize,
}

// SAFETY: every request is passed unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        self.out.fetch_add(layout.size(), Ordering::Relaxed);
        self.ever.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's guarantees are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        self.out.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's guarantees are passed on.
        unsafe { System.dealloc(place, layout) }
    }
}

impl Counting {
    pub const fn new() -> Self {
        Self { out: AtomicUsize::new(0), ever: AtomicUsize::new(0) }
    }

    /// Bytes allocated now.
    #[allow(dead_code, reason = "each test uses one of the counters")]
    pub fn out(&self) -> usize {
        self.out.load(Ordering::Relaxed)
    }

    /// Bytes allocated so far, including those freed since.
    #[allow(dead_code, reason = "each test uses one of the counters")]
    pub fn ever(&self) -> usize {
        self.ever.load(Ordering::Relaxed)
    }
}
