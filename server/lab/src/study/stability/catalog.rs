//! Catalog of hard cases, with every bound and its reason.

use super::Case;
use super::Expect::{AtLeast, AtMost, Between, Refused};
use super::cases::{cells, degree, lift, load, material, mesh, neck, poisson, reference, scale, tessellation};

/// Items that are hard for the method, including those found later. Every item has a case.
pub const LIST: &[&str] = &[
    "mesh: inverted",
    "mesh: open",
    "mesh: self-intersecting",
    "mesh: duplicated",
    "mesh: degenerate triangles",
    "mesh: non-finite",
    "mesh: nested shells",
    "mesh: several components",
    "mesh: thin plate 1:100",
    "mesh: needle",
    "mesh: gap narrower than the spacing",
    "mesh: sizes 1e-6 and 1e6 m",
    "mesh: center 1e6 m from the origin",
    "mesh: nothing there",
    "mesh: touching parts",
    "material: nu = 0",
    "material: nu = 0.45",
    "material: nu = 0.499",
    "material: nu < 0",
    "material: nu >= 1/2",
    "material: E over 12 decades",
    "material: gamma to 0 and infinity",
    "load: point load under refinement",
    "load: zero",
    "load: tangential",
    "load: two opposed",
    "load: outside the body",
    "load: on an anchor",
    "load: non-finite",
    "load: magnitudes",
    "lift: repeated eigenvalues",
    "lift: disconnected lattice",
    "lift: fewer nodes than modes",
    "lift: surface distances carried inside",
    "CVD: coincident nodes",
    "CVD: all energy at one node",
    "CVD: n > nodes",
    "CVD: perfect symmetry",
    "CVD: extreme fields",
    "CVD: uniform cube",
    "tessellation: ties at nodes",
    "tessellation: t at 0 or 1",
    "tessellation: exterior points",
    "tessellation: any labels",
    "degree: no example",
    "degree: duplicate examples",
    "degree: far outside the examples",
    "degree: at the threshold",
    "degree: thin bodies",
    "references: elasticity",
    "references: spectra",
    "a weak neck",
];

const fn case(
    name: &'static str,
    item: &'static str,
    expect: super::Expect,
    why: &'static str,
    run: fn() -> Result<f64, super::TrialFault>,
) -> Case {
    Case { name, item, expect, why, run }
}

/// Bound for sums of volumes: positions are f32, but volumes are measured in f64 before rounding, so only f64 rounding remains.
const SUM: super::Expect = AtMost(1e-9);
const SUM_WHY: &str = "sum of the fragments' volumes against the lattice: both are sums in f64";

