//! Memory of answers that were given, for those to come: what a strike makes grows with the lattice, and asking the system for it
//! anew each time costs a good part of a millisecond in pages alone.

use super::body_meshes::CutBuffers;
use std::sync::{Arc, Mutex};

/// Most that are kept; the rest goes back to the system.
const KEPT_MAX: usize = 8;

/// A few sets of buffers, shared with the answers that use them now.
#[derive(Clone, Default)]
pub(in crate::pipeline) struct BufferPool(Arc<Mutex<Vec<CutBuffers>>>);

impl BufferPool {
    /// One that nobody uses, or a new one; what is in it is of no meaning.
    pub fn take(&self) -> CutBuffers {
        let kept = self.0.lock().ok().and_then(|mut kept| kept.pop());
        kept.unwrap_or_default()
    }

    /// Takes one back.
    pub fn give(&self, cut: CutBuffers) {
        if let Ok(mut kept) = self.0.lock()
            && kept.len() < KEPT_MAX
        {
            kept.push(cut);
        }
    }
}
