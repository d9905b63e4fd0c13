//! Configuration of the daemon: compiled-in defaults, overridden by a file, overridden by flags.

use serde::Deserialize;
use shatter_fracture::scene::{brief, table_error, toml_error};
use shatter_proto::name::nearest;
use shatter_proto::text::number;
use shatter_proto::{Error, ErrorKind};
use shatter_transport::CLIENTS_MAX;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Default configuration file, which documents every key.
pub const DEFAULT: &str = include_str!("../shatterd.toml");

/// Possible values of the numbers, by key.
const RANGES: [(&str, &str); 18] = [
    ("service.clients_max", "a whole number from 1 to 128"),
    ("databases.watch_ms", "0, or a whole number from 10 to 60000"),
    ("compute.threads", "a whole number from 0 to 1024"),
    ("compute.requests_at_once", "a whole number from 0 to 1024"),
    ("compute.nice", "a whole number from 0 to 19"),
    ("compute.queue_max", "a whole number from 1 to 4096"),
    ("results.buckets", "a whole number from 1 to 1024"),
    ("results.held_max", "a whole number from 0 to `results.buckets`"),
    ("results.kept_max", "a whole number from 0 to 4096"),
    ("results.bucket_mib_max", "a whole number from 1 to 4096"),
    ("results.prefault_buckets", "a whole number from 0 to 16"),
    ("results.prefault_mib", "a whole number from 0 to 1024"),
    ("times.tick_ms", "a whole number from 1 to 1000"),
    ("times.cleanup_ms", "a whole number from 10 to 60000"),
    ("times.kept_s", "a number from 0.01 to 86400"),
    ("times.metrics_s", "a whole number from 1 to 3600"),
    ("times.drain_s", "a number from 0 to 3600"),
    ("operations.port", "a whole number from 0 to 65535"),
];

const _: () = assert!(CLIENTS_MAX == 128);

/// Configuration of the daemon. `config/shatterd.toml` documents the keys.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "the compiled-in file documents every key")]
pub struct Config {
    pub service: ServiceConfig,
    pub databases: DatabasesConfig,
    pub compute: ComputeConfig,
    pub results: ResultsConfig,
    pub times: TimesConfig,
    pub operations: OperationsConfig,
    pub log: LogConfig,
}

/// `[service]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "see Config")]
pub struct ServiceConfig {
    pub name: String,
    pub clients_max: usize,
}

/// `[databases]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "see Config")]
pub struct DatabasesConfig {
    pub folder: PathBuf,
    pub watch_ms: u64,
}

/// `[compute]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "see Config")]
pub struct ComputeConfig {
    pub threads: usize,
    pub requests_at_once: usize,
    pub nice: i32,
    pub queue_max: usize,
}

/// `[results]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "see Config")]
pub struct ResultsConfig {
    pub buckets: usize,
    pub held_max: usize,
    pub kept_max: usize,
    pub bucket_mib_max: usize,
    pub prefault_buckets: usize,
    pub prefault_mib: usize,
}

/// `[times]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "see Config")]
pub struct TimesConfig {
    pub tick_ms: u64,
    pub cleanup_ms: u64,
    pub kept_s: f64,
    pub metrics_s: u64,
    pub drain_s: f64,
}

/// `[operations]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "see Config")]
pub struct OperationsConfig {
    pub port: u16,
}

/// `[log]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(missing_docs, reason = "see Config")]
pub struct LogConfig {
    pub filter: String,
    pub format: LogFormat,
}

/// Format of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// Plain text for people.
    Text,
    /// One JSON object per line.
    Json,
}

impl Config {
    /// Loads the defaults, overridden by the file at `path` if there is one.
    ///
    /// # Errors
    /// `configuration`: a file that cannot be read, and those of [`Self::parse`].
    pub fn load(path: Option<&Path>) -> Result<Self, Error> {
        let Some(path) = path else { return Self::parse("", "default") };
        let at = path.display().to_string();
        let text = shatter_engine::scene::read_text(path)
            .map_err(|error| Error::new(ErrorKind::Configuration, at.clone(), format!("cannot read {at}: {error}")))?;
        Self::parse(&text, &at)
    }

