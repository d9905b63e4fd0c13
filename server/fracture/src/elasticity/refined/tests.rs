//! Refined bodies against closed forms, and against each other.

use super::*;
use crate::accuracy::Extrapolation;
use crate::lattice::block;
use crate::random::RandomStream;
use crate::reference::{kuhn, perturbed, traction};
use crate::simd::tests::same_on_every_path;
use nalgebra::{Matrix3, Point3, Vector3};

/// Order of the energy with linear elements on smooth problems.
const THEORY: f64 = 2.0;

pub(super) fn refined(lattice: &Lattice, poisson: f64, count: usize) -> RefinedBody {
    RefinedBody::new(lattice, poisson, count, &CancelToken::default()).unwrap()
}

/// Energies on levels 0, 1, 2 under the traction of a stress.
fn stressed(body: &RefinedBody, stress: &(dyn Fn(Point3<f64>) -> Matrix3<f64> + Sync)) -> [RefinedEnergy; 3] {
    [0, 1, 2].map(|level| {
        let lattice = body.lattice(level);
        let forces = |_: usize, _: &mut ElasticWorkspace| Ok(traction(lattice, stress));
        body.energies(level, 1, &forces, &CancelToken::default()).unwrap().remove(0)
    })
}

/// Stress that is linear in x and in equilibrium, so the exact one of a free block under its own traction.
struct LinearStress {
    mean: Matrix3<f64>,
    slopes: [Matrix3<f64>; 3],
}

impl LinearStress {
    fn random(stream: &mut RandomStream) -> Self {
        let mut symmetric = || {
            let own = Matrix3::from_fn(|_, _| stream.uniform() - 0.5);
            own + own.transpose()
        };
        let mean = symmetric() * 0.02;
        let mut slopes = [(); 3].map(|()| symmetric());
        for axis in 0..3 {
            let rest: f64 = (0..3).filter(|other| *other != axis).map(|other| slopes[other][(axis, other)]).sum();
            slopes[axis][(axis, axis)] = -rest;
        }
        Self { mean, slopes }
    }

    fn at(&self, place: Point3<f64>) -> Matrix3<f64> {
        self.mean + self.slopes[0] * place.x + self.slopes[1] * place.y + self.slopes[2] * place.z
    }

    /// Energy in a block of these sides about the origin: ½ ∫ σ:ε, with ∫ x² = V L²/12.
    fn energy(&self, sides: [f64; 3], poisson: f64) -> f64 {
        let density = |stress: &Matrix3<f64>| {
            let strain = stress * (1.0 + poisson) - Matrix3::from_diagonal_element(poisson * stress.trace());
            0.5 * stress.dot(&strain)
        };
        let volume: f64 = sides.iter().product();
        let bent: f64 = self.slopes.iter().zip(sides).map(|(slope, side)| density(slope) * side * side / 12.0).sum();
        volume * (density(&self.mean) + bent)
    }
}

#[test]
fn known_energies_lie_within_the_bars_of_extrapolated_ones() {
    let (mut inside, mut count) = (0, 0);
    let mut check = |body: &RefinedBody, exact: f64, stress: &(dyn Fn(Point3<f64>) -> Matrix3<f64> + Sync)| {
        let energies = stressed(body, stress).map(|own| own.energy);
        let found = Extrapolation::new(energies, THEORY);
        println!("{:?} {exact:.6}: {:.6} ± {:.1e}, order {:?}", energies, found.value, found.bar, found.order);
        (inside, count) = (inside + usize::from((found.value - exact).abs() <= found.bar), count + 1);
    };
    for seed in 0..16 {
        let mut stream = RandomStream::new(11, seed);
        let cells = [2 + seed as usize % 3, 2, 2 + (seed as usize / 3) % 2];
        let (spacing, poisson) = (0.25, [0.0, 0.2, 0.3][seed as usize % 3]);
        let body = refined(&perturbed(cells, spacing, 0.15, seed), poisson, 2);
        for _ in 0..3 {
            let stress = LinearStress::random(&mut stream);
            let exact = stress.energy(cells.map(|count| count as f64 * spacing), poisson);
            check(&body, exact, &|place| stress.at(place));
        }
    }
    // A beam in pure bending, on the lattice that locks most.
    let body = refined(&kuhn([6, 2, 2], 0.5), 0.3, 2);
    check(&body, 0.5 * 3.0 / 12.0, &|place| Matrix3::from_diagonal(&Vector3::new(place.z, 0.0, 0.0)));
    println!("{inside} of {count} inside their bars");
    assert!(count >= 40 && inside * 100 >= 95 * count, "{inside} of {count}");
}

