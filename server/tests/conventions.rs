//! Coordinates of hosts through the whole service: requests and results in a host's coordinates equal those in the default ones. The
//! relation of the two is stated here a second time, by matrices.

mod support;

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use shatter_client::{
    Client, Contact, ContactPartner, Convention, DegreeRule, Effect, ErrorKind, FractureResult, Hand, Impact, Object,
    Up, Winding,
};
use shatter_engine::scene::Scene;
use shatter_proto::view::ResultView;
use std::path::Path;
use std::sync::{Arc, LazyLock};
use support::{InProcess, TestDirectory, bar, timeout};

/// Database of a bar, baked once for all tests: the bytes of the file.
static BAR: LazyLock<Vec<u8>> = LazyLock::new(|| bar(0.05));

/// All effects with output, and the one that holds an end of the bar.
const EFFECTS: [Effect; 9] = [
    Effect::Anchored,
    Effect::Release,
    Effect::Normals,
    Effect::Uv,
    Effect::Bonds,
    Effect::Debris,
    Effect::Hulls,
    Effect::Attributes,
    Effect::Skin,
];

/// Relative difference of numbers that were rounded twice from one double to single precision, at most.
const SINGLE: f64 = 2.5e-7;

/// As [`SINGLE`], for doubles that were multiplied a few times.
const DOUBLE: f64 = 1e-14;

/// A convention and its definition: the host's axes as combinations of the default ones.
struct Host {
    name: &'static str,
    convention: Convention,
    axes: Matrix3<f64>,
    unit: f64,
    clockwise: bool,
}

fn hosts() -> Vec<Host> {
    let [unity, blender, unreal] = [
        Matrix3::new(-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
        Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0),
    ];
    let host = |name, convention, axes, unit, clockwise| Host { name, convention, axes, unit, clockwise };
    let inches = Convention { winding: Winding::Clockwise, meters_per_unit: 0.0254, ..Convention::BLENDER };
    let kilometers = Convention { up: Up::Y, hand: Hand::Left, meters_per_unit: 1e3, ..Convention::GLTF };
    vec![
        host("gltf", Convention::GLTF, Matrix3::identity(), 1.0, false),
        host("godot", Convention::GODOT, Matrix3::identity(), 1.0, true),
        host("unity", Convention::UNITY, unity, 1.0, true),
        host("unreal", Convention::UNREAL, unreal, 0.01, false),
        host("blender", Convention::BLENDER, blender, 1.0, false),
        host("mujoco", Convention::MUJOCO, blender, 1.0, false),
        host("inches", inches, blender, 0.0254, true),
        host("kilometers", kilometers, unity, 1e3, false),
    ]
}

/// Starts a daemon with the bar, one end of which is held if a request enables that.
fn start() -> (InProcess, Client) {
    let here = TestDirectory::new("conventions");
    std::fs::write(here.databases().join("bar.shatter"), BAR.as_slice()).unwrap();
    let names = EFFECTS.map(|effect| format!("\"{}\"", effect.name())).join(", ");
    let anchor = "{ min = [-0.3, -0.3, -0.3], max = [-0.15, 0.3, 0.3] }";
    let scene = format!("[objects.bar]\nallow = [{names}]\nanchors = [{anchor}]");
    let load = shatter_engine::wire::loader(Some(Scene::parse(&scene, Path::new("")).unwrap()));
    let daemon = InProcess::start_with(here, "", Arc::new(move |path, _| load(path, Some("bar"))));
    let service = daemon.connect();
    (daemon, service)
}

fn object(service: &Client, convention: Convention) -> Object {
    service.with_convention(convention).object("bar", timeout()).unwrap()
}

fn strike(bar: &Object, impact: &Impact) -> FractureResult {
    bar.strike(impact).unwrap().wait(timeout()).unwrap()
}

/// One impact in the host's coordinates and in the default ones. The host's numbers are exact, so that both are the same impact.
struct ImpactPair {
    theirs: Impact,
    ours: Impact,
}

impl Host {
    /// The impact `impulse_ns` at `point_m`.
    fn impact_pair(&self, point_m: [f64; 3], impulse_ns: [f64; 3], sites: u32, effects: &[Effect]) -> ImpactPair {
        let [point, impulse] = [point_m, impulse_ns].map(|vector| self.axes * Vector3::from(vector) / self.unit);
        let ours = |vector: Vector3<f64>| -> [f64; 3] { (self.axes.transpose() * vector * self.unit).into() };
        let radius = 0.05 / self.unit;
        let asked = |point: [f64; 3], impulse: [f64; 3], radius: f64| {
            let impact = Impact::new([Contact::new(point).impulse(impulse).radius(radius)])
                .degree(DegreeRule::Sites(sites))
                .seed(3)
                .keep();
            effects.iter().fold(impact, |impact, effect| impact.enable(*effect))
        };
        ImpactPair {
            theirs: asked(point.into(), impulse.into(), radius),
            ours: asked(ours(point), ours(impulse), radius * self.unit),
        }
    }

