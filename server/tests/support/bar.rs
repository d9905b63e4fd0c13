//! A real object, small enough to bake it in every test binary.

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake, save};
use shatter_fracture::pipeline::{ElementChoice, SurfaceKind};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

/// The database of a bar of 0.4 × 0.2 × 0.2 m, as bytes. Bakes it once per process and spacing.
pub fn bar(crack_spacing: f64) -> Vec<u8> {
    static BARS: Mutex<BTreeMap<u64, Arc<OnceLock<Vec<u8>>>>> = Mutex::new(BTreeMap::new());
    let own = BARS.lock().unwrap().entry(crack_spacing.to_bits()).or_default().clone();
    own.get_or_init(|| baked(crack_spacing)).clone()
}

fn baked(crack_spacing: f64) -> Vec<u8> {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let glass = materials.get("glass").unwrap().clone();
    let request = BakeRequest {
        elastic_spacing: Some(0.12),
        crack_spacing: Some(crack_spacing),
        // So that the object has no basis of displacements.
        elements: ElementChoice::Linear,
        seed: 1,
        surface: SurfaceKind::Lattice,
        ..BakeRequest::new("bar", "glass", glass)
    };
    let prepared = bake(shapes::cuboid([0.4, 0.2, 0.2]), &request, &CancelToken::default(), &mut |_| {}).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.shatter");
    save(&prepared, &path).unwrap();
    std::fs::read(path).unwrap()
}
