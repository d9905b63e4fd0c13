//! Smooth vertex normals for display.

/// Smooth normals, one per vertex, of length one: the mean of the normals of its triangles, weighted by area (Gouraud 1971). Runs have
/// vertices of their own, so the rim between an outer and a crack face stays sharp.
pub fn smooth_normals(positions: &[[f32; 3]], indices: &[u32]) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0_f64; 3]; positions.len()];
    for triangle in indices.chunks_exact(3) {
        let corners = [0, 1, 2].map(|k| positions[triangle[k] as usize].map(f64::from));
        let twice_area = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
        for &vertex in triangle {
            let sum = &mut sums[vertex as usize];
            *sum = [0, 1, 2].map(|k| sum[k] + twice_area[k]);
        }
    }
    sums.into_iter().map(unit).collect()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Direction of `sum`; upwards if it has none, because glTF requires unit length.
fn unit(sum: [f64; 3]) -> [f32; 3] {
    let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { sum.map(|x| (x / length) as f32) } else { [0.0, 1.0, 0.0] }
}
