//! Databases of a starting daemon.

use crate::catalog::Catalog;
use crate::config::Config;
use crate::hot_reloader::DatabaseFolder;
use crate::jobs::threads;
use crate::memory::ResidentMemory;
use rayon::ThreadPool;
use shatter_engine::object::Loader;
use shatter_proto::Error;
use std::collections::BTreeMap;
use std::time::Instant;

/// Databases at start-up, with their loader and the worker threads.
pub(crate) struct LoadedDatabases {
    pub folder: DatabaseFolder,
    pub loader: Loader,
    pub threads: ThreadPool,
    pub catalog: Catalog,
}

impl LoadedDatabases {
    /// Loads the databases of the configured folder; with `only`, those of a scene.
    ///
    /// # Errors
    /// Those of the configuration, of the folder, and of starting threads.
    pub fn of(config: &Config, loader: Loader, only: Option<BTreeMap<String, String>>) -> Result<Self, Error> {
        let begun = Instant::now();
        let folder = folder(config, only)?;
        let threads = threads(config.threads(), config.compute.nice)?;
        let load = |snapshot| Catalog::default().renewed(snapshot, &loader, |_| (), || folder.scan().ok());
        let catalog = threads.install(|| folder.scan().map(load))?;
        announce(&catalog, &folder, begun);
        Ok(Self { folder, loader, threads, catalog })
    }
}

/// Database folder. The platform's default folder may not exist yet; a configured one must.
fn folder(config: &Config, only: Option<BTreeMap<String, String>>) -> Result<DatabaseFolder, Error> {
    let required = !config.databases.folder.as_os_str().is_empty();
    let folder = DatabaseFolder { path: config.databases()?, required, only };
    folder.complete()?;
    Ok(folder)
}

fn announce(catalog: &Catalog, folder: &DatabaseFolder, begun: Instant) {
    let (ready, entries, bytes) = (catalog.ready(), catalog.len(), catalog.memory_bytes());
    let resident_bytes = ResidentMemory::now().map_or(0, |resident| resident.total());
    let ms = begun.elapsed().as_millis() as u64;
    tracing::info!(ready, entries, bytes, resident_bytes, ms, "databases loaded");
    if entries == 0 {
        tracing::warn!(folder = %folder.path.display(), "this folder holds no database, so no object can be struck; bake into it (`shatterd bake MESH --name NAME --out FOLDER`), or serve another (--databases)");
    }
}
