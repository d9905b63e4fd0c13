//! Removal of the service's runtime folder after the demonstration.

use shatter_client::{Error, service_paths};
use shatter_server::ipc::RuntimeDirectory;
use std::fs;

/// Guard that removes the runtime folder of a service when dropped, unless the folder existed before. Drop it after the daemon.
pub(super) struct RuntimeFolder {
    service: String,
    was_there: bool,
}

impl RuntimeFolder {
    /// Creates the guard for `service`, before its daemon starts.
    ///
    /// # Errors
    /// `service_name`, `runtime_folder`.
    pub fn of(service: &str) -> Result<Self, Error> {
        let was_there = service_paths(service)?.exists()?;
        Ok(Self { service: service.to_owned(), was_there })
    }
}

impl Drop for RuntimeFolder {
    fn drop(&mut self) {
        if self.was_there {
            return;
        }
        let Ok(paths) = service_paths(&self.service) else { return };
        // Taking the service name removes files of a killed daemon from shared memory; their list is in the folder. A running daemon keeps
        // the name and its folder.
        if RuntimeDirectory::take(&paths).and_then(RuntimeDirectory::close).is_ok() {
            // A folder that cannot be removed is small and harmless.
            let _ = fs::remove_dir_all(&paths.folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_created_runtime_folder_is_removed() {
        let service = format!("demo-test-{}", std::process::id());
        let paths = service_paths(&service).unwrap();
        let new = RuntimeFolder::of(&service).unwrap();
        let killed = RuntimeDirectory::take(&paths).unwrap();
        let segments = killed.instance().folder.clone();
        drop(killed);
        assert!(segments.exists() && paths.folder.exists());
        drop(RuntimeFolder::of(&service).unwrap());
        assert!(segments.exists() && paths.folder.exists());
        drop(new);
        assert!(!segments.exists() && !paths.folder.exists());
    }
}
