//! Distances to a surface, beside those of another library.

use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;
use shatter_fracture::random::RandomStream;
use shatter_fracture::surface::{InsideTest, Surface, shapes};

#[test]
fn the_distance_matches_parry() {
    let surface = Surface::repair(shapes::mug()).unwrap();
    let inside = InsideTest::new(&surface);
    let vertices = surface.positions.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let oracle = TriMesh::new(vertices, surface.triangles.clone()).unwrap();
    let mut random = RandomStream::new(7, 0);
    for _ in 0..500 {
        // The local box is centered at the origin, and its diagonal is 1.
        let point = Point3::from(Vector3::from_fn(|_, _| 1.2 * random.uniform() - 0.6));
        let expected = oracle.distance_to_local_point(Vector::new(point.x, point.y, point.z), false);
        assert!((inside.distance(&point) - expected).abs() < 1e-12, "{point}");
    }
}