    /// The host's vector in m along the default axes.
    fn vector(&self, vector: [f64; 3]) -> Vector3<f64> {
        self.axes * Vector3::from(vector) / self.unit
    }

    fn direction(&self, vector: [f64; 3]) -> Vector3<f64> {
        self.axes * Vector3::from(vector)
    }

    /// Sign of the sum of det(a, b, c) over the triangles of a body.
    fn sign(&self) -> f64 {
        self.axes.determinant() * if self.clockwise { -1.0 } else { 1.0 }
    }

    #[track_caller]
    fn same(&self, what: &str, theirs: f64, ours: f64, tolerance: f64) {
        let name = self.name;
        let tolerance = if self.unit == 1.0 { 0.0 } else { tolerance };
        assert!((theirs - ours).abs() <= tolerance * ours.abs(), "{name}: {what}: {theirs:e} and {ours:e}");
    }

    #[track_caller]
    fn close(&self, what: &str, theirs: [f64; 3], ours: Vector3<f64>, tolerance: f64) {
        (0..3).for_each(|k| self.same(what, theirs[k], ours[k], tolerance));
    }

    #[track_caller]
    fn offsets(&self, what: &str, theirs: [f32; 3], ours: [f32; 3]) {
        self.close(what, theirs.map(f64::from), self.vector(ours.map(f64::from)), SINGLE);
    }

    #[track_caller]
    fn normals(&self, what: &str, theirs: [f32; 3], ours: [f32; 3]) {
        // Directions have no unit, so that they are equal bitwise.
        assert_eq!(Vector3::from(theirs.map(f64::from)), self.direction(ours.map(f64::from)), "{}: {what}", self.name);
    }

    #[track_caller]
    fn indices(&self, what: &str, theirs: &[u32], ours: &[u32]) {
        let turned = |corners: &[u32]| [corners[0], corners[2], corners[1]];
        let ours: Vec<u32> = match self.clockwise {
            true => ours.chunks_exact(3).flat_map(turned).collect(),
            false => ours.to_vec(),
        };
        assert_eq!(theirs, ours, "{}: {what}", self.name);
    }
}

fn tensor([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

fn ascending(tensor: Matrix3<f64>) -> [f64; 3] {
    let mut values: [f64; 3] = SymmetricEigen::new(tensor).eigenvalues.into();
    values.sort_by(f64::total_cmp);
    values
}

/// Six times the volume inside triangles, with the sign of det(a, b, c).
fn volume6(positions: &[[f32; 3]], indices: &[u32]) -> f64 {
    let corner = |index: u32| Vector3::from(positions[index as usize].map(f64::from));
    indices.chunks_exact(3).map(|t| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2])))).sum()
}

/// Compares every section of `theirs` with `ours`.
#[track_caller]
fn compare(host: &Host, theirs: &ResultView<'_>, ours: &ResultView<'_>) {
    tables(host, theirs, ours);
    meshes(host, theirs, ours);
    beside(host, theirs, ours);
    assert_eq!(theirs.runs, ours.runs);
    assert_eq!(theirs.merges, ours.merges);
    assert_eq!(theirs.uvs, ours.uvs, "{}: textures are attached to points and measured in meters", host.name);
    assert_eq!((theirs.materials, theirs.skin_materials), (ours.materials, ours.skin_materials));
    assert_eq!(theirs.skins, ours.skins);
    host.same("radius", theirs.summary.radius_m, ours.summary.radius_m / host.unit, DOUBLE);
    assert_eq!(theirs.summary.e1_over_gamma, ours.summary.e1_over_gamma, "{}: not the same impact", host.name);
}