    /// Parses `text` over the defaults; `at` names the source of `text` in errors.
    ///
    /// # Errors
    /// `configuration` at the key that is unknown or whose value cannot be used.
    pub fn parse(text: &str, at: &str) -> Result<Self, Error> {
        let refuse = |text: &str, error: toml::de::Error| {
            Error::new(ErrorKind::Configuration, at, format!("{at}: {}", toml_error(text, &error, &RANGES)))
        };
        let placed = |(key, why): (String, String)| Error::new(ErrorKind::Configuration, key, format!("{at}: {why}"));
        let mut table: toml::Table = DEFAULT.parse().map_err(|error| refuse(DEFAULT, error))?;
        let own: toml::Table = text.parse().map_err(|error| refuse(text, error))?;
        known("", &own, &table).map_err(placed)?;
        overlay(&mut table, own);
        let config = toml::Value::Table(table).try_into();
        let config: Self = config.map_err(|error| placed(table_error("", &error, &RANGES)))?;
        config.checked(at)
    }

    /// Returns the configuration if every value is valid; `at` names the source of the values in errors.
    ///
    /// # Errors
    /// `configuration` at the first key whose value is not possible.
    pub fn checked(self, at: &str) -> Result<Self, Error> {
        let values = self.values();
        match RANGES.iter().zip(values).find(|(_, (_, is_possible))| !is_possible) {
            None => Ok(self),
            Some(((key, range), (value, _))) => {
                let message = format!("{at}: `{key}` is {value}; it must be {range}");
                Err(Error::new(ErrorKind::Configuration, *key, message))
            }
        }
    }

    /// The values with a range, in the order of [`RANGES`], and whether each is possible.
    fn values(&self) -> [(String, bool); RANGES.len()] {
        let Self { service, databases, compute, results, times, operations, .. } = self;
        [
            (service.clients_max.to_string(), (1..=CLIENTS_MAX).contains(&service.clients_max)),
            (databases.watch_ms.to_string(), matches!(databases.watch_ms, 0 | 10..=60_000)),
            (compute.threads.to_string(), compute.threads <= 1024),
            (compute.requests_at_once.to_string(), compute.requests_at_once <= 1024),
            (compute.nice.to_string(), (0..=19).contains(&compute.nice)),
            (compute.queue_max.to_string(), (1..=4096).contains(&compute.queue_max)),
            (results.buckets.to_string(), (1..=1024).contains(&results.buckets)),
            (results.held_max.to_string(), results.held_max <= results.buckets),
            (results.kept_max.to_string(), results.kept_max <= 4096),
            (results.bucket_mib_max.to_string(), (1..=4096).contains(&results.bucket_mib_max)),
            (results.prefault_buckets.to_string(), results.prefault_buckets <= 16),
            (results.prefault_mib.to_string(), results.prefault_mib <= 1024),
            (times.tick_ms.to_string(), (1..=1000).contains(&times.tick_ms)),
            (times.cleanup_ms.to_string(), (10..=60_000).contains(&times.cleanup_ms)),
            (number(times.kept_s), (0.01..=86_400.0).contains(&times.kept_s)),
            (times.metrics_s.to_string(), (1..=3600).contains(&times.metrics_s)),
            (number(times.drain_s), (0.0..=3600.0).contains(&times.drain_s)),
            (operations.port.to_string(), true),
        ]
    }

