//! Pool of buffers of dropped results, for later requests.
//!
//! Results grow with the lattice. The page faults of a new allocation each time would cost a large part of
//! a millisecond.

use super::body_meshes::CutBuffers;
use std::sync::{Arc, Mutex};

/// Largest number of buffers kept; others are freed.
const KEPT_MAX: usize = 8;

/// A few sets of buffers, shared with the results that use them.
#[derive(Clone, Default)]
pub(in crate::pipeline) struct BufferPool(Arc<Mutex<Vec<CutBuffers>>>);

impl BufferPool {
    /// Takes unused buffers from the pool, with arbitrary contents, or new ones.
    pub fn take(&self) -> CutBuffers {
        let kept = self.0.lock().ok().and_then(|mut kept| kept.pop());
        kept.unwrap_or_default()
    }

    /// Returns buffers to the pool.
    pub fn give(&self, cut: CutBuffers) {
        if let Ok(mut kept) = self.0.lock()
            && kept.len() < KEPT_MAX
        {
            kept.push(cut);
        }
    }
}