#[track_caller]
fn tables(host: &Host, theirs: &ResultView<'_>, ours: &ResultView<'_>) {
    let (unit, axes) = (host.unit, host.axes);
    assert_eq!((theirs.fragments.len(), theirs.velocities.len()), (ours.fragments.len(), ours.velocities.len()));
    for (theirs, ours) in theirs.fragments.iter().zip(ours.fragments) {
        assert_eq!((theirs.mass_kg, theirs.energy_j_m2), (ours.mass_kg, ours.energy_j_m2));
        host.same("volume", theirs.volume_m3, ours.volume_m3 / unit.powi(3), DOUBLE);
        host.close("center", theirs.center_m, host.vector(ours.center_m), DOUBLE);
        let (found, given) = (tensor(theirs.inertia_kg_m2), tensor(ours.inertia_kg_m2));
        let turned = axes * given * axes.transpose() / (unit * unit);
        found.iter().zip(&turned).for_each(|(theirs, ours)| host.same("inertia", *theirs, *ours, DOUBLE));
        for (theirs, ours) in ascending(found).into_iter().zip(ascending(given)) {
            let ours = ours / (unit * unit);
            assert!((theirs / ours - 1.0).abs() < 1e-12, "{}: principal moments {theirs} and {ours}", host.name);
        }
    }
    for (theirs, ours) in theirs.velocities.iter().zip(ours.velocities) {
        host.close("velocity", theirs.linear_m_s, host.vector(ours.linear_m_s), DOUBLE);
        let axial = host.direction(ours.angular_rad_s) * axes.determinant();
        host.close("angular velocity", theirs.angular_rad_s, axial, 0.0);
    }
}

#[track_caller]
fn meshes(host: &Host, theirs: &ResultView<'_>, ours: &ResultView<'_>) {
    let pairs = |theirs: &[[f32; 3]], ours: &[[f32; 3]]| {
        assert_eq!(theirs.len(), ours.len());
        theirs.iter().copied().zip(ours.iter().copied()).collect::<Vec<_>>()
    };
    for (theirs, ours) in pairs(theirs.positions, ours.positions) {
        host.offsets("position", theirs, ours);
    }
    for (theirs, ours) in pairs(theirs.hull_positions, ours.hull_positions) {
        host.offsets("hull", theirs, ours);
    }
    for (theirs, ours) in pairs(theirs.normals, ours.normals) {
        host.normals("normal", theirs, ours);
    }
    host.indices("indices", theirs.indices, ours.indices);
    host.indices("hull indices", theirs.hull_indices, ours.hull_indices);
    host.indices("skin indices", theirs.skin_indices, ours.skin_indices);
    for (theirs, ours) in theirs.outer_attributes.iter().zip(ours.outer_attributes) {
        host.normals("look", theirs.normal, ours.normal);
        assert_eq!(theirs.uv, ours.uv);
    }
    for (theirs, ours) in theirs.skin_vertices.iter().zip(ours.skin_vertices) {
        host.offsets("skin", theirs.position_m, ours.position_m);
        host.normals("normal of the skin", theirs.normal, ours.normal);
        assert_eq!(theirs.uv, ours.uv);
    }
    assert_eq!(
        (theirs.outer_attributes.len(), theirs.skin_vertices.len()),
        (ours.outer_attributes.len(), ours.skin_vertices.len())
    );
}

#[track_caller]
fn beside(host: &Host, theirs: &ResultView<'_>, ours: &ResultView<'_>) {
    let counts = |view: &ResultView<'_>| (view.bonds.len(), view.debris.len(), view.hulls.len());
    assert_eq!(counts(theirs), counts(ours));
    for (theirs, ours) in theirs.bonds.iter().zip(ours.bonds) {
        assert_eq!(theirs.fragments, ours.fragments);
        host.same("area of a bond", theirs.area_m2, ours.area_m2 / host.unit.powi(2), DOUBLE);
        host.close("normal of a bond", theirs.normal, host.direction(ours.normal), 0.0);
        host.close("centroid of a bond", theirs.centroid_m, host.vector(ours.centroid_m), DOUBLE);
    }
    for (theirs, ours) in theirs.debris.iter().zip(ours.debris) {
        host.offsets("debris", theirs.position_m, ours.position_m);
        host.normals("normal of debris", theirs.normal, ours.normal);
        host.same("size of debris", theirs.size_m.into(), f64::from(ours.size_m) / host.unit, SINGLE);
    }
    for (theirs, ours) in theirs.hulls.iter().zip(ours.hulls) {
        assert_eq!((theirs.index_count, theirs.coverage), (ours.index_count, ours.coverage));
        host.same("margin of a hull", theirs.margin_m, ours.margin_m / host.unit, DOUBLE);
    }
}

