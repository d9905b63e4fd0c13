//! The tables of a database, and which of them are wanted.

use shatter_fracture::database::Tables;

/// A table of a database that objects can do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OptionalDatabaseTable {
    /// What it is called in a plan.
    pub name: &'static str,
    /// Whether it is wanted.
    pub wanted: bool,
    /// Names of its tensors contain one of these.
    pub tensors: &'static [&'static str],
}

/// All tables, and which of them are wanted.
pub fn tables(wanted: Tables) -> [OptionalDatabaseTable; 6] {
    [
        OptionalDatabaseTable {
            name: "elastic",
            wanted: wanted.elastic,
            tensors: &[".elastic.", ".transfer.", "reduced"],
        },
        OptionalDatabaseTable { name: "interior", wanted: wanted.interior, tensors: &[".interior"] },
        OptionalDatabaseTable {
            name: "surface_diffusion",
            wanted: wanted.surface_diffusion,
            tensors: &[".surface_diffusion"],
        },
        OptionalDatabaseTable { name: "examples", wanted: wanted.examples, tensors: &["examples.", "network."] },
        OptionalDatabaseTable { name: "attributes", wanted: wanted.attributes, tensors: &[".outer."] },
        OptionalDatabaseTable { name: "skin", wanted: wanted.skin, tensors: &["skin."] },
    ]
}