    /// Number of worker threads, at least 1.
    pub fn threads(&self) -> usize {
        match self.compute.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            threads => threads,
        }
    }

    /// Number of requests that compute at once, at least 1.
    pub fn requests_at_once(&self) -> usize {
        match self.compute.requests_at_once {
            0 => self.threads(),
            strikes => strikes,
        }
    }

    /// Number of buckets that one client may hold, at least 1.
    pub fn held_max(&self) -> usize {
        match self.results.held_max {
            0 => (self.results.buckets / 2).max(1),
            most => most,
        }
    }

    /// Longest wait of the event loop.
    pub fn tick(&self) -> Duration {
        Duration::from_millis(self.times.tick_ms)
    }

    /// Time that an ending daemon grants to requests that it has accepted.
    pub fn drain(&self) -> Duration {
        Duration::from_secs_f64(self.times.drain_s)
    }

    /// Time for which a retained result stays available unless a client releases it.
    pub fn kept(&self) -> Duration {
        Duration::from_secs_f64(self.times.kept_s)
    }

    /// Pause between two scans of the database folder; `None`: the folder is not scanned.
    pub fn watch(&self) -> Option<Duration> {
        (self.databases.watch_ms > 0).then(|| Duration::from_millis(self.databases.watch_ms))
    }

    /// Folder of the databases: the configured one, or the platform's default.
    ///
    /// # Errors
    /// `configuration` without a configured folder and a home folder.
    pub fn databases(&self) -> Result<PathBuf, Error> {
        if self.databases.folder.as_os_str().is_empty() { data_folder() } else { Ok(self.databases.folder.clone()) }
    }
}

/// The platform's folder for databases (`~/.local/share/shatter` on Linux).
///
/// # Errors
/// `configuration` without a home folder.
pub fn data_folder() -> Result<PathBuf, Error> {
    let folders = directories::ProjectDirs::from("", "", "shatter");
    folders.map(|folders| folders.data_dir().to_owned()).ok_or_else(|| {
        let message = "no home folder, so no default folder for databases; name one with --databases DIR";
        Error::new(ErrorKind::DatabaseFolder, "databases.folder", message)
    })
}

/// Checks that every key of `own` is in `all`; the error holds the path of the first unknown key and the nearest known key.
fn known(path: &str, own: &toml::Table, all: &toml::Table) -> Result<(), (String, String)> {
    for (key, value) in own {
        let name = format!("{path}{}", brief(key));
        match (value, all.get(key)) {
            (_, None) => {
                return Err((name.clone(), format!("unknown key `{name}`; {}", hint(path, key, value, all))));
            }
            (toml::Value::Table(own), Some(toml::Value::Table(all))) => known(&format!("{name}."), own, all)?,
            _ => {}
        }
    }
    Ok(())
}

/// Suggestion for the unknown `key` of the table `path`: the same key of a table in `all`, a key like those of its `value` if it is a
/// table, or the names in `all`.
fn hint(path: &str, key: &str, value: &toml::Value, all: &toml::Table) -> String {
    let holds = |table: &toml::Value| table.as_table().is_some_and(|table| table.contains_key(key));
    match all.iter().find(|(_, table)| holds(table)) {
        Some((table, _)) => format!("did you mean `{path}{table}.{key}`, the key `{key}` of the table `[{table}]`?"),
        None => {
            let keys: Vec<&str> = all.keys().map(String::as_str).collect();
            let shown = |own: &&str| match all.get(*own) {
                Some(toml::Value::Table(_)) => format!("`[{path}{own}]`"),
                _ => format!("`{path}{own}`"),
            };
            let listed = |names: &[&str]| names.iter().map(shown).collect::<Vec<_>>().join(", ");
            match nearest(key, &keys).as_slice() {
                [] => moved(value, all).unwrap_or_else(|| format!("there are {}", listed(&keys))),
                likely => format!("did you mean {}?", listed(likely)),
            }
        }
    }
}

/// Suggestion for an unknown table: the key of a known table that is most like one of its keys.
fn moved(value: &toml::Value, all: &toml::Table) -> Option<String> {
    let tables = || all.iter().filter_map(|(name, table)| Some((name, table.as_table()?)));
    value.as_table()?.keys().find_map(|key| {
        tables().find_map(|(name, table)| {
            let known: Vec<&str> = table.keys().map(String::as_str).collect();
            let likely = nearest(key, &known).first().copied()?;
            Some(format!("did you mean `{likely}` of the table `[{name}]`?"))
        })
    })
}

