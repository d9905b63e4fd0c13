//! Conforming meshes of generated and of real surfaces.

use nalgebra::Point3;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::conforming::{ConformingError, ConformingMesh, ConformingOptions, conforming_mesh};
use shatter_fracture::surface::{self, InsideTest, LengthUnit, RawMesh, Surface, UpAxis, shapes};
use std::fs;
use std::path::{Path, PathBuf};

/// Spacing of the crack lattice, local: that of the default number of nodes.
const SPACING: f64 = 1.0 / 64.0;

/// Points of a body-centered cubic lattice at least half a spacing inside.
fn interior(surface: &Surface) -> Vec<Point3<f64>> {
    let half = SPACING / 2.0;
    let count = (0.5 / half) as i32;
    let planes = (-count..=count).map(|i| {
        let parity = i.rem_euclid(2);
        let steps = || (-count..=count).filter(move |k| k.rem_euclid(2) == parity);
        steps().flat_map(|j| steps().map(move |k| Point3::from([i, j, k].map(|x| f64::from(x) * half)))).collect()
    });
    let low = surface.positions.iter().fold(surface.positions[0], |low, point| low.inf(point));
    let high = surface.positions.iter().fold(surface.positions[0], |high, point| high.sup(point));
    let test = InsideTest::new(surface);
    let mut inside = Vec::new();
    for plane in planes {
        let plane: Vec<Point3<f64>> = plane;
        let near: Vec<Point3<f64>> =
            plane.into_iter().filter(|point| (0..3).all(|k| low[k] < point[k] && point[k] < high[k])).collect();
        let distances = test.signed_distances(&near);
        inside
            .extend(near.into_iter().zip(distances).filter(|(_, distance)| *distance <= -half).map(|(point, _)| point));
    }
    inside
}

fn mesh(surface: &Surface, interior: &[Point3<f64>]) -> Result<ConformingMesh, ConformingError> {
    let options = ConformingOptions { spacing: SPACING, ..ConformingOptions::default() };
    conforming_mesh(&surface.positions, &surface.triangles, interior, &options, &CancelToken::default(), &mut |_| ())
}

/// Volume between triangles and the origin.
fn volume(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    let corner = |vertex: u32| positions[vertex as usize].coords;
    triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0).sum()
}

/// Checks that the mesh fills the surface: volumes agree and all nodes of the surface are kept.
fn check(surface: &Surface, mesh: &ConformingMesh) {
    let at = |vertex: u32| mesh.nodes[vertex as usize];
    let of_tet = |&[a, b, c, d]: &[u32; 4]| (at(b) - at(a)).cross(&(at(c) - at(a))).dot(&(at(d) - at(a))) / 6.0;
    let filled: f64 = mesh.tets.iter().map(of_tet).sum();
    let expected = volume(&surface.positions, &surface.triangles);
    assert!((filled / expected - 1.0).abs() < 1e-11, "{filled} is not {expected}");
    assert_eq!(mesh.nodes[..surface.positions.len()], surface.positions);
    assert!(mesh.deviation <= 1e-15, "{}", mesh.deviation);
}

#[test]
fn generated_surfaces_are_filled() {
    for raw in [shapes::mug(), shapes::statue()] {
        let surface = Surface::repair(raw).unwrap();
        let interior = interior(&surface);
        let mesh = mesh(&surface, &interior).unwrap();
        check(&surface, &mesh);
        assert_eq!(mesh.interior_sources.len(), interior.len(), "no point is outside");
    }
}

/// Processor time of this process in seconds, and the peak of its memory in MiB since the last call; Linux only.
fn processor_s_and_peak_mib() -> (f64, f64) {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> = stat.rsplit(") ").next().unwrap_or("").split(' ').filter_map(|x| x.parse().ok()).collect();
    let ticks = rustix::param::clock_ticks_per_second() as f64;
    // The state, the first field, is no number; the times of user and system are fields 11 and 12 after it.
    let processor_s = fields.get(10..12).map_or(0.0, |times| times.iter().sum::<f64>() / ticks);
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
    // Resets the peak.
    let _ = fs::write("/proc/self/clear_refs", "5");
    (processor_s, peak.map_or(0.0, |kib: f64| kib / 1024.0))
}

/// Mesh files of the folder that `SHATTER_MESHES` names.
fn files() -> Vec<PathBuf> {
    let Some(folder) = std::env::var_os("SHATTER_MESHES") else {
        println!("skipped: SHATTER_MESHES is not set");
        return Vec::new();
    };
    let ends =
        |path: &PathBuf| path.extension().is_some_and(|end| ["obj", "ply", "stl", "glb"].iter().any(|own| end == *own));
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(ends).collect();
    files.sort();
    files
}

/// One row of the table.
fn row(path: &Path) -> String {
    let raw: RawMesh = surface::read(path, LengthUnit::M, UpAxis::Y).unwrap();
    let surface = Surface::repair(raw).unwrap();
    let interior = interior(&surface);
    let (begun_s, _) = processor_s_and_peak_mib();
    let result = mesh(&surface, &interior);
    let (ended_s, peak_mib) = processor_s_and_peak_mib();
    let triangles = surface.triangles.len();
    let time_s = ended_s - begun_s;
    match result {
        Ok(mesh) => {
            check(&surface, &mesh);
            let ConformingMesh { nodes, tets, boundary, steiner_count, rounds, steps, .. } = &mesh;
            format!(
                "{triangles} | {} | {} | {} | {steiner_count} | {rounds} | {steps} | {time_s:.2} | {peak_mib:.0} |",
                boundary.len(),
                nodes.len(),
                tets.len()
            )
        }
        Err(error) => format!("{triangles} | {error} | | | | | | {time_s:.2} | {peak_mib:.0} |"),
    }
}

#[test]
#[ignore = "a minute: meshes every file of SHATTER_MESHES and prints a table; run with --ignored"]
fn real_surfaces_are_filled_or_refused() {
    println!(
        "| file | triangles | split or error | nodes | tetrahedra | Steiner | rounds | steps | CPU s | peak MiB |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for path in files() {
        println!("| {} | {}", path.file_name().unwrap().display(), row(&path));
    }
}
