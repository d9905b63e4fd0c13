//! Polygons of more than three corners.

use super::*;

/// A fan of needles at one corner cannot be meshed exactly.
#[test]
fn convex_polygons_of_many_corners_have_no_fan() {
    let count = 700_u32;
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(count);
    let ring: String = (0..count).map(|k| format!("v {} {} 0\n", 0.7 * angle(k).cos(), angle(k).sin())).collect();
    let corners: String = (1..=count).map(|k| format!(" {k}")).collect();
    let mesh = read_bytes("a.obj", format!("{ring}f{corners}\n").as_bytes()).unwrap();
    assert_eq!(mesh.triangles.len() as u32, count - 2);
    let at = |vertex: u32| mesh.positions_m[vertex as usize];
    let area = |[a, b, c]: [u32; 3]| 0.5 * (at(b) - at(a)).cross(&(at(c) - at(a))).z;
    let whole = 0.5 * 0.7 * f64::from(count) * angle(1).sin();
    assert!(mesh.triangles.iter().all(|own| area(*own) > 0.0));
    assert!((mesh.triangles.iter().map(|own| area(*own)).sum::<f64>() / whole - 1.0).abs() < 1e-12);
    let around = |vertex: u32| mesh.triangles.iter().filter(|own| own.contains(&vertex)).count();
    assert!((0..count).all(|vertex| around(vertex) <= 20));
}

#[test]
fn obj_polygons_are_cut_without_overlap() {
    // An L-shape; a fan from its first corner would leave it.
    let text = "v 0 2 0\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nf 4 5 6 1 2 3\nf 1 2\nf 1 2 3\n";
    let mesh = read_bytes("l.obj", text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles.len(), 5);
    assert_eq!(mesh.faces, [0, 0, 0, 0, 2]);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions_m[v as usize]);
        (b - a).cross(&(c - a)).z / 2.0
    };
    assert!(mesh.triangles.iter().all(|t| area(t) > 0.0));
    assert!((mesh.triangles[..4].iter().map(area).sum::<f64>() - 3.0).abs() < 1e-15);
}
