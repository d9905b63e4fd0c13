//! Bodies so thin that the grid over the bounding box would be too large once they are turned, against closed forms.

use super::closed_forms::{disc, free_plate};
use super::walls::{baked, ring_ratio, struck, turns};
use super::*;
use crate::pipeline::ElementChoice;
use nalgebra::Rotation3;

#[test]
fn a_turned_tube_of_radius_over_thickness_50_bends_as_a_ring_does() {
    let ratio = ring_ratio(turns()[1], ElementChoice::Auto, 0.01);
    println!("tube, radius over thickness 50: {ratio:.4} of the closed form");
    assert!((0.95..1.05).contains(&ratio), "{ratio}");
}

/// Energy of a free disc of 1:100 struck in its middle, over that of Kirchhoff's plate; cells across, spacing in m.
fn disc_ratio(turn: Rotation3<f64>) -> [f64; 3] {
    let (radius, thick) = (0.5, 0.01);
    let prepared = baked(&disc(radius, thick), turn, ElementChoice::Auto);
    let exact = free_plate(radius, thick, prepared.parameters.material.poisson) * prepared.frame.diagonal_m;
    let force = (Point3::new(0.0, 0.0, 0.5 * thick), -Vector3::z());
    let ratio = struck(&prepared, turn, &[force], 0.01) / exact;
    let across = prepared.report.elements_across().unwrap();
    [ratio, across, prepared.parameters.crack_spacing * prepared.frame.diagonal_m]
}

#[test]
#[ignore = "minutes: 60,000 nodes, four times"]
fn turned_discs_of_1_to_100_bend_as_plates_do() {
    let [straight, across, spacing_m] = disc_ratio(Rotation3::identity());
    println!("disc 1:100, straight: {straight:.4} of the closed form, {across:.3} across, spacing {spacing_m:.5} m");
    let third = Rotation3::from_euler_angles(0.9, -0.2, 0.3);
    for turn in [turns()[1], turns()[2], third] {
        let own = disc_ratio(turn);
        println!("disc 1:100, turned: {:.4} of the closed form, {:.3} across, spacing {:.5} m", own[0], own[1], own[2]);
        assert!((own[0] - 1.0).abs() < 0.05, "{own:?}");
        assert!((own[1] / across - 1.0).abs() < 1e-3 && (own[2] / spacing_m - 1.0).abs() < 1e-3, "{own:?}");
    }
}
