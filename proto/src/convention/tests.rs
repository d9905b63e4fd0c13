use super::*;
use proptest::prelude::*;

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn det([a, b, c]: [[f64; 3]; 3]) -> f64 {
    dot(a, cross(b, c))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

/// The symmetric tensor times a vector.
fn times([xx, yy, zz, xy, xz, yz]: [f64; 6], v: [f64; 3]) -> [f64; 3] {
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(|row| dot(row, v))
}

fn any_convention() -> impl Strategy<Value = Convention> {
    let up = prop_oneof![Just(Up::Y), Just(Up::Z)];
    let hand = prop_oneof![Just(Hand::Right), Just(Hand::Left)];
    let winding = prop_oneof![Just(Winding::CounterClockwise), Just(Winding::Clockwise)];
    // Powers of two, so that ways there and back are exact.
    (up, hand, winding, -9i32..9).prop_map(|(up, hand, winding, power)| Convention {
        up,
        hand,
        winding,
        meters_per_unit: f64::from(power).exp2(),
    })
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [-9.0..9.0, -9.0..9.0, -9.0..9.0]
}

/// The named ones, their up axis, whether they reflect, and what points up in them.
#[test]
fn named_conventions_match_their_hosts() {
    let check = |name: &str, up: usize, left: bool, clockwise: bool, meters_per_unit: f64| {
        let convention = Convention::by_name(name).unwrap();
        let found = convention.direction(AXES[1]);
        assert_eq!(found, AXES[up], "{name}: our +Y");
        assert_eq!(det(AXES.map(|axis| convention.direction(axis))), if left { -1.0 } else { 1.0 }, "{name}");
        assert_eq!((convention.is_clockwise(), convention.meters_per_unit), (clockwise, meters_per_unit), "{name}");
    };
    check("gltf", 1, false, false, 1.0);
    check("godot", 1, false, true, 1.0);
    check("unity", 1, true, true, 1.0);
    check("unreal", 2, true, false, 0.01);
    check("blender", 2, false, false, 1.0);
    check("mujoco", 2, false, false, 1.0);
    let forward = AXES[2];
    assert_eq!(Convention::UNITY.direction(forward), forward, "+Z stays forward");
    let error = Convention::by_name("maya").unwrap_err();
    assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Convention, "convention"));
    assert!(Convention::default().is_default() && !Convention::GODOT.is_default());
}

#[test]
fn the_default_convention_is_the_identity() {
    let gltf = Convention::GLTF;
    let bits = |vector: [f64; 3]| vector.map(f64::to_bits);
    let odd = [-0.0, f64::MIN_POSITIVE / 3.0, 1.0 / 3.0];
    for found in [gltf.vector(odd), gltf.our_vector(odd), gltf.axial(odd), gltf.direction(odd)] {
        assert_eq!(bits(found), bits(odd));
    }
    let single = odd.map(|x| x as f32);
    assert_eq!(gltf.vector_f32(single).map(f32::to_bits), single.map(f32::to_bits));
    let tensor = [1.0 / 3.0, 0.1, 0.7, -0.0, -1.0 / 7.0, 1e-300];
    assert_eq!(gltf.inertia(tensor).map(f64::to_bits), tensor.map(f64::to_bits));
    assert_eq!([gltf.square(odd[2]), gltf.cube(odd[2]), gltf.length(odd[2])], [odd[2]; 3]);
}

#[test]
fn unreal_counts_in_centimeters() {
    let unreal = Convention::UNREAL;
    assert_eq!(unreal.vector([0.5, 2.0, -0.25]), [50.0, -25.0, 200.0]);
    assert_eq!(unreal.our_vector([50.0, -25.0, 200.0]), [0.5, 2.0, -0.25]);
    assert_eq!((unreal.square(1.0), unreal.cube(1.0)), (1e4, 1e6));
    assert_eq!(unreal.inertia([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), [1e4, 3e4, 2e4, 5e4, 4e4, 6e4]);
}

proptest! {
    #[test]
    fn conversions_and_their_inverses_cancel(convention in any_convention(), v in vector(), w in vector()) {
        let tensor = [v[0], v[1], v[2], w[0], w[1], w[2]];
        prop_assert_eq!(convention.our_vector(convention.vector(v)), v);
        prop_assert_eq!(convention.our_direction(convention.direction(v)), v);
        prop_assert_eq!(convention.our_axial(convention.axial(v)), v);
        prop_assert_eq!(convention.our_inertia(convention.inertia(tensor)), tensor);
        let single = v.map(|x| x as f32);
        prop_assert_eq!(convention.our_vector_f32(convention.vector_f32(single)), single);
        prop_assert_eq!(convention.meters3(convention.cube(v[0])), v[0]);
        prop_assert_eq!(convention.meters2(convention.square(v[0])), v[0]);
    }

    /// Mechanics holds in the host's numbers as in ours.
    #[test]
    fn velocities_energies_and_areas_agree(convention in any_convention(), r in vector(), omega in vector(), n in vector()) {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + a.abs());
        let theirs = cross(convention.axial(omega), convention.vector(r));
        let ours = convention.vector(cross(omega, r));
        prop_assert!((0..3).all(|k| close(theirs[k], ours[k])), "v = ω × r: {theirs:?} and {ours:?}");
        let tensor = [3.0 + n[0] * n[0], 4.0, 5.0, r[0], r[1], n[2]];
        let spin = |tensor: [f64; 6], omega: [f64; 3]| dot(omega, times(tensor, omega));
        let theirs = spin(convention.inertia(tensor), convention.axial(omega));
        prop_assert!(close(theirs, convention.square(spin(tensor, omega))), "ω·Iω");
        prop_assert!(close(dot(convention.direction(n), convention.vector(r)), convention.length(dot(n, r))));
    }

    #[test]
    fn conventions_round_trip(convention in any_convention()) {
        let mut wire: RequestWire = bytemuck::Zeroable::zeroed();
        wire.set_convention(&convention).unwrap();
        prop_assert_eq!(wire.convention().unwrap(), convention);
    }
}

#[test]
fn invalid_units_are_rejected_by_client_and_daemon() {
    let mut wire: RequestWire = bytemuck::Zeroable::zeroed();
    assert_eq!(wire.convention().unwrap(), Convention::GLTF, "all zero is the default");
    for meters_per_unit in [0.0, -1.0, 1e-7, 1e7, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE] {
        let error = wire.set_convention(&Convention { meters_per_unit, ..Convention::UNITY }).unwrap_err();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Convention, "convention.meters_per_unit"));
        wire.convention_meters_per_unit = meters_per_unit;
        let zero = meters_per_unit == 0.0;
        assert_eq!(wire.convention().is_ok(), zero, "{meters_per_unit}: on the wire zero is the default");
    }
}