/// Checks a result by itself: closed, correctly oriented, with the volumes and centers of its table.
#[track_caller]
fn check_alone(host: &Host, result: &FractureResult) {
    for fragment in result.fragments() {
        let (positions, indices) = (fragment.positions(), fragment.indices());
        assert!(fragment.is_closed(), "{}", host.name);
        let volume = volume6(positions, indices) / 6.0;
        assert!((host.sign() * volume / fragment.volume_m3() - 1.0).abs() < 1e-4, "{}: {volume}", host.name);
        if let Some(hull) = fragment.hull() {
            assert!(host.sign() * volume6(hull.positions, hull.indices) > 0.0, "{}: a hull inside out", host.name);
        }
        let corner = |index: u32| Vector3::from(positions[index as usize].map(f64::from));
        let faces = indices.chunks_exact(3).map(|t| {
            let [a, b, c] = [0, 1, 2].map(|k| corner(t[k]));
            let normal = Vector3::from(fragment.normals()[t[0] as usize].map(f64::from));
            let area = (b - a).cross(&(c - a)) * host.sign();
            (area.dot(&normal), area.norm())
        });
        let (along, area) = faces.fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
        assert!(along > 0.8 * area, "{}: {along} of {area} faces where its normals point", host.name);
    }
}

const POINT_M: [f64; 3] = [0.2, 0.03, -0.02];
const IMPULSE_NS: [f64; 3] = [-50.0, 3.0, -4.0];

#[test]
fn results_in_a_convention_equal_converted_results() {
    let (_daemon, service) = start();
    let ours = object(&service, Convention::GLTF);
    for host in hosts() {
        let ImpactPair { theirs: asked, ours: same } = host.impact_pair(POINT_M, IMPULSE_NS, 16, &EFFECTS);
        let (theirs, ours) = (strike(&object(&service, host.convention), &asked), strike(&ours, &same));
        assert_eq!(theirs.convention(), host.convention);
        compare(&host, &theirs.raw_view(), &ours.raw_view());
        check_alone(&host, &theirs);
        let view = theirs.raw_view();
        assert!(view.bonds.iter().any(|bond| bond.holds_to_world()) && !view.debris.is_empty());
        assert!(view.velocities.iter().any(|own| own.angular_rad_s.iter().all(|x| *x != 0.0)));
        assert!(!view.outer_attributes.is_empty() && !view.skin_vertices.is_empty() && !view.hull_indices.is_empty());
        if host.convention.is_default() {
            assert_eq!(theirs.digest(), ours.digest());
            // A host without a convention gets the default one.
            let silent = service.object("bar", timeout()).unwrap();
            assert_eq!(strike(&silent, &asked).digest(), ours.digest());
        }
    }
}

/// The energy of a partner that rotates is the same in all coordinates.
#[test]
fn partners_have_the_energy_of_converted_partners() {
    let (_daemon, service) = start();
    let bar = object(&service, Convention::GLTF);
    let inertia = Matrix3::new(2e-3, 3e-4, -2e-4, 3e-4, 3e-3, 5e-4, -2e-4, 5e-4, 4e-3);
    let (center_m, speed_m_s) = (Vector3::new(0.25, 0.1, -0.06), 4.0);
    let struck = |object: &Object, [point, impulse, center]: [Vector3<f64>; 3], inertia: Matrix3<f64>, unit: f64| {
        let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|entry| inertia[entry]);
        let partner = ContactPartner::new(1, 0.5, speed_m_s / unit).rotating(center.into(), entries);
        let contact = Contact::new(point.into()).impulse(impulse.into()).radius(0.05 / unit).partner(partner);
        strike(object, &Impact::new([contact])).summary()
    };
    let vectors = [Vector3::from(POINT_M), Vector3::from(IMPULSE_NS), center_m];
    let ours = struck(&bar, vectors, inertia, 1.0);
    let energy_j = ours.impactor_j.unwrap();
    assert!(energy_j > 0.1 && ours.load_factor.unwrap() < 0.9, "{ours:?}");
    for host in hosts() {
        let vectors = vectors.map(|vector| host.axes * vector / host.unit);
        let inertia = host.axes * inertia * host.axes.transpose() / host.unit.powi(2);
        let theirs = struck(&object(&service, host.convention), vectors, inertia, host.unit);
        for (own, wanted) in [(theirs.impactor_j, energy_j), (theirs.strain_j, ours.strain_j.unwrap())] {
            assert!((own.unwrap() / wanted - 1.0).abs() < 1e-9, "{}: {own:?} of {wanted} J", host.name);
        }
    }
}

/// The heaviest fragment that no anchor holds, and the point of its surface with the largest x of the default axes.
fn loose(result: &FractureResult) -> (u32, [f64; 3]) {
    let held = |id: u32| result.bonds().any(|bond| bond.is_with_world() && bond.fragment == id);
    let loose = result.fragments().filter(|fragment| !held(fragment.id()));
    let fragment = loose.max_by(|a, b| a.mass_kg().total_cmp(&b.mass_kg())).unwrap();
    let farthest = fragment.positions().iter().max_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
    (fragment.id(), [0, 1, 2].map(|k| fragment.center_m()[k] + f64::from(farthest[k])))
}

