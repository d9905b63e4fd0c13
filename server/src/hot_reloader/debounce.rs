//! Detection that a changed folder is stable.

use crate::catalog::DirectorySnapshot;

/// Number of scans after which a folder that keeps changing is reloaded anyway.
const RESTLESS_MAX: u32 = 10;

/// Debouncer of folder changes.
#[derive(Default)]
pub struct Debounce {
    last: Option<DirectorySnapshot>,
    looks: u32,
}

impl Debounce {
    /// Whether to reload a folder that looks like `seen` while `served` is served.
    pub fn settled(&mut self, seen: DirectorySnapshot, served: &DirectorySnapshot) -> bool {
        if seen == *served {
            *self = Self::default();
            return false;
        }
        self.looks += 1;
        if self.last.as_ref() == Some(&seen) || self.looks >= RESTLESS_MAX {
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

    fn shelf(folder: &TempDir, text: &str) -> DirectorySnapshot {
        std::fs::write(folder.path().join("a.shatter"), text).unwrap();
        DirectorySnapshot::of(folder.path()).unwrap()
    }

    #[test]
    fn a_folder_is_read_when_it_rests_and_in_any_case_at_last() {
        let folder = tempfile::tempdir().unwrap();
        let [served, one, two] = ["", "1", "22"].map(|text| shelf(&folder, text));
        let mut unrest = Debounce::default();
        let mut look = |seen: &DirectorySnapshot| unrest.settled(seen.clone(), &served);
        assert!(!look(&served) && !look(&one) && !look(&two) && look(&two), "twice the same");
        assert!(!look(&one) && !look(&served) && !look(&one), "an undone change is forgotten");
        let restless: Vec<bool> = (0..RESTLESS_MAX).map(|turn| look(if turn % 2 == 0 { &two } else { &one })).collect();
        assert_eq!(restless.iter().filter(|read| **read).count(), 1, "{restless:?}");
    }
}
