//! Plan and report of a client process, exchanged as JSON.

use super::tally::RequestRecord;
use serde::{Deserialize, Serialize};
use shatter_client::{Error, ErrorKind};
use shatter_fracture::pipeline::DEGREE_MAX;
use shatter_fracture::scene::toml_error;
use std::ops::RangeInclusive;
use std::path::Path;

/// Target of requests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadTarget {
    /// Name of the object.
    pub object: String,
    /// Relative frequency.
    #[serde(default = "one")]
    pub weight: f64,
    /// Number of sites.
    #[serde(default = "twenty")]
    pub degree: u32,
}

fn one() -> f64 {
    1.0
}

fn twenty() -> u32 {
    super::DEGREE
}

/// Plan of one client process.
#[derive(Debug, Serialize, Deserialize)]
pub struct ClientPlan {
    /// Targets.
    pub targets: Vec<LoadTarget>,
    /// Requests per second; `None`: closed loop.
    pub rate: Option<f64>,
    /// Duration, s.
    pub seconds: f64,
    /// Deadline of each request, ms.
    pub deadline_ms: Option<u64>,
    /// Seed of schedule and impacts.
    pub seed: u64,
    /// Start time, ns since 1970.
    pub begin_unix_ns: u64,
}

/// Report of a client process.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClientReport {
    /// Records of all requests.
    Records(Vec<RequestRecord>),
    /// The client could not begin.
    Refused {
        /// Name of the error kind.
        kind: String,
        /// Offending input.
        at: String,
        /// Message in one sentence.
        message: String,
    },
}

/// Possible weights; their sum is finite, and adding the smallest to the largest changes it.
const WEIGHTS: RangeInclusive<f64> = 1e-6..=1e6;

/// Possible values of the keys of a mix file, in words.
const RANGES: [(&str, &str); 3] = [
    ("object", "the name of an object, in quotes"),
    ("weight", "a number from 1e-6 to 1e6"),
    ("degree", "a whole number from 1 to 512"),
];

/// Error for a mix file without targets.
const EMPTY: &str = "has no targets; add a table [[strike]] for each object, with the key `object`, and optionally `weight` (1 without it) \
                     and `degree` (20 without it)";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Mix {
    #[serde(default)]
    strike: Vec<LoadTarget>,
}

/// Reads the targets of a mix file.
///
/// # Errors
/// `configuration`.
pub fn mix(file: &Path) -> Result<Vec<LoadTarget>, Error> {
    let at = file.display().to_string();
    let refuse = |why: String| Error::new(ErrorKind::Configuration, at.clone(), format!("{at}: {why}"));
    // Reads of devices and pipes may never end.
    if !std::fs::metadata(file).map_err(|error| refuse(error.to_string()))?.is_file() {
        return Err(refuse("not a regular file".to_owned()));
    }
    let text = std::fs::read_to_string(file).map_err(|error| refuse(error.to_string()))?;
    parse(&text).map_err(refuse)
}

fn parse(text: &str) -> Result<Vec<LoadTarget>, String> {
    let Mix { strike } = toml::from_str(text).map_err(|error| toml_error(text, &error, &RANGES))?;
    let wrong = |target: &&LoadTarget| !WEIGHTS.contains(&target.weight) || !(1..=DEGREE_MAX).contains(&target.degree);
    match strike.iter().find(wrong) {
        Some(target) => {
            let [low, high] = [WEIGHTS.start(), WEIGHTS.end()];
            Err(format!(
                "`{}`: weight must be from {low:e} to {high:e}, and degree from 1 to {DEGREE_MAX}",
                target.object
            ))
        }
        None if strike.is_empty() => Err(EMPTY.to_owned()),
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
        for wrong in [
            "",
            "strike = []",
            "[[strike]]\nobject = \"a\"\nweight = 0",
            "[[strike]]\nobject = \"a\"\nweight = 1e308",
            "[[strike]]\nobject = \"a\"\ndegree = 513",
            "[[strike]]\nobject = \"a\"\nspeed = 1",
        ] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        let empty = "has no targets; add a table [[strike]] for each object, with the key `object`, and optionally `weight` (1 without it) \
                     and `degree` (20 without it)";
        for text in ["", "# nothing", "strike = []"] {
            assert_eq!(parse(text).unwrap_err(), empty);
        }
        let huge = "[[strike]]\nobject = \"a\"\ndegree = 9223372036854775808";
        assert_eq!(
            parse(huge).unwrap_err(),
            "line 3, column 10: `degree` is 9223372036854775808; it must be a whole number from 1 to 512"
        );
    }
}
