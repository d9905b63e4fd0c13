//! Accuracy of the memory that a prepared object reports, compared to a counting allocator.

mod support {
    pub mod counting;
}

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake, load, save};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use support::counting::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting::new();

fn request(elastic_spacing: f64) -> BakeRequest {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let glass = materials.get("glass").unwrap().clone();
    BakeRequest {
        elastic_spacing: Some(elastic_spacing),
        crack_spacing: Some(0.04),
        seed: 1,
        ..BakeRequest::new("bar", "glass", glass)
    }
}

#[test]
fn an_object_says_how_much_memory_it_holds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.shatter");
    // With few elastic nodes, lifts and incidences dominate the memory; with many, the factor does.
    for elastic_spacing in [0.12, 0.06] {
        let baked =
            bake(shapes::cuboid([0.4, 0.2, 0.2]), &request(elastic_spacing), &CancelToken::default(), &mut |_| {})
                .unwrap();
        save(&baked, &path).unwrap();
        drop(baked);
        let before = ALLOCATOR.out();
        let loaded = load(&path).unwrap();
        let held = ALLOCATOR.out() - before;
        let stated = loaded.bytes();
        println!("{elastic_spacing}: {stated} bytes reported, {held} held");
        assert!(stated as f64 > 0.95 * held as f64 && stated <= held, "{stated} bytes reported, {held} held");
    }
}
