//! What a client process is told, and what it tells.

use super::tally::RequestRecord;
use serde::{Deserialize, Serialize};
use shatter_client::{Error, ErrorKind};
use std::path::Path;

/// An object and how it is struck.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadTarget {
    /// Its name.
    pub object: String,
    /// How often, beside the others.
    #[serde(default = "one")]
    pub weight: f64,
    /// Sites.
    #[serde(default = "twenty")]
    pub degree: u32,
}

fn one() -> f64 {
    1.0
}

fn twenty() -> u32 {
    super::DEGREE
}

/// What one client process does.
#[derive(Debug, Serialize, Deserialize)]
pub struct ClientPlan {
    /// What it strikes.
    pub targets: Vec<LoadTarget>,
    /// Strikes per second; `None`: one after the other.
    pub rate: Option<f64>,
    /// For how long, s.
    pub seconds: f64,
    /// Deadline of each strike.
    pub deadline_ms: Option<u64>,
    /// Schedule and impacts follow from it.
    pub seed: u64,
    /// When it begins.
    pub begin_unix_ns: u64,
}

/// What a client process says in the end.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClientReport {
    /// Every strike.
    Records(Vec<RequestRecord>),
    /// It could not begin.
    Refused {
        /// Name of the kind.
        kind: String,
        /// The offender.
        at: String,
        /// One sentence.
        message: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Mix {
    strike: Vec<LoadTarget>,
}

/// The targets of a mix file.
///
/// # Errors
/// `configuration`.
pub fn mix(file: &Path) -> Result<Vec<LoadTarget>, Error> {
    let at = file.display().to_string();
    let refuse = |why: String| Error::new(ErrorKind::Configuration, at.clone(), format!("{at}: {why}"));
    // Devices and pipes may never end.
    if !std::fs::metadata(file).map_err(|error| refuse(error.to_string()))?.is_file() {
        return Err(refuse("not a regular file".to_owned()));
    }
    let text = std::fs::read_to_string(file).map_err(|error| refuse(error.to_string()))?;
    parse(&text).map_err(refuse)
}

fn parse(text: &str) -> Result<Vec<LoadTarget>, String> {
    let Mix { strike } = toml::from_str(text).map_err(|error| error.to_string().trim_end().to_owned())?;
    let wrong = |target: &&LoadTarget| !(target.weight.is_finite() && target.weight > 0.0) || target.degree == 0;
    match strike.iter().find(wrong) {
        Some(target) => Err(format!("`{}`: weight must be above zero and degree at least 1", target.object)),
        None if strike.is_empty() => Err("no [[strike]]".to_owned()),
        None => Ok(strike),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mix_is_objects_with_weights_and_degrees() {
        let found =
            parse("[[strike]]\nobject = \"vase\"\nweight = 3\n[[strike]]\nobject = \"arch\"\ndegree = 60").unwrap();
        let target = |object: &str, weight, degree| LoadTarget { object: object.to_owned(), weight, degree };
        assert_eq!(found, [target("vase", 3.0, 20), target("arch", 1.0, 60)]);
        for wrong in
            ["", "strike = []", "[[strike]]\nobject = \"a\"\nweight = 0", "[[strike]]\nobject = \"a\"\nspeed = 1"]
        {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