/// All hard cases, in the order in which they run.
#[rustfmt::skip]
pub const CASES: &[Case] = &[
    case("inside out", "mesh: inverted", AtMost(1e-9), "volume against the arch itself: welding reverses it, and the lattice is the same", mesh::inside_out),
    case("mixed winding", "mesh: inverted", AtMost(1e-3), "volume against the arch itself: neighbors agree on one orientation, but corners start elsewhere and rounding differs", mesh::mixed_winding),
    case("sphere with holes", "mesh: open", AtMost(0.02), "volume against the whole sphere: 2 % of the triangles are missing, and films close the holes", mesh::open),
    case("two balls in one another", "mesh: self-intersecting", AtMost(0.02), "volume against that of the union: the winding number exceeds one half in both", mesh::self_intersecting),
    case("every triangle twice", "mesh: duplicated", AtMost(1e-9), "volume against the arch itself: duplicates are dropped", mesh::duplicated),
    case("flat triangles", "mesh: degenerate triangles", AtMost(1e-9), "volume against the arch itself: triangles without area do not change winding numbers", mesh::degenerate),
    case("T-junctions", "mesh: degenerate triangles", AtMost(1e-3), "volume against the arch itself: no gap opens, but the hierarchy of triangles differs", mesh::t_junctions),
    case("NaN", "mesh: non-finite", Refused("non_finite_vertex"), "a vertex has no position", mesh::not_a_number),
    case("infinity", "mesh: non-finite", Refused("non_finite_vertex"), "a vertex has no position", mesh::infinite),
    case("1e300", "mesh: non-finite", Refused("extent_out_of_range"), "volumes of such lengths overflow", mesh::immense),
    case("index out of range", "mesh: non-finite", Refused("vertex_out_of_bounds"), "the file is damaged", mesh::out_of_range),
    case("ball with a cavity", "mesh: nested shells", AtMost(0.02), "volume against 4/3 π (R³ − r³): the spacing is a tenth of the wall", mesh::nested),
    case("three balls", "mesh: several components", AtMost(0.0), "difference of the number of bodies from three", mesh::several_components),
    case("plate 1:100", "mesh: thin plate 1:100", AtMost(0.01), "volume error, one whole body: the spacing follows the walls", mesh::plate),
    case("plate 1:2000", "mesh: thin plate 1:100", Refused("too_thin"), "no lattice within the limits preserves it", mesh::foil),
    case("vase at a coarse spacing", "mesh: thin plate 1:100", Refused("too_thin"), "the requested spacing loses the wall", mesh::lost_wall),
    case("a fin on a cube", "mesh: thin plate 1:100", AtLeast(10.0), "samples on the lost fin: the report names it", mesh::lost_fin),
    case("needle 1:100", "mesh: needle", AtMost(0.01), "volume error, one whole body: the spacing follows the walls", mesh::needle),
    case("cubes a hair apart", "mesh: gap narrower than the spacing", AtLeast(10.0), "samples at the closed gap: the report names it", mesh::narrow_gap),
    case("a ball and its crumbs", "mesh: several components", AtMost(0.01), "volume against the ball: it must not grow by the volume of the omitted crumbs", mesh::small_components),
    case("micrometers", "mesh: sizes 1e-6 and 1e6 m", AtMost(1e-6), "volumes against the object of unit size: local coordinates differ by rounding, positions by f32", scale::micrometers),
    case("megameters", "mesh: sizes 1e-6 and 1e6 m", AtMost(1e-6), "volumes against the object of unit size: local coordinates differ by rounding, positions by f32", scale::megameters),
    case("1e6 m away", "mesh: center 1e6 m from the origin", AtMost(1e-6), "volumes against the object at the origin: f64 keeps 1e-10 of the diagonal there", scale::far_from_the_origin),
    case("positions 1e6 m away", "mesh: center 1e6 m from the origin", AtMost(1.0), "largest coordinate over the diagonal: relative to the fragment's center, not to the origin", scale::positions_are_relative),
    case("f32 1e6 m away", "mesh: center 1e6 m from the origin", AtLeast(1.0), "vertices whose detail is lost: the report names the defect", mesh::lost_precision),
    case("no triangle", "mesh: nothing there", Refused("empty_mesh"), "the mesh has no triangles", mesh::empty),
    case("one triangle", "mesh: nothing there", Refused("nothing_inside"), "the mesh has no inside", mesh::single_triangle),
    case("one point", "mesh: nothing there", Refused("zero_extent"), "the mesh has no extent", mesh::one_point),
    case("denormal coordinates", "mesh: nothing there", Refused("all_degenerate"), "areas of such lengths underflow to zero", mesh::denormal),
    case("cubes that share a corner", "mesh: touching parts", SUM, SUM_WHY, mesh::bow_tie),
    case("nu = 0", "material: nu = 0", SUM, SUM_WHY, material::poisson_zero),
    case("nu = 0.45", "material: nu = 0.45", SUM, SUM_WHY, material::poisson_045),
    case("bending at nu = 0.45", "material: nu = 0.45", AtMost(0.03), "deficit of bending energy on the lattice of the bake, six cubes across: 2 % at any ν", poisson::bending_at_045),
    case("bending at nu = 0.45, worst lattice", "material: nu = 0.45", AtMost(0.15), "deficit of bending energy, cubes divided in six, eight across: the largest accepted error", poisson::worst_lattice_at_045),
    case("nu = 0.499", "material: nu = 0.499", Refused("elasticity"), "tetrahedra lock: on the worst lattice 72 % of the energy is missing", material::poisson_0499),
    case("bending at nu = 0.499, worst lattice", "material: nu = 0.499", AtLeast(0.5), "deficit of bending energy, cubes divided in six, eight across: the reason for refusing this material", poisson::worst_lattice_at_0499),
    case("nu = -0.3", "material: nu < 0", SUM, SUM_WHY, material::poisson_negative),
    case("nu = 0.5", "material: nu >= 1/2", Refused("elasticity"), "the material would be incompressible", material::poisson_half),
    case("E times 1e-6 and 1e6", "material: E over 12 decades", AtMost(1e-6), "volumes at the same W/γ: E is a factor of the solution, not part of the solve", material::modulus_over_twelve_decades),
    case("gamma = 1e-300", "material: gamma to 0 and infinity", Between(512.0, 512.0), "the degree: equal to the cap, which the result reports", material::gamma_to_zero),
    case("gamma = 1e300", "material: gamma to 0 and infinity", AtMost(1.0), "the degree: the object stays whole", material::gamma_to_infinity),
    case("gamma = 0", "material: gamma to 0 and infinity", Refused("gamma"), "the object would break without limit", material::gamma_zero),
    case("contact radius to 0", "load: point load under refinement", Between(0.6, 1.7), "energy × radius at half the spacing over that before: a point load has infinite energy, so the radius is raised to what the lattice resolves", load::point_load_under_refinement),
    case("at a corner", "load: point load under refinement", SUM, SUM_WHY, load::at_a_corner),
    case("zero impulse", "load: zero", Refused("impulse"), "there is no impact", load::zero_impulse),
    case("tangential", "load: tangential", SUM, SUM_WHY, load::tangential),
    case("two opposed", "load: two opposed", SUM, SUM_WHY, load::two_opposed),
    case("two that cancel", "load: two opposed", Refused("impulse"), "there is no deformation", load::two_that_cancel),
    case("10 m away", "load: outside the body", Refused("contact_too_far"), "the contact does not touch the object", load::outside),
    case("on an anchor", "load: on an anchor", AtMost(1e-3), "strain energy over that of the same push at the free end: the support takes it", load::on_an_anchor),
    case("NaN impulse", "load: non-finite", Refused("impulse"), "the impulse is not a number", load::not_a_number),
    case("infinite point", "load: non-finite", Refused("contact_point"), "the point is not finite", load::infinite_point),
    case("duration 1e-310 s", "load: non-finite", Refused("impulse"), "the peak force overflows", load::tiny_duration),
    case("impulse 1e-150 N·s", "load: magnitudes", SUM, SUM_WHY, load::tiny_impulse),
    case("impulse 1e140 N·s", "load: magnitudes", SUM, SUM_WHY, load::immense_impulse),
    case("cube turned", "lift: repeated eigenvalues", AtMost(1e-8), "interior distances: whole multiplets are invariant, rounding grows with the inverse gap", lift::cube),
    case("cube cut inside a multiplet", "lift: repeated eigenvalues", AtMost(1e-8), "interior distances: the spectrum is cut at a gap near the requested number", lift::cube_cut_inside_a_multiplet),
    case("ball turned", "lift: repeated eigenvalues", AtMost(1e-8), "interior distances: multiplets of 3, 5 and 7", lift::sphere),
    case("torus turned", "lift: repeated eigenvalues", AtMost(1e-7), "interior distances: pairs that the lattice splits slightly, so that gaps are small", lift::torus),
    case("straight distances, harmonic", "lift: surface distances carried inside", AtMost(1e-9), "interior distance against the straight one over the size, with the boundary's coordinates extended inside: both kinds of coordinates have linear precision", lift::straight_by_harmonic),
    case("straight distances, mean value", "lift: surface distances carried inside", AtMost(1e-9), "as before", lift::straight_by_mean_value),
    case("surface lift of a needle", "lift: surface distances carried inside", Refused("lift"), "distances along a needle carry no information across it: the lift is flat", lift::flat_surface_lift),
    case("two blocks", "lift: disconnected lattice", Refused("lift"), "distances between the blocks are infinite", lift::disconnected),
    case("fifteen nodes", "lift: fewer nodes than modes", AtMost(0.0), "0 if all is finite", lift::tiny_lattice),
    case("all nodes at one place", "CVD: coincident nodes", AtMost(0.0), "rise of Lloyd's energy, plus 1 if it did not converge", cells::coincident_nodes),
    case("energy at one node", "CVD: all energy at one node", AtMost(1e-12), "rise of Lloyd's energy, plus the number of empty cells", cells::all_energy_at_one_node),
    case("ten sites per node", "CVD: n > nodes", AtMost(1e-12), "rise of Lloyd's energy, plus sites beyond one per node", cells::more_sites_than_nodes),
    case("512 sites on a coarse cube", "CVD: n > nodes", SUM, SUM_WHY, cells::more_sites_than_nodes_struck),
    case("no energy", "CVD: extreme fields", Refused("field"), "there is no energy to divide", cells::no_energy),
    case("negative energy", "CVD: extreme fields", Refused("field"), "the energy is no density", cells::negative_energy),
    case("thirty decades", "CVD: extreme fields", AtMost(1e-12), "rise of Lloyd's energy: the floor of the density keeps cells in regions without energy", cells::thirty_decades),
    case("two clumps of energy", "CVD: extreme fields", AtMost(1.0), "rise of Lloyd's energy, plus components beyond the sites, over the sites", cells::two_clumps),
    case("uniform cube, 60 cells", "CVD: uniform cube", Between(1.0, 1.12), "normalized second moment over 0.0785433, that of the body-centered lattice: limited by flat faces, a local minimum, and cells of whole nodes", cells::yardstick),
    case("cube at a face center", "CVD: perfect symmetry", AtMost(0.0), "any difference between 1 and 4 threads: ties are broken by index", cells::cube_at_a_face_center),
    case("sphere at a pole", "CVD: perfect symmetry", AtMost(0.0), "any difference between 1 and 4 threads: ties are broken by index", cells::sphere_at_a_pole),
    case("torus on its rim", "CVD: perfect symmetry", AtMost(0.0), "any difference between 1 and 4 threads: ties are broken by index", cells::torus_on_its_rim),
    case("octants", "tessellation: ties at nodes", SUM, SUM_WHY, tessellation::ties_at_nodes),
    case("sites on nodes", "tessellation: t at 0 or 1", SUM, SUM_WHY, tessellation::sites_on_nodes),
    case("coincident sites", "tessellation: t at 0 or 1", SUM, SUM_WHY, tessellation::coincident_sites),
    case("random lifts", "tessellation: exterior points", SUM, SUM_WHY, tessellation::exterior_points),
    case("2 to 20 random labels", "tessellation: any labels", SUM, SUM_WHY, tessellation::random_labels_on_a_block),
    case("random labels, nodes moved", "tessellation: any labels", SUM, SUM_WHY, tessellation::random_labels_on_a_perturbed_block),
    case("no example", "degree: no example", AtMost(0.0), "0 if the degree source of the result is the closed form", degree::no_example),
    case("every example twice", "degree: duplicate examples", AtMost(0.05), "relative change of the inferred numbers: duplicate training samples count once", degree::duplicate_examples),
    case("an impact beyond all examples", "degree: far outside the examples", AtMost(0.0), "0 if near impacts are inferred and the far one uses the closed form", degree::far_outside),
    case("by a hair", "degree: at the threshold", Between(1.0, 7.0), "difference between the degrees just above and just below the threshold: a few fragments, not dozens", degree::by_a_hair),
    case("falling gamma", "degree: at the threshold", AtMost(0.0), "largest decrease of the optimized degree: monotone by construction", degree::monotone),
    case("degree of a plate", "degree: thin bodies", Between(0.5, 2.0), "closed form over optimized: counted in two dimensions where cells are larger than the thickness", degree::of_a_plate),
    case("degree of a rod", "degree: thin bodies", Between(0.5, 2.0), "closed form over optimized: counted in one dimension where cells are larger than the section", degree::of_a_rod),
    case("patch test", "references: elasticity", AtMost(1e-10), "energy of any tetrahedron under constant stress: exact up to rounding", reference::patch),
    case("beam in pure bending", "references: elasticity", AtMost(0.03), "energy, six cubes across: second order from below", reference::bending),
    case("order of bending energy", "references: elasticity", Between(1.7, 2.1), "observed order when the spacing is halved: linear elements", reference::bending_order),
    case("order of bending displacement", "references: elasticity", Between(1.7, 2.2), "observed order of the sagitta when the spacing is halved: linear elements", reference::sagitta_order),
    case("plate bent to a sphere", "references: elasticity", AtMost(0.06), "energy, four cubes across the thickness", reference::plate),
    case("cantilever", "references: elasticity", AtMost(0.1), "energy against Timoshenko's beam, four cubes across, clamped end included", reference::cantilever),
    case("order of a pushed bar", "references: elasticity", Between(1.8, 2.2), "observed order of the energy when the spacing is halved: inertia relief is exact", reference::bar_order),
    case("other pins", "references: elasticity", AtMost(1e-9), "energy of any tetrahedron: three pins carry no reaction", reference::pins),
    case("spectrum of a box", "references: spectra", AtMost(0.015), "first twelve eigenvalues, 0.05 spacing: second order", reference::box_spectrum),
    case("order of the box's spectrum", "references: spectra", Between(1.8, 2.3), "observed order when the spacing is halved: linear elements", reference::box_spectrum_order),
    case("spectrum of a ball", "references: spectra", AtMost(0.03), "first eight eigenvalues, twelve cubes across: second order", reference::ball_spectrum),
    case("dumbbell near its threshold", "a weak neck", AtLeast(0.95), "share of each end that stays in one fragment: the neck snaps", neck::snaps_near_the_threshold),
    case("dumbbell far above", "a weak neck", AtLeast(0.5), "share of the fragments from the neck at twelve times the threshold: the neck shatters, and the ends stay whole", neck::shatters_far_above),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_of_the_list_has_a_case_and_every_case_an_item() {
        assert!(CASES.len() >= 40);
        for item in LIST {
            assert!(CASES.iter().any(|case| case.item == *item), "there is no case for '{item}'");
        }
        for (index, case) in CASES.iter().enumerate() {
            assert!(LIST.contains(&case.item), "the item of '{}' is not in the list", case.name);
            assert!(CASES[..index].iter().all(|other| other.name != case.name), "'{}' twice", case.name);
            assert!(!case.why.is_empty());
        }
    }
}
