//! Accuracy of the memory that a prepared object reports, compared to a counting allocator.

mod support {
    pub mod counting;
}

use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, DatabaseError, bake, load, save};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use std::sync::{Mutex, PoisonError};
use std::thread;
use support::counting::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting::new();

/// Held by the test that counts: the allocator serves all.
static ALONE: Mutex<()> = Mutex::new(());

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
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.shatter");
    // With few elastic nodes, lifts and incidences dominate the memory; with many, the factor does.
    for elastic_spacing in [0.12, 0.06, 0.04] {
        let baked =
            bake(shapes::cuboid([0.4, 0.2, 0.2]), &request(elastic_spacing), &CancelToken::default(), &mut |_| {})
                .unwrap();
        save(&baked, &path).unwrap();
        drop(baked);
        let before = ALLOCATOR.out();
        // A new thread has no buffers of earlier matrix products, and those of this load would be counted before it ends.
        let (held, stated) = thread::scope(|scope| {
            let own = scope.spawn(|| {
                let loaded = load(&path).unwrap();
                (ALLOCATOR.out() - before, loaded.bytes())
            });
            own.join().unwrap()
        });
        println!("{elastic_spacing}: {stated} bytes reported, {held} held");
        assert!(stated as f64 > 0.95 * held as f64 && stated <= held, "{stated} bytes reported, {held} held");
    }
}

/// The file claims a tensor that is not on the disk, and whose checksum is missing.
#[test]
fn a_sparse_file_takes_no_memory_of_the_length_that_it_claims() {
    const CLAIMED: usize = 1 << 28;
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bar.shatter");
    let baked = bake(shapes::cuboid([0.4, 0.2, 0.2]), &request(0.12), &CancelToken::default(), &mut |_| {}).unwrap();
    save(&baked, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let data = 8 + u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let mut header: serde_json::Map<String, serde_json::Value> = serde_json::from_slice(&bytes[8..data]).unwrap();
    let ends = [bytes.len() - data, bytes.len() - data + CLAIMED];
    header.insert("large".to_owned(), serde_json::json!({ "dtype": "U8", "shape": [CLAIMED], "data_offsets": ends }));
    let text = serde_json::Value::Object(header).to_string();
    std::fs::write(&path, [&(text.len() as u64).to_le_bytes()[..], text.as_bytes(), &bytes[data..]].concat()).unwrap();
    let length = (8 + text.len() + ends[1]) as u64;
    std::fs::File::options().write(true).open(&path).unwrap().set_len(length).unwrap();
    let before = ALLOCATOR.ever();
    let refused = load(&path).err().unwrap();
    assert!(matches!(&refused, DatabaseError::Checksum(name) if name == "large"), "{refused}");
    assert!(ALLOCATOR.ever() - before < CLAIMED / 2, "{} bytes", ALLOCATOR.ever() - before);
}
