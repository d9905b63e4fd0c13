//! The model by itself; `shatter-tests` reads it as XML, and steps it where Python has MuJoCo.

use super::*;
use nalgebra::{Matrix3, Rotation3, Vector3};

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