#[test]
fn a_second_strike_has_the_convention_of_its_own_request() {
    let (_daemon, service) = start();
    let ours = object(&service, Convention::GLTF);
    for host in hosts() {
        let first = host.impact_pair(POINT_M, IMPULSE_NS, 6, &EFFECTS);
        // The result is kept in other coordinates than those of the next request.
        let result = strike(&ours, &first.ours);
        let (fragment, point_m) = loose(&result);
        // Anchors do not hold fragments of a kept result.
        let ImpactPair { theirs: asked, ours: same } = host.impact_pair(point_m, [-40.0, 1.0, 2.0], 5, &EFFECTS[1..]);
        let again = |impact: Impact| impact.from(result.handle().unwrap(), fragment);
        let theirs = strike(&object(&service, host.convention), &again(asked));
        let ours = strike(&ours, &again(same));
        assert!(theirs.fragments().len() >= 5);
        compare(&host, &theirs.raw_view(), &ours.raw_view());
        check_alone(&host, &theirs);
    }
}

#[test]
fn files_are_gltf_whatever_the_convention() {
    let (_daemon, service) = start();
    let folder = tempfile::tempdir().unwrap();
    let written = |result: &FractureResult| {
        let path = folder.path().join("a.glb");
        result.write_glb(&path).unwrap();
        let fragments = std::fs::read(&path).unwrap();
        result.write_hulls_glb(&path).unwrap();
        let hulls = std::fs::read(&path).unwrap();
        result.write_skins_glb(&path).unwrap();
        [fragments, hulls, std::fs::read(&path).unwrap()]
    };
    let ours = object(&service, Convention::GLTF);
    for host in hosts() {
        let ImpactPair { theirs: asked, ours: same } = host.impact_pair(POINT_M, IMPULSE_NS, 16, &EFFECTS);
        let (theirs, ours) = (strike(&object(&service, host.convention), &asked), strike(&ours, &same));
        let gltf =
            Host { convention: Convention::GLTF, axes: Matrix3::identity(), clockwise: false, unit: 1.0, ..host };
        if host.unit == 1.0 {
            compare(&gltf, &theirs.metric().raw_view(), &ours.raw_view());
            assert!(written(&theirs) == written(&ours), "{}: other files", host.name);
        }
        let metric = theirs.metric();
        for (theirs, ours) in metric.fragments().zip(ours.fragments()) {
            assert_eq!((theirs.indices(), theirs.runs().len()), (ours.indices(), ours.runs().len()));
            assert!((theirs.volume_m3() / ours.volume_m3() - 1.0).abs() < DOUBLE);
            for (theirs, ours) in theirs.positions().iter().zip(ours.positions()) {
                let close = |k: usize| f64::from((theirs[k] - ours[k]).abs()) <= SINGLE * f64::from(ours[k].abs());
                assert!((0..3).all(close), "{}: {theirs:?} and {ours:?}", host.name);
            }
        }
    }
}

#[test]
fn invalid_conventions_are_rejected_by_name() {
    let (_daemon, service) = start();
    for meters_per_unit in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e9] {
        let bar = object(&service, Convention { meters_per_unit, ..Convention::UNREAL });
        let error = bar.strike(&Impact::new([Contact::new(POINT_M).impulse(IMPULSE_NS)])).err().unwrap();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::Convention, "convention.meters_per_unit"));
    }
    // A meter from the center of the bar.
    let far = Impact::new([Contact::new([100.0, 0.0, 0.0]).impulse([-50.0, 0.0, 0.0])]);
    let error = object(&service, Convention::UNREAL).strike(&far).and_then(|mut ticket| ticket.wait(timeout()));
    assert_eq!(error.err().unwrap().kind, ErrorKind::ContactTooFar);
}

#[test]
fn even_pieces_are_asked_for_in_the_hosts_numbers() {
    let (_daemon, service) = start();
    for host in hosts() {
        let bar = object(&service, host.convention);
        let even = strike(&bar, &bar.even(12, timeout()).unwrap());
        let (metric, diagonals) = (even.metric(), 1e3 * bar.facts().diagonal_m);
        let (name, radius_m) = (host.name, metric.raw_view().summary.radius_m);
        println!("{name}: {} pieces, radius {radius_m} m", even.fragments().count());
        assert!(even.fragments().count() == 12 && (radius_m / diagonals - 1.0).abs() < DOUBLE, "{name}: {radius_m} m");
    }
}
