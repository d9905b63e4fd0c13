//! A prepared object says honestly how much memory it holds: against an allocator that counts.

use nalgebra::Point3;
use shatter_fracture::database::{BakeRequest, bake, load, save};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::RawMesh;
use shatter_fracture::token::Token;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts the bytes that are out.
struct Counting(AtomicUsize);

// SAFETY: every request is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        self.0.fetch_add(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        self.0.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting(AtomicUsize::new(0));

/// A bar of 0.4 × 0.2 × 0.2 m.
fn bar() -> RawMesh {
    let corner = |k: usize| Point3::new([-0.2, 0.2][k & 1], [-0.1, 0.1][k >> 1 & 1], [-0.1, 0.1][k >> 2 & 1]);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    RawMesh::new((0..8).map(corner).collect(), triangles)
}

fn request(elastic_spacing: f64) -> BakeRequest {
    let materials = Materials::parse(include_str!("../../../config/materials.toml")).unwrap();
    BakeRequest {
        name: "bar".to_owned(),
        material_name: "glass".to_owned(),
        material: materials.get("glass").unwrap().clone(),
        fragment_size_m: None,
        gamma_j_m2: None,
        elastic_spacing: Some(elastic_spacing),
        crack_spacing: Some(0.04),
        kappa: None,
        examples: 0,
        seed: 1,
    }
}

#[test]
fn an_object_says_how_much_memory_it_holds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.shatter");
    // With few elastic nodes the lifts and incidences are the most of it, with many the factor.
    for elastic_spacing in [0.12, 0.06] {
        let baked = bake(bar(), &request(elastic_spacing), &Token::default(), &mut |_| {}).unwrap();
        save(&baked, &path).unwrap();
        drop(baked);
        let before = ALLOCATOR.0.load(Ordering::Relaxed);
        let loaded = load(&path).unwrap();
        let held = ALLOCATOR.0.load(Ordering::Relaxed) - before;
        let said = loaded.bytes();
        println!("{elastic_spacing}: {said} bytes said, {held} held");
        assert!(said as f64 > 0.95 * held as f64 && said <= held, "{said} bytes said, {held} held");
    }
}
