//! One version of an object, loaded from one version of a file.

use super::directory_snapshot::{DatabaseSource, FileStamp};
use crate::memory::{self, LoadGuard};
use crate::panics;
use shatter_engine::object::{Loader, ServedObject};
use shatter_proto::control::{ObjectRow, ObjectState};
use shatter_proto::name::object_name;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

/// One version of an object.
pub struct ObjectVersion {
    pub(super) object: Arc<dyn ServedObject>,
    pub(super) name: String,
    pub(super) source: DatabaseSource,
    pub(super) stamp: FileStamp,
    memory_bytes: u64,
    loaded: SystemTime,
    load_time: Duration,
}

/// Largest number of loads of a file that is replaced again and again while it is loaded.
const LOADS_MAX: usize = 3;

impl ObjectVersion {
    /// Loads `source`, and loads it again if its file was replaced meanwhile. `None` if the file is gone.
    pub(super) fn load_current(
        source: &DatabaseSource,
        mut stamp: FileStamp,
        loader: &Loader,
    ) -> Option<Result<Self, String>> {
        for _ in 0..LOADS_MAX {
            let version = Self::load(source, stamp, loader);
            let now = FileStamp::of(&source.path)?;
            if now == stamp {
                return Some(version);
            }
            stamp = now;
        }
        Some(Err(
            "its file was replaced each time that it was loaded; it is loaded again once the file stays".to_owned()
        ))
    }

    /// Loads `source`; the error names the defect. A panic of the loader becomes an error, so that no file brings the daemon down.
    fn load(source: &DatabaseSource, stamp: FileStamp, loader: &Loader) -> Result<Self, String> {
        let begun = Instant::now();
        let loading = LoadGuard::begin();
        let object = catch_unwind(AssertUnwindSafe(|| loader(&source.path, source.object.as_deref())))
            .unwrap_or_else(|panic| Err(format!("loading it failed: {}", panics::text(panic.as_ref()))))?;
        drop(loading);
        // Each thread that took part has a heap of its own.
        rayon::spawn_broadcast(|_| memory::release_free());
        let name = object.row().name();
        object_name(&name).map_err(|error| error.message)?;
        let version = Self {
            memory_bytes: object.bytes() as u64,
            object,
            name,
            source: source.clone(),
            stamp,
            loaded: SystemTime::now(),
            load_time: begun.elapsed(),
        };
        memory::release_free();
        version.log();
        Ok(version)
    }

    fn log(&self) {
        tracing::info!(
            object = self.name,
            path = %self.source.path.display(),
            file_bytes = self.stamp.bytes(),
            memory_bytes = self.memory_bytes,
            ms = self.load_time.as_millis() as u64,
            "database loaded"
        );
    }

    /// Does the work that loading deferred. Errors are logged, and returned to every request that needs this work.
    pub fn finish(&self) {
        let begun = Instant::now();
        let finished = catch_unwind(AssertUnwindSafe(|| self.object.finish()));
        memory::release_free();
        let object = self.name.as_str();
        match finished {
            Ok(Ok(())) => tracing::debug!(object, ms = begun.elapsed().as_millis() as u64, "finished"),
            Ok(Err(error)) => tracing::error!(object, %error, "some requests will fail"),
            Err(panic) => tracing::error!(object, why = panics::text(panic.as_ref()), "some requests will fail"),
        }
    }

    /// Duration of the load.
    pub(super) fn load_time(&self) -> Duration {
        self.load_time
    }

    /// Memory of the object, bytes.
    pub fn memory_bytes(&self) -> u64 {
        self.memory_bytes
    }

    /// Row for `list` and `status`; `generation` counts the versions of the name.
    pub(super) fn row(&self, generation: u32) -> ObjectRow {
        ObjectRow {
            state: ObjectState::Ready as u32,
            generation,
            memory_bytes: self.memory_bytes,
            file_bytes: self.stamp.bytes(),
            loaded_unix_ns: unix_ns(self.loaded),
            load_ns: u64::try_from(self.load_time.as_nanos()).unwrap_or(u64::MAX),
            ..self.object.row()
        }
    }
}

/// Nanoseconds since 1970; 0 before 1970.
pub fn unix_ns(time: SystemTime) -> u64 {
    let since = time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
}
