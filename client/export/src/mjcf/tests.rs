//! Tests of the model as text; `shatter-tests` reads it as XML, and runs it if Python has MuJoCo.

use super::*;
use crate::{FragmentView, HullView, RunView};
use nalgebra::{Matrix3, Rotation3, Vector3};
use shatter_proto::result::Bond;

fn matrix([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

#[test]
fn the_turn_is_one_of_a_quarter_about_x_of_places_and_tensors() {
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let place = [0.25, 2.0, -3.0];
    assert!((Vector3::from(z_up(place)) - turn * Vector3::from(place)).norm() < 1e-15);
    let tensor = [3.0, 2.0, 4.0, 0.5, 0.25, -0.5];
    let turned = turn.matrix() * matrix(tensor) * turn.matrix().transpose();
    assert!((matrix(tensor_z_up(tensor)) - turned).norm() < 1e-14);
}

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [u32; 12] = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1];
const RUN: RunView = RunView { crack: false, index_first: 0, index_count: 12 };

fn fragment(id: u32) -> FragmentView<'static> {
    FragmentView {
        id,
        body: 0,
        positions: &CORNERS,
        normals: &[],
        uvs: &[],
        uvs2: &[],
        colors: &[],
        materials: &[],
        indices: &FACES,
        runs: &[RUN],
        merges: &[],
        center_m: [f64::from(id), 2.0, 0.5],
        volume_m3: 1.0 / 6.0,
        mass_kg: 400.0,
        inertia_kg_m2: [3.0, 2.0, 4.0, 0.5, 0.25, -0.5],
    }
}

fn bond(fragment: u32, neighbor: Option<u32>) -> Bond {
    let mut bond = Bond::new(fragment, neighbor);
    (bond.area_m2, bond.normal, bond.centroid_m) = (0.25, [1.0, 0.0, 0.0], [1.0, 2.5, 0.5]);
    bond
}

fn model(hulls: &[Option<HullView<'_>>], bonds: &[Bond]) -> Result<MjcfModel, ExportError> {
    mjcf(&ObjectView { name: "<a & b>", fragments: &[fragment(0), fragment(1)], hulls, bonds }, "b")
}

#[test]
fn anchored_fragments_are_welded_and_flat_fragments_are_boxes() {
    let xml = model(&[None, None], &[bond(0, Some(1)), bond(1, None)]).unwrap().xml;
    for wanted in [
        r#"<mujoco model="&lt;a &amp; b&gt;">"#,
        r#"<weld name="bond_000_001" body1="fragment_000" body2="fragment_001" anchor="0 -0 0.5"/>"#,
        r#"<weld name="bond_001_world" body1="fragment_001" anchor="1 -0.5 2.5"/>"#,
        r#"<exclude body1="fragment_000" body2="fragment_001"/>"#,
        r#"<geom name="fragment_001" class="solid" type="box" pos="0.5 -0.5 0.5" size="0.5 0.5 0.5"/>"#,
        r#"<numeric name="bond_area_m2" data="0.25 0.25"/>"#,
    ] {
        assert!(xml.contains(wanted), "{wanted} in {xml}");
    }
    assert_eq!(xml.matches("<exclude").count(), 1);
}

#[test]
fn without_hulls_the_surface_collides_and_without_bonds_nothing_is_welded() {
    let found = model(&[], &[]).unwrap();
    assert!(found.xml.contains(r#"class="solid" type="mesh" mesh="fragment_000_solid""#), "{}", found.xml);
    assert!(!["weld", "exclude", "numeric"].iter().any(|word| found.xml.contains(word)));
    let names: Vec<&str> = found.meshes.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names[..2], ["fragment_000_outer.obj", "fragment_000_solid.obj"]);
    assert!(
        found.meshes[1].1.starts_with("v 0 -0 0\nv 1 -0 0\nv 0 -0 1\nv 0 -1 0\nf 2 3 4\n"),
        "{}",
        found.meshes[1].1
    );
}

#[test]
fn inconsistent_sections_are_rejected_by_name() {
    let check = |found: Result<MjcfModel, ExportError>, wanted: &str| {
        let error = found.unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{error}");
    };
    check(model(&[], &[bond(0, Some(2))]), "bond 0 names fragment 2");
    check(model(&[], &[bond(0, Some(1)), bond(5, None)]), "bond 1 names fragment 5");
    let hull = HullView { positions: &CORNERS[..3], indices: &FACES };
    check(model(&[None, Some(hull)], &[]), "the hull of fragment 1");
    let mut lost = bond(0, Some(1));
    lost.centroid_m = [f64::NAN; 3];
    check(model(&[], &[lost]), "fragment 0: a bond is not finite");
}
