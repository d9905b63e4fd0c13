//! An allocator that counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts bytes that are out, and all that were ever handed out.
pub struct Counting {
    out: AtomicUsize,
    ever: AtomicUsize,
}

// SAFETY: every request is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        self.out.fetch_add(layout.size(), Ordering::Relaxed);
        self.ever.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        self.out.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(place, layout) }
    }
}

impl Counting {
    pub const fn new() -> Self {
        Self { out: AtomicUsize::new(0), ever: AtomicUsize::new(0) }
    }

    /// Bytes that are out now.
    #[allow(dead_code, reason = "every test asks for what it needs")]
    pub fn out(&self) -> usize {
        self.out.load(Ordering::Relaxed)
    }

    /// Bytes handed out so far, whatever came back.
    #[allow(dead_code, reason = "every test asks for what it needs")]
    pub fn ever(&self) -> usize {
        self.ever.load(Ordering::Relaxed)
    }
}
