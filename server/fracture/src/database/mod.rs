//! Databases of prepared objects: one object per file, baked once, verified at loading.

#[cfg(test)]
mod altered_links_tests;
#[cfg(test)]
mod altered_tests;
mod bake;
mod bake_error;
mod bake_request;
mod bake_step;
mod cells;
mod container;
mod cracks;
mod cutting;
mod elastic_values;
mod error;
mod hash;
#[cfg(test)]
mod hostile_tests;
mod joints;
mod lattice_tensors;
mod learned;
mod lost_parts;
mod object;
mod object_name;
mod reduced;
mod share;
mod sheet;
mod skin_values;
mod skins;
mod stored;
mod stored_values;
mod stuffed;
mod tables;
mod thin;
mod wall_limits;

pub use bake::bake;
pub use bake_error::BakeError;
pub use bake_request::BakeRequest;
pub use bake_step::{BakeSize, BakeStep};
pub use error::DatabaseError;
pub use hash::input_hash;
pub use joints::{JoinRemedy, Joint};
pub use lattice_tensors::NODES_MAX;
pub use learned::EXAMPLES_MAX;
pub use lost_parts::SeveredParts;
pub use object::{
    BODIES_MAX, Provenance, load, load_input_hash, load_parameters, load_partial, load_provenance, load_tables,
    load_task, save, save_partial, tensor_bytes,
};
pub use object_name::NAME_BYTES_MAX;
pub use share::{BakeShare, JoinError, PartialBake, SHARE_EXTENSION, SHARES_MAX, ShareError, ShareTask, join};
pub use stored::{lacking, stored};
pub use tables::Tables;
pub use wall_limits::HALF_SPACING_COST;

/// Version of the file format that this program writes and reads; an integer, incremented by every incompatible change.
pub const FORMAT: &str = "1";

/// Extension of database files.
pub const EXTENSION: &str = "shatter";