/// Checks the order that the last three of these energies show, and that of the errors of the last two.
pub(super) fn check_order(what: &str, values: &[f64], exact: f64, theory: f64) {
    let errors: Vec<f64> = values.iter().map(|value| 1.0 - value / exact).collect();
    let &[.., third, second, first] = values else { panic!("{what}: three levels") };
    let &[.., coarse, fine] = &errors[..] else { panic!("{what}: two levels") };
    let (found, of_errors) = (Extrapolation::new([third, second, first], theory), (coarse / fine).log2());
    println!("{what}: order {:?}, of the errors {of_errors:.3}; {errors:?}", found.order);
    assert!((found.order.unwrap() - theory).abs() < 0.2 && (of_errors - theory).abs() < 0.2, "{what}: {found:?}");
    assert!((found.value - exact).abs() < found.bar, "{what}: {found:?}, {exact}");
}

/// Known energies on blocks of one cell. With 8 cells across, instead of 32, the order of bending is still 1.3 to 1.5.
#[test]
fn orders_are_those_of_the_theory() {
    let (mut stream, poisson) = (RandomStream::new(11, 3), 0.3);
    let body = refined(&perturbed([1, 1, 1], 0.5, 0.15, 2), poisson, 5);
    let check = |what: &str, exact: f64, stress: &(dyn Fn(Point3<f64>) -> Matrix3<f64> + Sync)| {
        let energy = |level: usize| {
            let forces = |_: usize, _: &mut ElasticWorkspace| Ok(traction(body.lattice(level), stress));
            body.energies(level, 1, &forces, &CancelToken::default()).unwrap()[0].energy
        };
        check_order(what, &[3, 4, 5].map(energy), exact, THEORY);
    };
    let any = LinearStress::random(&mut stream);
    check("random stress", any.energy([0.5; 3], poisson), &|place| any.at(place));
    let bend = |place: Point3<f64>| Matrix3::from_diagonal(&Vector3::new(place.z, 0.0, 0.0));
    check("bending", 0.5 * 0.5_f64.powi(5) / 12.0, &bend);
}

/// The load of the finest level acts on all of them, as contacts do.
#[test]
fn the_order_of_a_pushed_bar_is_that_of_the_theory() {
    let bar = refined(&block([4, 1, 1], 0.25), 0.0, 4);
    let push =
        |place: Point3<f64>| Matrix3::from_diagonal(&Vector3::new(if place.x > 0.499 { -1.0 } else { 0.0 }, 0.0, 0.0));
    let mut forces = traction(bar.lattice(4), push);
    bar.levels[3].inertia.relieve(&mut forces);
    let pushed = [2, 3, 4].map(|level| {
        let own = |_: usize, _: &mut ElasticWorkspace| {
            Ok(bar.levels[level..].iter().rev().fold(forces.clone(), |forces, own| own.restricted(&forces)))
        };
        bar.energies(level, 1, &own, &CancelToken::default()).unwrap()[0].energy
    });
    check_order("pushed bar", &pushed, 0.0625 / 6.0, THEORY);
}

#[test]
fn a_pulled_block_has_its_energy_on_all_levels() {
    let body = refined(&perturbed([3, 2, 2], 0.25, 0.2, 1), 0.25, 2);
    let pull = Matrix3::from_diagonal(&Vector3::new(1.0, 0.0, 0.0));
    for own in stressed(&body, &|_| pull) {
        assert!((own.energy / (0.5 * 0.1875) - 1.0).abs() < 1e-8, "{own:?}");
        let lattice = body.lattice(0);
        let shares = own.tets.iter().enumerate().map(|(tet, energy)| energy / (0.5 * lattice.tet_volume(tet)) - 1.0);
        assert!(shares.map(f64::abs).fold(0.0, f64::max) < 1e-4);
    }
}

#[test]
fn the_iteration_agrees_with_a_factor_of_the_same_lattice() {
    let coarse = perturbed([3, 3, 2], 0.2, 0.15, 6);
    let body = refined(&coarse, 0.3, 2);
    let contact = |y: f64, radius| ContactLoad {
        point: Point3::new(0.3, y, 0.02),
        impulse: Vector3::new(-1.0, 0.1, 0.2),
        radius,
    };
    let impacts: Vec<Vec<ContactLoad>> = (0..6).map(|k| vec![contact(0.05 * f64::from(k) - 0.1, 0.2)]).collect();
    for level in [1, 2] {
        let forces = |index: usize, workspace: &mut ElasticWorkspace| body.load(level, &impacts[index], workspace);
        let found = body.energies(level, impacts.len(), &forces, &CancelToken::default()).unwrap();
        let direct = Elasticity::prepare(body.lattice(level), 0.3, &CancelToken::default()).unwrap();
        for (own, contacts) in found.iter().zip(&impacts) {
            let (mut load, mut workspace) = (NodalLoad::default(), ElasticWorkspace::default());
            direct.load(contacts, &mut load, &mut workspace).unwrap();
            assert_eq!(load.touches[0].radius, 0.2);
            let mut displacement = Vec::new();
            direct.solve(&load.forces, &mut displacement, &mut workspace, &CancelToken::default()).unwrap();
            let wanted = direct.elastic_energy(&load.forces, &displacement);
            println!("level {level}: {} steps, {:.1e}", own.steps, own.energy / wanted - 1.0);
            assert!((own.energy / wanted - 1.0).abs() < 1e-7 && own.steps < 30, "{} for {wanted}", own.energy);
            assert!((own.tets.iter().sum::<f64>() / wanted - 1.0).abs() < 1e-6);
        }
    }
}

