//! After the first requests, further requests do not increase the memory.

mod support {
    pub mod counting;
}

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, bake};
use shatter_fracture::pipeline::{self, DegreeRequest, FractureRequest, PreparedObject, Workspace};
use shatter_fracture::scene::Materials;
use shatter_fracture::surface::shapes;
use support::counting::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting::new();

const ROUNDS: usize = 8;

/// An object with a reduced basis, so that reduced and solved requests alternate.
fn prepared() -> PreparedObject {
    let materials = Materials::parse(shatter_fracture::scene::MATERIALS).unwrap();
    let glass = materials.get("glass").unwrap().clone();
    let request = BakeRequest {
        elastic_spacing: Some(0.08),
        crack_spacing: Some(0.05),
        examples: 24,
        seed: 1,
        ..BakeRequest::new("bar", "glass", glass)
    };
    bake(shapes::cuboid([0.4, 0.2, 0.2]), &request, &CancelToken::default(), &mut |_| {}).unwrap()
}

/// Requests all over the bar, with varying numbers of sites.
fn requests() -> Vec<FractureRequest> {
    let request = |turn: u32| {
        let (x, side) = (-0.18 + 0.03 * f64::from(turn), if turn.is_multiple_of(2) { 0.1 } else { -0.1 });
        let mut strike =
            FractureRequest::at(Point3::new(x, side, 0.03), Vector3::new(0.0, -20.0 * side, 1.0)).seeded(1);
        strike.degree = DegreeRequest::Sites(5 + 17 * (turn % 5));
        strike.seed = u64::from(turn);
        strike
    };
    (0..12).map(request).collect()
}

#[test]
fn strikes_hold_no_more_memory_than_the_first_ones() {
    let (prepared, strikes, token) = (prepared(), requests(), CancelToken::default());
    let mut workspace = Workspace::default();
    let mut round = || {
        let before = ALLOCATOR.ever();
        for strike in &strikes {
            let outcome =
                pipeline::strike(pipeline::RequestContext::new(&prepared, strike, &token, &()), &mut workspace)
                    .unwrap();
            assert!(outcome.meshes().is_some());
        }
        (ALLOCATOR.out(), ALLOCATOR.ever() - before)
    };
    let rounds: Vec<(usize, usize)> = (0..ROUNDS).map(|_| round()).collect();
    println!("bytes allocated after a round, and allocations during it: {rounds:?}");
    // rayon's queues sometimes allocate a block, independently of the lattice.
    let (first, made) = rounds[0];
    assert!(rounds.iter().all(|(out, _)| *out <= first + 65_536), "{rounds:?}");
    assert!(rounds[1..].iter().all(|(_, ever)| *ever < made / 2), "{rounds:?}");
}
