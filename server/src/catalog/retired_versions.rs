//! Replaced or removed versions, which live until their last request ends.

use super::Catalog;
use shatter_engine::object::ServedObject;
use std::sync::{Arc, Weak};

/// Versions that are no longer in the catalog but may still serve requests; held by weak references.
#[derive(Default)]
pub struct RetiredVersions(Vec<(Weak<dyn ServedObject>, u64)>);

impl RetiredVersions {
    /// Adds the versions of `old` that `new` lacks.
    pub fn note(&mut self, old: &Catalog, new: &Catalog) {
        self.0.retain(|(object, _)| object.strong_count() > 0);
        let kept = |object: &Arc<dyn ServedObject>| new.versions().any(|version| Arc::ptr_eq(&version.object, object));
        let removed = old.versions().filter(|version| !kept(&version.object));
        self.0.extend(removed.map(|version| (Arc::downgrade(&version.object), version.memory_bytes())));
    }

    /// Number of versions that still exist, and their memory in bytes.
    pub fn alive(&self) -> (u64, u64) {
        let alive = self.0.iter().filter(|(object, _)| object.strong_count() > 0);
        alive.fold((0, 0), |(count, bytes), (_, more)| (count + 1, bytes + more))
    }
}