/// Contacts of about one spacing, against references of one more level.
#[test]
fn extrapolated_impacts_lie_within_their_bars() {
    let (mut inside, mut count, mut stream) = (0, 0, RandomStream::new(7, 0));
    for (lattice, radius) in [
        (perturbed([4, 4, 2], 0.1, 0.1, 1), 0.12),
        (perturbed([3, 3, 3], 0.1, 0.1, 2), 0.09),
        (perturbed([6, 2, 2], 0.1, 0.1, 3), 0.15),
    ] {
        let half = lattice.nodes.iter().fold(Vector3::zeros(), |most: Vector3<f64>, node| most.sup(&node.coords));
        let impacts: Vec<Vec<ContactLoad>> = (0..16)
            .map(|_| {
                let [x, y] = [(); 2].map(|()| 1.6 * stream.uniform() - 0.8);
                let point = Point3::new(x * half.x, y * half.y, half.z);
                vec![ContactLoad { point, impulse: Vector3::new(0.2, -0.1, -1.0), radius }]
            })
            .collect();
        let [low, high] = [2, 3].map(|count| {
            let body = refined(&lattice, 0.2, count);
            let levels: Vec<Vec<RefinedEnergy>> = (count - 2..=count)
                .map(|level| body.impact_energies(level, &impacts, &CancelToken::default()).unwrap())
                .collect();
            let bars = body.load_errors(&impacts, &levels[1], &CancelToken::default()).unwrap();
            let found = (0..impacts.len()).map(|index| {
                let values = [0, 1, 2].map(|level: usize| levels[level][index].energy);
                assert!(values[0] < values[1] && values[1] < values[2], "{values:?}");
                (Extrapolation::new(values, THEORY).widened(bars[index]), values, bars[index])
            });
            found.collect::<Vec<_>>()
        });
        for ((low, values, load), (high, ..)) in low.into_iter().zip(high) {
            println!(
                "{values:.6?} {:.6} ± {:.1e} (load {load:.1e}), order {:?}; {:.6} ± {:.1e}, order {:?}",
                low.value, low.bar, low.order, high.value, high.bar, high.order
            );
            (inside, count) = (inside + usize::from((low.value - high.value).abs() <= low.bar), count + 1);
        }
    }
    println!("{inside} of {count} inside their bars");
    assert!(inside * 100 >= 95 * count, "{inside} of {count}");
}

/// Plate of 1:30, one cell thick: the worst body for the smoother.
#[test]
fn thin_plates_converge() {
    let body = refined(&block([30, 30, 1], 1.0 / 30.0), 0.25, 1);
    let bend = |place: Point3<f64>| Matrix3::from_diagonal(&Vector3::new(place.z, place.z, 0.0));
    let forces = |_: usize, _: &mut ElasticWorkspace| Ok(traction(body.lattice(1), bend));
    let found = body.energies(1, 1, &forces, &CancelToken::default()).unwrap().remove(0);
    println!("{} steps", found.steps);
    assert!(found.steps < 100 && found.energy > 0.0, "{} steps", found.steps);
}

/// Coefficients of a displacement of degree two on a level with quadratic elements: of nodes, then of edges.
fn coefficients(lattice: &Lattice, field: &dyn Fn(&Point3<f64>) -> Vector3<f64>) -> Vec<f64> {
    let nodes = lattice.nodes.iter().map(field);
    let edge = |[a, b]: [u32; 2]| {
        let ends = [a, b].map(|node| &lattice.nodes[node as usize]);
        field(&nalgebra::center(ends[0], ends[1])) - (field(ends[0]) + field(ends[1])) * 0.5
    };
    nodes.chain(lattice.edges().into_iter().map(edge)).flat_map(|own| own.data.0[0]).collect()
}

