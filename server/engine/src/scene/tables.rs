//! Optional tables of a database.

use shatter_fracture::database::Tables;

/// Optional table of a database.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OptionalDatabaseTable {
    /// Name in a plan.
    pub name: &'static str,
    /// Whether the scene needs it.
    pub wanted: bool,
    /// Substrings that identify the names of its tensors.
    pub tensors: &'static [&'static str],
}

/// All optional tables, with flags for those in `wanted`.
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
