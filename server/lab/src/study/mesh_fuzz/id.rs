//! Names of mutants.

use super::{FuzzDefect, UnknownDefect};
use serde::{Serialize, Serializer};
use std::fmt;
use std::num::ParseIntError;
use std::str::FromStr;

/// Mutant: a base mesh, a defect, and the seed of the defect's strength, place and number.
///
/// Printed and parsed as `mesh/defect/seed`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mutant {
    /// Name of the base mesh.
    pub mesh: String,
    /// Defect.
    pub defect: FuzzDefect,
    /// Seed of all random choices.
    pub seed: u64,
}

/// Invalid name of a mutant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MutantIdError {
    /// The name does not have three parts.
    #[error("'{0}' is not mesh/defect/seed")]
    Parts(String),
    /// The second part is not the name of a defect.
    #[error(transparent)]
    Defect(#[from] UnknownDefect),
    /// The third part is not a number.
    #[error("seed: {0}")]
    Seed(#[from] ParseIntError),
}

impl fmt::Display for Mutant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.mesh, self.defect, self.seed)
    }
}

impl FromStr for Mutant {
    type Err = MutantIdError;

    fn from_str(id: &str) -> Result<Self, MutantIdError> {
        let parts: Vec<&str> = id.split('/').collect();
        match parts[..] {
            [mesh, defect, seed] if !mesh.is_empty() => {
                Ok(Self { mesh: mesh.to_owned(), defect: defect.parse()?, seed: seed.parse()? })
            }
            _ => Err(MutantIdError::Parts(id.to_owned())),
        }
    }
}

impl Serialize for Mutant {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mutant_is_its_name() {
        for (seed, &defect) in FuzzDefect::ALL.iter().enumerate() {
            let mutant = Mutant { mesh: "stanford-bunny".to_owned(), defect, seed: seed as u64 };
            assert_eq!(mutant.to_string().parse(), Ok(mutant));
        }
        assert_eq!("horse/small_holes/7".parse::<Mutant>().unwrap().to_string(), "horse/small_holes/7");
    }

    #[test]
    fn other_words_are_refused() {
        let refused = |id: &str| id.parse::<Mutant>().unwrap_err();
        assert!(matches!(refused("horse/small_holes"), MutantIdError::Parts(_)));
        assert!(matches!(refused("/small_holes/1"), MutantIdError::Parts(_)));
        assert!(matches!(refused("horse/small_holes/1/2"), MutantIdError::Parts(_)));
        assert!(matches!(refused("horse/hole/1"), MutantIdError::Defect(_)));
        assert!(matches!(refused("horse/small_holes/-1"), MutantIdError::Seed(_)));
    }
}
