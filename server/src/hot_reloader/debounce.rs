//! Detection that a changed folder is stable.

use crate::catalog::DirectorySnapshot;

/// Number of scans after which a folder that keeps changing is reloaded anyway.
const UNSTABLE_SCANS_MAX: u32 = 10;

/// Debouncer of folder changes.
#[derive(Default)]
pub struct Debounce {
    last: Option<DirectorySnapshot>,
    scan_count: u32,
}

impl Debounce {
    /// Notes how the folder looks during a load: if it still looks like that after the load, it is stable.
    pub fn wait(&mut self, seen: DirectorySnapshot) {
        *self = Self { last: Some(seen), scan_count: 0 };
    }

    /// Whether to reload a folder that looks like `seen` while `served` is served.
    pub fn settled(&mut self, seen: DirectorySnapshot, served: &DirectorySnapshot) -> bool {
        if seen == *served {
            *self = Self::default();
            return false;
        }
        self.scan_count += 1;
        if self.last.as_ref() == Some(&seen) || self.scan_count >= UNSTABLE_SCANS_MAX {
            *self = Self::default();
            return true;
        }
        self.last = Some(seen);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    fn snapshot(folder: &TempDir, text: &str) -> DirectorySnapshot {
        std::fs::write(folder.path().join("a.shatter"), text).unwrap();
        DirectorySnapshot::of(folder.path()).unwrap()
    }

    #[test]
    fn a_folder_is_reloaded_when_stable_or_after_a_limit() {
        let folder = tempfile::tempdir().unwrap();
        let [served, one, two] = ["", "1", "22"].map(|text| snapshot(&folder, text));
        let mut debounce = Debounce::default();
        let mut scan = |seen: &DirectorySnapshot| debounce.settled(seen.clone(), &served);
        assert!(!scan(&served) && !scan(&one) && !scan(&two) && scan(&two), "twice the same");
        assert!(!scan(&one) && !scan(&served) && !scan(&one), "an undone change is forgotten");
        let unstable: Vec<bool> =
            (0..UNSTABLE_SCANS_MAX).map(|turn| scan(if turn % 2 == 0 { &two } else { &one })).collect();
        assert_eq!(unstable.iter().filter(|read| **read).count(), 1, "{unstable:?}");
    }
}
