//! Objects that many tests of one binary need, each in a copy of its own.

use shatter_fracture::database::{load, save};
use shatter_fracture::pipeline::PreparedObject;
use std::sync::OnceLock;

/// An object that is baked at the first use. Every use reads its database.
pub struct BakedOnce {
    bake: fn() -> PreparedObject,
    database: OnceLock<Vec<u8>>,
}

impl BakedOnce {
    /// An object that `bake` makes.
    pub const fn new(bake: fn() -> PreparedObject) -> Self {
        Self { bake, database: OnceLock::new() }
    }

    /// A copy of the object.
    ///
    /// # Panics
    /// If the object cannot be saved or loaded.
    pub fn load(&self) -> PreparedObject {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("once.shatter");
        let database = self.database.get_or_init(|| {
            save(&(self.bake)(), &path).unwrap();
            std::fs::read(&path).unwrap()
        });
        std::fs::write(&path, database).unwrap();
        load(&path).unwrap()
    }
}