/// Loads on the functions of a coarser level do the same work on displacements that both levels have.
#[test]
fn restricted_loads_do_the_same_work_on_quadratic_displacements() {
    let body = refined(&perturbed([2, 2, 1], 0.25, 0.15, 5), 0.3, 2).of_order(ElementOrder::Quadratic).unwrap();
    let mut stream = RandomStream::new(5, 0);
    for level in [0, 1] {
        for _ in 0..4 {
            let [a, b, c] = [(); 3].map(|()| Matrix3::from_fn(|_, _| stream.uniform() - 0.5));
            let field = |place: &Point3<f64>| {
                let x = place.coords;
                Vector3::new(x.dot(&(a * x)), x.dot(&(b * x)), x.dot(&(c * x))) + a * x + b.column(0)
            };
            let forces: Vec<f64> = (0..body.unknowns(level + 1)).map(|_| stream.uniform() - 0.5).collect();
            let work = |forces: &[f64], level: usize| -> f64 {
                let moved = coefficients(body.lattice(level), &field);
                assert_eq!(moved.len(), forces.len());
                forces.iter().zip(&moved).map(|(force, moved)| force * moved).sum()
            };
            let [fine, coarse] = [work(&forces, level + 1), work(&body.restricted(level, &forces), level)];
            assert!((fine - coarse).abs() < 1e-12 * forces.len() as f64, "{fine} {coarse}");
        }
    }
}

#[test]
fn quadratic_elements_agree_with_those_of_the_same_lattice() {
    let body = refined(&perturbed([3, 3, 2], 0.2, 0.15, 6), 0.3, 1).of_order(ElementOrder::Quadratic).unwrap();
    let contact =
        |y: f64| ContactLoad { point: Point3::new(0.3, y, 0.02), impulse: Vector3::new(-1.0, 0.1, 0.2), radius: 0.25 };
    let impacts: Vec<Vec<ContactLoad>> = (0..6).map(|k| vec![contact(0.05 * f64::from(k) - 0.1)]).collect();
    for level in [0, 1] {
        let forces = |index: usize, workspace: &mut ElasticWorkspace| body.load(level, &impacts[index], workspace);
        let found = body.energies(level, impacts.len(), &forces, &CancelToken::default()).unwrap();
        let lattice = body.lattice(level);
        let direct = Elasticity::prepare(lattice, 0.3, &CancelToken::default()).unwrap();
        let direct = direct.of_order(ElementOrder::Quadratic, lattice).unwrap();
        assert_eq!(body.unknowns(level), direct.unknowns());
        for (own, contacts) in found.iter().zip(&impacts) {
            let (mut load, mut workspace) = (NodalLoad::default(), ElasticWorkspace::default());
            direct.load(contacts, &mut load, &mut workspace).unwrap();
            assert_eq!(load.touches[0].radius, 0.25);
            let mut displacement = Vec::new();
            direct.solve(&load.forces, &mut displacement, &mut workspace, &CancelToken::default()).unwrap();
            let wanted = direct.elastic_energy(&load.forces, &displacement);
            println!("level {level}: {} steps, {:.1e}", own.steps, own.energy / wanted - 1.0);
            assert!((own.energy / wanted - 1.0).abs() < 3e-4 && own.steps < 40, "{} for {wanted}", own.energy);
            assert!((own.tets.iter().sum::<f64>() / own.energy - 1.0).abs() < 1e-4);
        }
    }
    // The spaces are nested, so energies of one load grow with the level.
    let [coarse, fine] = [0, 1].map(|level| body.impact_energies(level, &impacts, &CancelToken::default()).unwrap());
    assert!(
        coarse.iter().zip(&fine).all(|(coarse, fine)| coarse.energy < fine.energy && fine.energy < 1.2 * coarse.energy)
    );
}

#[test]
fn energies_do_not_depend_on_the_number_of_threads() {
    let linear = || refined(&perturbed([2, 2, 2], 0.25, 0.1, 3), 0.3, 2);
    for body in [linear(), linear().of_order(ElementOrder::Quadratic).unwrap()] {
        check_threads(&body);
    }
}

fn check_threads(body: &RefinedBody) {
    let impact = |k: u32| {
        let point = Point3::new(0.25, 0.05 * f64::from(k) - 0.1, 0.0);
        vec![ContactLoad { point, impulse: -Vector3::x(), radius: 0.2 }]
    };
    let impacts: Vec<_> = (0..9).map(impact).collect();
    let found = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| body.impact_energies(2, &impacts, &CancelToken::default()).unwrap())
    });
    assert_eq!(found[0], found[1]);
}

#[test]
fn wide_and_plain_instructions_give_the_same_bits() {
    let linear = || refined(&perturbed([2, 2, 2], 0.25, 0.1, 3), 0.3, 1);
    let contact = ContactLoad { point: Point3::new(0.25, 0.05, 0.0), impulse: -Vector3::x(), radius: 0.2 };
    for body in [linear(), linear().of_order(ElementOrder::Quadratic).unwrap()] {
        let plain = same_on_every_path(|| body.impact_energies(1, &[vec![contact]], &CancelToken::default()).unwrap());
        assert!(plain[0].energy > 0.0 && plain[0].steps > 1);
    }
}
