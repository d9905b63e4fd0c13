//! Population of shared-memory pages before results are written into them, once per bucket.
//!
//! See [`shared_memory`](super::shared_memory) for the symptom and for what to delete.

use super::shared_memory::{need, populate};
use shatter_proto::Error;
use shatter_proto::result::AlignedBlock;
use std::collections::HashMap;
use std::mem::MaybeUninit;
use std::sync::{Mutex, PoisonError};

/// Shared memory that results leave free for new clients and for the transport, bytes.
const RESERVE: u64 = 8 * 1024 * 1024;

/// Populated length of each bucket, by address. Populating pages again costs milliseconds.
#[derive(Default)]
pub struct PopulatedPages(Mutex<HashMap<usize, usize>>);

impl PopulatedPages {
    /// Populates the pages of `range`.
    ///
    /// # Errors
    /// `shared_memory`.
    pub fn ensure(&self, range: &mut [MaybeUninit<AlignedBlock>]) -> Result<(), Error> {
        let (start, length) = (range.as_mut_ptr() as usize, size_of_val(range));
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&start).copied().unwrap_or(0);
        if known >= length {
            return Ok(());
        }
        need((length - known) as u64 + RESERVE)?;
        populate(start + known..start + length)?;
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(start, length);
        Ok(())
    }

    /// Number of buckets that were ever populated, and their populated bytes.
    ///
    /// The transport reuses the bucket that was returned last, so the number is the maximum that was held at once.
    pub fn extent(&self) -> (u64, u64) {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        (known.len() as u64, known.values().map(|length| *length as u64).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::ErrorKind;

    #[test]
    fn populating_changes_no_byte_and_is_done_once() {
        let mut blocks = vec![MaybeUninit::new(AlignedBlock { bytes: [7; 64] }); 4096];
        let populated = PopulatedPages::default();
        let address = blocks.as_ptr() as usize;
        for (count, known) in [(1000, 1000), (10, 1000), (4096, 4096)] {
            populated.ensure(&mut blocks[..count]).unwrap();
            assert_eq!(populated.0.lock().unwrap()[&address], known * 64);
            assert_eq!(populated.extent(), (1, known as u64 * 64));
        }
        // SAFETY: all blocks were initialized above.
        assert!(blocks.iter().all(|block| unsafe { block.assume_init_ref() }.bytes == [7; 64]));
    }

    #[test]
    fn memory_that_cannot_exist_is_an_error_not_a_signal() {
        // In a mapping of an empty file every access raises SIGBUS; populating it returns an error instead.
        let file = tempfile::tempfile().unwrap();
        let length = 16 * rustix::param::page_size();
        // SAFETY: a fresh mapping at an address of the kernel's choice; it is unmapped below and never read or written.
        let mapped = unsafe {
            let (read_write, shared) = (rustix::mm::ProtFlags::WRITE, rustix::mm::MapFlags::SHARED);
            rustix::mm::mmap(std::ptr::null_mut(), length, read_write, shared, &file, 0).unwrap()
        };
        // SAFETY: the elements are `MaybeUninit` and never accessed; the mapping outlives the slice.
        let range = unsafe { std::slice::from_raw_parts_mut(mapped.cast::<MaybeUninit<AlignedBlock>>(), length / 64) };
        let error = PopulatedPages::default().ensure(range).unwrap_err();
        assert_eq!(error.kind, ErrorKind::Transport);
        // SAFETY: the whole mapping, which nothing refers to any more.
        unsafe { rustix::mm::munmap(mapped, length).unwrap() };
    }
}