/// Merges `over` into `under`, table by table.
fn overlay(under: &mut toml::Table, over: toml::Table) {
    for (key, value) in over {
        match (under.get_mut(&key), value) {
            (Some(toml::Value::Table(under)), toml::Value::Table(over)) => overlay(under, over),
            (_, value) => {
                under.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_stands_alone() {
        let config = Config::parse("", "default").unwrap();
        assert_eq!((config.service.name.as_str(), config.log.format), ("default", LogFormat::Text));
        assert!(config.threads() >= 1 && config.requests_at_once() >= 1 && config.watch().is_some());
        assert_eq!(Config::parse("[databases]\nwatch_ms = 0", "file").unwrap().watch(), None);
    }

    #[test]
    fn a_file_changes_only_what_it_holds() {
        let config = Config::parse("[compute]\nthreads = 3\n[log]\nformat = \"json\"", "file").unwrap();
        assert_eq!((config.threads(), config.requests_at_once(), config.compute.queue_max), (3, 3, 256));
        assert_eq!(config.log.format, LogFormat::Json);
    }

    fn check(text: &str, named: &str) {
        let error = Config::parse(text, "file").unwrap_err();
        assert_eq!(error.kind, ErrorKind::Configuration);
        assert!(error.message.contains(named) && error.message.contains("file"), "{error}");
    }

    #[test]
    fn unknown_keys_and_bad_values_are_refused_by_name() {
        check("[compute]\ntreads = 3", "treads");
        check("[compute]\ntreads = 3", "`compute.threads`");
        check("[results]\nheld = 3", "`results.held_max`");
        check("[foo]\nx = 1", "unknown key `foo`; there are `[compute]`, ");
        check("[color]\nx = 1", "unknown key `color`; there are `[compute]`, ");
        check("[jobs]\nthread = 4", "did you mean `threads` of the table `[compute]`?");
        check("port = 1", "did you mean `operations.port`");
        check("[times]\nthreads = 1", "there are `times.");
        check("[results]\nbuckets = 0", "results.buckets");
        check("[service]\nclients_max = 129", "service.clients_max");
        check("[databases]\nwatch_ms = 3", "databases.watch_ms");
        check("[times]\ntick_ms = -1", "-1");
        check("[times]\ndrain_s = nan", "times.drain_s");
        check("[times]\nkept_s = 0", "kept_s");
        check("[results]\nkept_max = 5000", "results.kept_max");
        check("[operations]\nport = 70000", "70000");
        check("[log]\nformat = \"xml\"", "xml");
        check("[log", "line 1, column 5");
    }

    #[test]
    fn a_value_out_of_range_is_refused_with_key_value_and_range() {
        check("[operations]\nport = 80000", "`operations.port` is 80000; it must be a whole number from 0 to 65535");
        check("[compute]\nthreads = 2.5", "`compute.threads` is 2.5; it must be a whole number from 0 to 1024");
        check("service = 3", "`service` is 3; it must be a table");
        for value in ["9223372036854775808", "18446744073709551616"] {
            let wanted =
                format!("line 2, column 15: `clients_max` is {value}; it must be a whole number from 1 to 128");
            check(&format!("[service]\nclients_max = {value}"), &wanted);
        }
        for value in ["1e300", "-1e300", "1e-300"] {
            let range = "a number from 0.01 to 86400";
            check(&format!("[times]\nkept_s = {value}"), &format!("`times.kept_s` is {value}; it must be {range}"));
        }
        check("[times]\ndrain_s = 1e300", "`times.drain_s` is 1e300; it must be a number from 0 to 3600");
        check("[times]\ntick_ms = 1e300", "`times.tick_ms` is 1e300; it must be a whole number from 1 to 1000");
        // Each value is checked against the range of its own key.
        for (key, range) in RANGES {
            let (table, name) = key.split_once('.').unwrap();
            let value = if range.starts_with("a number") { "-0.5" } else { "70000" };
            check(&format!("[{table}]\n{name} = {value}"), &format!("`{key}` is {value}; it must be {range}"));
        }
    }
}
