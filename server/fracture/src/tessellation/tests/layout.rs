//! Determinism, sizes known in advance, reused memory, errors for wrong sizes.

use super::support::*;
use crate::lattice::block;
use crate::tessellation::*;
use nalgebra::Point3;

fn emitted_on(threads: usize) -> Emitted {
    let lattice = wobbly([7, 6, 6], 3);
    let voronoi = Voronoi::new(&lattice, &random_points(25, 0.25, 3));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let topology = Topology::new(&lattice);
        let labels = &voronoi.split.labels;
        let points = crack_points(&lattice, &topology, labels, Some(voronoi.sites()), &FixedPoints::default()).unwrap();
        emit(tessellate(&lattice, &topology, labels, &points).unwrap(), 2.0)
    })
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let one = emitted_on(1);
    for threads in [2, 4] {
        let other = emitted_on(threads);
        let bits = |emitted: &Emitted| -> Vec<[u32; 3]> {
            emitted.positions.iter().map(|position| position.map(f32::to_bits)).collect()
        };
        assert!(bits(&one) == bits(&other) && one == other, "{threads} threads");
    }
}

#[test]
fn wide_instructions_do_not_change_a_bit() {
    crate::simd::tests::same_on_every_path(|| {
        let emitted = emitted_on(2);
        (emitted.positions.iter().map(|position| position.map(f32::to_bits)).collect::<Vec<_>>(), emitted.properties)
    });
}

#[test]
fn a_reused_workspace_gives_the_same_result() {
    let (mut points, mut tessellation, mut workspace) = <(CrackPoints, Tessellation, TessellationWorkspace)>::default();
    // The last two cases use the same lattice with other cells: simplices cut in the first are no longer cut.
    let cases = [([3, 3, 3], 12, 1), ([1, 1, 1], 2, 2), ([2, 2, 2], 1, 4), ([4, 2, 2], 30, 3), ([4, 2, 2], 5, 3)];
    for (cells, count, seed) in cases {
        let lattice = wobbly(cells, seed);
        let topology = Topology::new(&lattice);
        let voronoi = Voronoi::new(&lattice, &random_points(count, 0.25, seed));
        let (labels, sites, fixed) = (&voronoi.split.labels, Some(voronoi.sites()), FixedPoints::default());
        points.find(&lattice, &topology, labels, sites, &fixed).unwrap();
        tessellation.build(&lattice, &topology, labels, &points, &mut workspace).unwrap();
        let fresh = crack_points(&lattice, &topology, labels, sites, &fixed).unwrap();
        assert_eq!(points, fresh);
        assert_eq!(tessellation, tessellate(&lattice, &topology, labels, &fresh).unwrap());
        check_emitted(&lattice, &emit(tessellation.clone(), 3.5));
    }
}

#[test]
fn a_label_without_nodes_is_an_empty_fragment() {
    let lattice = block([1, 1, 1], 0.5);
    let labels: Vec<u32> = lattice.nodes.iter().map(|node| if node.x < 0.0 { 0 } else { 2 }).collect();
    let emitted = check(&lattice, &labels, None);
    assert_eq!(emitted.tessellation.fragments().len(), 3);
    assert!(emitted.tessellation.fragments()[1].runs.is_empty());
    assert_eq!(emitted.properties[1].volume, 0.0);
    assert!(emitted.properties[1].rigid().is_err());
}

#[test]
fn memory_of_the_wrong_size_is_refused_and_left_alone() {
    let lattice = block([1, 1, 1], 0.5);
    let labels = random_labels(lattice.nodes.len(), 3, 1);
    let good = check(&lattice, &labels, None);
    let centers = vec![Point3::origin(); good.properties.len()];
    let transform = LocalToMeters { meters_per_unit: 1.0 };
    let (vertices, indices, merges) = (good.positions.len(), good.indices.len(), good.merges.len());
    let attempt = |center_count: usize, vertices: usize, indices: usize, merges: usize| {
        let mut sections = (vec![[7.0; 3]; vertices], vec![7; indices], vec![[7; 2]; merges]);
        let (positions, index, merge) = (&mut sections.0, &mut sections.1, &mut sections.2);
        let result = good.tessellation.emit(&centers[..center_count], transform, positions, index, merge);
        let untouched = sections.0.iter().flatten().all(|&x| x == 7.0) && sections.1.iter().all(|&x| x == 7);
        assert!(result.is_ok() || untouched);
        result
    };
    let all = centers.len();
    let wrong = |needed: usize| (needed, needed - 1);
    assert_eq!(attempt(all, vertices, indices, merges), Ok(()));
    let (needed, given) = wrong(all);
    assert_eq!(attempt(given, vertices, indices, merges), Err(TessellationError::Centers { needed, given }));
    let (needed, given) = wrong(vertices);
    assert_eq!(attempt(all, given, indices, merges), Err(TessellationError::Positions { needed, given }));
    let (needed, given) = wrong(indices);
    assert_eq!(attempt(all, vertices, given, merges), Err(TessellationError::Indices { needed, given }));
    let (needed, given) = wrong(merges);
    assert_eq!(attempt(all, vertices, indices, given), Err(TessellationError::Merges { needed, given }));
}

#[test]
fn labels_and_sites_that_do_not_fit_are_refused_by_name() {
    let lattice = block([1, 1, 1], 0.5);
    let topology = Topology::new(&lattice);
    let nodes = topology.nodes;
    let none = FixedPoints::default();
    let short = vec![0; nodes - 1];
    let refused = crack_points(&lattice, &topology, &short, None, &none);
    assert_eq!(refused, Err(TessellationError::LabelCount { nodes, labels: nodes - 1 }));
    let mut high = vec![0; nodes];
    high[4] = nodes as u32;
    let refused = tessellate(&lattice, &topology, &high, &CrackPoints::default());
    assert_eq!(refused, Err(TessellationError::LabelOutOfRange { node: 4, label: nodes as u32 }));
    let labels = random_labels(nodes, 3, 1);
    let (lift, coordinates) = random_lift(&lattice, 3, 2, 1);
    for of_fragment in [&[0, 1][..], &[0, 1, 2]] {
        let sites = Some(BisectorSites { lift: &lift, coordinates: &coordinates, of_fragment, of_node: None });
        let refused = crack_points(&lattice, &topology, &labels, sites, &none);
        assert_eq!(refused, Err(TessellationError::Site { fragment: 2 }));
    }
}

#[test]
fn points_of_other_labels_are_refused() {
    let lattice = block([2, 2, 2], 0.2);
    let topology = Topology::new(&lattice);
    let none = FixedPoints::default();
    let coarse = random_labels(topology.nodes, 2, 1);
    let fine = random_labels(topology.nodes, 9, 1);
    let points = crack_points(&lattice, &topology, &coarse, None, &none).unwrap();
    assert_eq!(tessellate(&lattice, &topology, &fine, &points), Err(TessellationError::Points));
    assert_eq!(tessellate(&lattice, &topology, &fine, &CrackPoints::default()), Err(TessellationError::Points));
}
