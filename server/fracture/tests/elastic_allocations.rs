//! After the first impact, the elastic stages allocate no memory that grows with the lattice.

mod support {
    pub mod counting;
}

use nalgebra::{Point3, Vector3};
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::elasticity::{ContactLoad, DrivingEnergy, ElasticWorkspace, Elasticity, NodalLoad};
use shatter_fracture::lattice::block;
use support::counting::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting::new();

#[test]
fn elastic_stages_reuse_their_memory() {
    let lattice = block([6, 6, 6], 0.1);
    let token = CancelToken::default();
    let body = Elasticity::prepare(&lattice, 0.3, &token).unwrap();
    let contact = |x: f64| ContactLoad { point: Point3::new(x, 0.02, 0.05), impulse: -Vector3::x(), radius: 0.12 };
    let (mut workspace, mut load) = (ElasticWorkspace::default(), NodalLoad::default());
    let (mut displacement, mut energies, mut coordinates) = (Vec::new(), Vec::new(), Vec::new());
    let snapshots = [-0.3, 0.3].map(|x| {
        let mut load = NodalLoad::default();
        body.load(&[contact(x)], &mut load, &mut ElasticWorkspace::default()).unwrap();
        load
    });
    let reduced = body.reduce(&lattice, &snapshots, 2, &token).unwrap().unwrap();
    let mut impact = |contact: ContactLoad| {
        let before = ALLOCATOR.ever();
        body.load(&[contact], &mut load, &mut workspace).unwrap();
        body.solve(&load.forces, &mut displacement, &mut workspace, &token).unwrap();
        reduced.project(&load, &mut coordinates);
        reduced.residual(&body, &load, &coordinates, &mut workspace);
        reduced.expand(&coordinates, &mut displacement, &mut workspace);
        for driving in [DrivingEnergy::Total, DrivingEnergy::Tensile] {
            body.tet_energy(&lattice, &displacement, driving, &mut energies, &token).unwrap();
        }
        ALLOCATOR.ever() - before
    };
    let first = impact(contact(0.3));
    let later: usize = (0..8).map(|turn| impact(contact(if turn % 2 == 0 { -0.3 } else { 0.3 }))).sum();
    // rayon's queues sometimes allocate a block, independently of the lattice.
    assert!(later < first / 8, "{later} bytes in eight impacts, {first} in the first");
}
