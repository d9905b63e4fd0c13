//! Consistent mass, vibrations and responses to pulses, against closed forms and against steps in time.

use super::*;
use crate::elasticity::residual::{dot, unit};
use faer::MatRef;
use std::f64::consts::PI;

/// Displacements of `body` under some loads, made orthonormal in energy.
struct Span {
    displacements: Vec<f64>,
    modes: ReducedModes,
}

impl Span {
    fn new(lattice: &Lattice, body: &Elasticity, loads: &[NodalLoad]) -> Self {
        let columns = body.solve_all(loads, &CancelToken::default()).unwrap();
        let (mut own, mut images): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
        for (column, load) in columns.chunks_exact(body.unknowns()).zip(loads) {
            let (mut u, mut f) = (column.to_vec(), load.forces.clone());
            // Twice, because the first pass leaves rounding.
            for (b, image) in own.iter().zip(&images).chain(own.iter().zip(&images)) {
                let share = dot(&u, image);
                u.iter_mut().zip(b).for_each(|(u, b)| *u -= share * b);
                f.iter_mut().zip(image).for_each(|(f, image)| *f -= share * image);
            }
            let square = dot(&u, &f);
            if square > 1e-8 * dot(column, &load.forces) {
                u.iter_mut().chain(&mut f).for_each(|x| *x /= square.sqrt());
                own.push(u);
                images.push(f);
            }
        }
        let displacements = own.concat();
        let columns = MatRef::from_column_major_slice(&displacements, body.unknowns(), own.len());
        let mass = body.mass_gram(lattice, columns, &CancelToken::default()).unwrap();
        Self { modes: ReducedModes::new(&mass, own.len()).unwrap(), displacements }
    }

    /// Coordinates of the static displacement under `forces`.
    fn coordinates(&self, forces: &[f64]) -> Vec<f64> {
        self.displacements.chunks_exact(forces.len()).map(|own| dot(own, forces)).collect()
    }
}

/// Body of one of both orders.
fn body(lattice: &Lattice, poisson: f64, order: ElementOrder) -> Elasticity {
    free(lattice, poisson).of_order(order, lattice).unwrap()
}

fn stiffness(body: &Elasticity, u: &[f64], product: &mut [f64]) {
    match &body.edges {
        Some(edges) => edges.multiply(body.lame, &body.elements, u, product),
        None => body.stiffness.multiply(u, product),
    }
}

/// Solves (M + `factor` K) x = `right` by conjugate gradients from the guess in `x`.
fn conjugate_gradients(lattice: &Lattice, body: &Elasticity, factor: f64, right: &[f64], x: &mut [f64]) {
    let mut stretched = vec![0.0; x.len()];
    let mut apply = |u: &[f64]| {
        let mut image = vec![0.0; u.len()];
        body.multiply_mass(&lattice.tets, u, &mut image);
        stiffness(body, u, &mut stretched);
        image.iter_mut().zip(&stretched).for_each(|(own, k)| *own += factor * k);
        image
    };
    let mut residual: Vec<f64> = right.iter().zip(apply(x)).map(|(b, image)| b - image).collect();
    let (mut direction, mut square) = (residual.clone(), dot(&residual, &residual));
    while square > 1e-14 * dot(right, right) {
        let image = apply(&direction);
        let step = square / dot(&direction, &image);
        x.iter_mut().zip(&direction).for_each(|(x, p)| *x += step * p);
        residual.iter_mut().zip(&image).for_each(|(r, image)| *r -= step * image);
        let next = dot(&residual, &residual);
        direction.iter_mut().zip(&residual).for_each(|(p, r)| *p = r + next / square * *p);
        square = next;
    }
}

/// Largest strain energy of all unknowns under `forces` times a pulse, by Newmark's rule of constant mean acceleration.
fn stepped(lattice: &Lattice, body: &Elasticity, forces: &[f64], pulse: Pulse, [step, end]: [f64; 2]) -> f64 {
    let size = body.unknowns();
    let [mut u, mut v, mut a, mut product] = [(); 4].map(|()| vec![0.0; size]);
    let (mut greatest, quarter) = (0.0_f64, 0.25 * step * step);
    for count in 1..=(end / step) as usize {
        let force = pulse.force(step * count as f64);
        (0..size).for_each(|i| u[i] += step * v[i] + quarter * a[i]);
        stiffness(body, &u, &mut product);
        let right: Vec<f64> = forces.iter().zip(&product).map(|(f, k)| force * f - k).collect();
        let mut next = a.clone();
        conjugate_gradients(lattice, body, quarter, &right, &mut next);
        for i in 0..size {
            u[i] += quarter * next[i];
            v[i] += 0.5 * step * (a[i] + next[i]);
        }
        a = next;
        stiffness(body, &u, &mut product);
        greatest = greatest.max(0.5 * dot(&u, &product));
    }
    greatest
}

/// M times a rigid acceleration is what inertia relief subtracts, which has closed forms of its own.
#[test]
fn the_mass_of_rigid_motions_is_that_of_inertia_relief() {
    let lattice = perturbed([3, 2, 2], 0.1, 0.02, 7);
    for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
        let body = body(&lattice, 0.25, order);
        for axis in 0..6 {
            let [linear, angular] = unit(axis);
            let nodes =
                (0..lattice.nodes.len()).flat_map(|node| (linear + angular.cross(&body.inertia.arm(node))).data.0[0]);
            let mut motion: Vec<f64> = nodes.collect();
            motion.resize(body.unknowns(), 0.0);
            let mut product = vec![0.0; motion.len()];
            body.multiply_mass(&lattice.tets, &motion, &mut product);
            assert!(difference(&body.inertial_forces(axis), &product) < 1e-12, "{order:?}, {axis}");
        }
    }
}

/// ∫ u² of a quadratic displacement, by the polynomial x (1 − x), which quadratic elements hold exactly.
#[test]
fn the_mass_of_edges_integrates_parabolas() {
    let lattice = perturbed([3, 2, 2], 0.1, 0.02, 7);
    let body = body(&lattice, 0.25, ElementOrder::Quadratic);
    let edges = body.edges.as_ref().unwrap();
    // On an edge, x² is the line between its ends minus b_e (x_i − x_j)² / 4.
    let x = |node: u32| lattice.nodes[node as usize].x;
    let nodes = (0..lattice.nodes.len() as u32).flat_map(|node| [x(node) * (1.0 - x(node)), 0.0, 0.0]);
    let bent = edges.ends.iter().flat_map(|[a, b]| [0.25 * (x(*a) - x(*b)).powi(2), 0.0, 0.0]);
    let parabola: Vec<f64> = nodes.chain(bent).collect();
    let mut product = vec![0.0; parabola.len()];
    body.multiply_mass(&lattice.tets, &parabola, &mut product);
    // ∫ x² (1 − x)² over a tetrahedron, by Gauss's rule of degree 7 along three nested lines.
    let exact: f64 = (0..lattice.tets.len()).map(|tet| integral(&lattice, tet, |x| (x * (1.0 - x)).powi(2))).sum();
    let own = dot(&parabola, &product);
    assert!((own / exact - 1.0).abs() < 1e-10, "{own} of {exact}");
}

/// Integral of a polynomial in x of degree 4 over a tetrahedron.
fn integral(lattice: &Lattice, tet: usize, of: impl Fn(f64) -> f64) -> f64 {
    // Abscissas and weights on [0, 1]; the collapsed coordinates add up to 2 to the degree.
    let root = |sign: f64| (3.0 / 7.0 + sign * 2.0 / 7.0 * (6.0_f64 / 5.0).sqrt()).sqrt();
    let weight = |sign: f64| (18.0 - sign * 30.0_f64.sqrt()) / 72.0;
    let points = [-1.0, 1.0].map(|sign| [-1.0, 1.0].map(|side| (0.5 + 0.5 * side * root(sign), weight(sign)))).concat();
    let corners = lattice.corners(tet).map(|corner| corner.x);
    let mut sum = 0.0;
    for (a, wa) in &points {
        for (b, wb) in &points {
            for (c, wc) in &points {
                let shares = [1.0 - a, a * (1.0 - b), a * b * (1.0 - c), a * b * c];
                let x: f64 = shares.iter().zip(&corners).map(|(share, x)| share * x).sum();
                sum += wa * wb * wc * a * a * b * of(x);
            }
        }
    }
    6.0 * lattice.tet_volume(tet) * sum
}

/// The closed form solves q″ + ω² q = ω² s(t), by comparison with the Runge-Kutta rule of order 4.
#[test]
fn responses_to_pulses_solve_their_equation() {
    let pulse = Pulse { duration: 2.0 };
    // The third is in resonance.
    for frequency in [0.1, 0.7, PI / 2.0, 4.0, 40.0] {
        let (steps, end) = (40_000, 6.0);
        let step = end / f64::from(steps);
        let (mut q, mut v) = (0.0, 0.0);
        for count in 0..steps {
            let t = step * f64::from(count);
            let slope = |t: f64, q: f64, v: f64| (v, frequency * frequency * (pulse.force(t) - q));
            let one = slope(t, q, v);
            let two = slope(t + 0.5 * step, q + 0.5 * step * one.0, v + 0.5 * step * one.1);
            let three = slope(t + 0.5 * step, q + 0.5 * step * two.0, v + 0.5 * step * two.1);
            let four = slope(t + step, q + step * three.0, v + step * three.1);
            q += step / 6.0 * (one.0 + 2.0 * (two.0 + three.0) + four.0);
            v += step / 6.0 * (one.1 + 2.0 * (two.1 + three.1) + four.1);
            let own = pulse.response(frequency, t + step);
            assert!((own - q).abs() < 1e-5, "ω {frequency}, t {t}: {own}, {q}");
        }
    }
    assert_eq!((pulse.response(1.0, 0.0), pulse.force(2.5)), (0.0, 0.0));
    assert!((pulse.response(1e4, 0.7) - pulse.force(0.7)).abs() < 1e-3, "stiff modes follow the force");
}

/// The bound is that of the shock spectrum of half a sine: A. K. Chopra, *Dynamics of Structures* (1995), section 4.8.
#[test]
fn no_mode_exceeds_the_bound_of_responses() {
    let pulse = Pulse { duration: 1.0 };
    let mut greatest = 0.0_f64;
    for frequency in (1..4000).map(|step| 0.01 * f64::from(step)) {
        let end = 1.0 + 2.0 * PI / frequency;
        let times = (1..=500).map(|step| end * f64::from(step) / 500.0);
        greatest = times.map(|t| pulse.response(frequency, t).abs()).fold(greatest, f64::max);
    }
    assert!(greatest < RESPONSE_MAX && greatest > RESPONSE_MAX - 0.005, "{greatest}");
}

/// Two modes along the axes of the basis, under two pulses.
#[test]
fn loads_of_several_durations_add_up() {
    let modes = ReducedModes::new(&[0.25, 0.0, 0.0, 0.01], 2).unwrap();
    let (short, long) = (Pulse { duration: 0.3 }, Pulse { duration: 1.1 });
    let (one, two) = ([1.0, -0.4], [0.6, 0.9]);
    let loads = [PulseLoad { pulse: short, coordinates: &one }, PulseLoad { pulse: long, coordinates: &two }];
    let missed = 0.2;
    let at = |t: f64| -> ([f64; 2], f64) {
        let sum = |k: usize, of: &dyn Fn(Pulse) -> f64| one[k] * of(short) + two[k] * of(long);
        let own = [(0, 2.0), (1, 10.0)].map(|(k, frequency)| sum(k, &|pulse| pulse.response(frequency, t)));
        let at_rest = [0, 1].map(|k| sum(k, &|pulse| pulse.force(t)));
        (own, ReducedBasis::energy(&own) + missed * ReducedBasis::energy(&at_rest))
    };
    let end = 1.1 + PI / 2.0;
    let best = (1..=64).map(|step| end * f64::from(step) / 64.0).max_by(|a, b| at(*a).1.total_cmp(&at(*b).1)).unwrap();
    let found = modes.respond(&loads, missed);
    assert!((found.time - best).abs() < 1e-12, "{} for {best}", found.time);
    let (coordinates, energy) = at(best);
    assert!((found.energy / energy - 1.0).abs() < 1e-12);
    assert!(found.coordinates.iter().zip(coordinates).all(|(own, by_hand)| (own - by_hand).abs() < 1e-12));
    assert_eq!(found.forces, [short.force(found.time), long.force(found.time)]);
    // Loads of one duration are one load.
    let halves = [one, two].map(|own| own.map(|q| q / 3.0));
    let parts = halves.each_ref().map(|own| PulseLoad { pulse: long, coordinates: own });
    let sum = [0, 1].map(|k| halves[0][k] + halves[1][k]);
    let whole = modes.respond(&[PulseLoad { pulse: long, coordinates: &sum }], missed);
    let divided = modes.respond(&parts, missed);
    assert!((divided.energy / whole.energy - 1.0).abs() < 1e-12 && divided.time == whole.time);
}

/// A free bar vibrates along itself with ω_n = nπ/L √(E/ρ) (without Poisson's ratio).
#[test]
fn a_free_bar_has_its_frequencies() {
    let lattice = block([24, 1, 1], 0.05);
    let length = 24.0 * 0.05;
    for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
        let body = body(&lattice, 0.0, order);
        let load = |n: usize| {
            let wave = lattice.nodes.iter().flat_map(|x| [(n as f64 * PI * (x.x / length + 0.5)).cos(), 0.0, 0.0]);
            let mut wave: Vec<f64> = wave.collect();
            wave.resize(body.unknowns(), 0.0);
            let mut forces = vec![0.0; wave.len()];
            body.multiply_mass(&lattice.tets, &wave, &mut forces);
            body.relieve(&mut forces);
            NodalLoad { forces, ..NodalLoad::default() }
        };
        let span = Span::new(&lattice, &body, &(1..=6).map(load).collect::<Vec<_>>());
        for (n, frequency) in (1..=4).zip(span.modes.frequencies()) {
            let ratio = frequency / (f64::from(n) * PI / length);
            println!("{order:?}: frequency {n} is {ratio:.4} of the exact one");
            assert!((0.0..0.01).contains(&(ratio - 1.0)), "Ritz values lie above");
        }
    }
}

/// A block with a random load, and the span of the displacements under others.
struct RandomBlock {
    lattice: Lattice,
    body: Elasticity,
    struck: NodalLoad,
    span: Span,
    coordinates: Vec<f64>,
    whole: f64,
}

impl RandomBlock {
    fn new(cells: [usize; 3], order: ElementOrder) -> Self {
        let lattice = perturbed(cells, 0.1, 0.02, 3);
        let body = body(&lattice, 0.25, order);
        let mut stream = RandomStream::new(5, 0);
        let mut one = |_: u64| {
            let half = cells.map(|count| 0.05 * count as f64);
            let mut place = half.map(|half| (stream.uniform() - 0.5) * 1.8 * half);
            place[2] = half[2].copysign(place[2]);
            let impulse = Vector3::from_fn(|_, _| stream.uniform() - 0.5);
            load(&body, &[ContactLoad { point: Point3::from(place), impulse, radius: 0.12 }])
        };
        let (struck, others) = (one(0), (0..48).map(&mut one).collect::<Vec<_>>());
        let span = Span::new(&lattice, &body, &others);
        let coordinates = span.coordinates(&struck.forces);
        let whole = body.elastic_energy(&struck.forces, &solve(&body, &struck.forces));
        Self { lattice, body, struck, span, coordinates, whole }
    }

    /// Energy at rest that the span misses.
    fn rest(&self) -> f64 {
        self.whole - ReducedBasis::energy(&self.coordinates)
    }

    fn period(&self) -> f64 {
        2.0 * PI / self.span.modes.frequencies()[0]
    }

    /// Response to a pulse of this `share` of the longest period, and its energy over that of all unknowns in `steps` of time
    /// per duration.
    fn respond(&self, share: f64, steps: f64) -> (ModalResponse, f64) {
        let pulse = Pulse { duration: share * self.period() };
        let missed = self.rest() / ReducedBasis::energy(&self.coordinates);
        let response = self.span.modes.respond(&[PulseLoad { pulse, coordinates: &self.coordinates }], missed);
        let times = [pulse.duration / steps, pulse.duration + 0.5 * self.period()];
        let ratio = response.energy / stepped(&self.lattice, &self.body, &self.struck.forces, pulse, times);
        (response, ratio)
    }
}

/// Modes in the span of static displacements respond to pulses of many durations as all unknowns do, step by step in time.
///
/// Ratios that were seen: 0.93 to 1.02.
#[test]
fn pulses_give_the_energy_of_steps_in_time() {
    for (cells, order) in [([10, 2, 1], ElementOrder::Linear), ([5, 5, 1], ElementOrder::Quadratic)] {
        let block = RandomBlock::new(cells, order);
        let (whole, rest) = (block.whole, block.rest());
        assert!(rest > 0.0 && rest < 0.1 * whole, "the basis misses a part: {rest} of {whole}");
        for (share, steps) in [(0.05, 20.0), (0.2, 40.0), (1.0, 80.0), (5.0, 160.0)] {
            let (response, ratio) = block.respond(share, steps);
            println!(
                "{order:?}, duration {share} of the period: {:.3} of the static energy, {ratio:.3} of that in time",
                response.energy / whole
            );
            assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
            let own = ReducedBasis::energy(&response.coordinates) + rest * response.forces[0].powi(2);
            assert!((own / response.energy - 1.0).abs() < 1e-9, "the energy is that of the coordinates");
        }
        let slow = PulseLoad { pulse: Pulse { duration: 400.0 * block.period() }, coordinates: &block.coordinates };
        let slow = block.span.modes.respond(&[slow], rest / ReducedBasis::energy(&block.coordinates));
        assert!((slow.energy / whole - 1.0).abs() < 0.02, "a slow pulse is a static load: {}", slow.energy / whole);
    }
}

/// Short pulses excite vibrations outside the span, whose energy the response lacks.
///
/// Ratios that were seen: 0.92, 0.71, 0.54.
#[test]
fn energies_of_very_short_pulses_are_too_small() {
    let block = RandomBlock::new([10, 2, 1], ElementOrder::Linear);
    let shares = [0.02, 0.01, 0.005];
    let ratios = shares.map(|share| block.respond(share, 20.0).1);
    println!("durations {shares:?} of the period: {ratios:.3?} of the energy in time");
    assert!((ratios[0] - 1.0).abs() < 0.15 && ratios[1] < 0.95 && ratios[2] < ratios[1], "{ratios:?}");
    assert!(ratios[2] > 0.1, "{ratios:?}");
}

/// The vibrations of a reduced basis are those in the span of its snapshots, of which quadratic ones are approximate.
#[test]
fn bases_vibrate_as_their_snapshots_do() {
    for (cells, order, tolerance) in
        [([8, 2, 1], ElementOrder::Linear, 1e-8), ([4, 4, 1], ElementOrder::Quadratic, 1e-2)]
    {
        let lattice = perturbed(cells, 0.1, 0.02, 3);
        let body = body(&lattice, 0.25, order);
        let mut stream = RandomStream::new(5, 0);
        let mut one = |_: u64| {
            let half = cells.map(|count| 0.05 * count as f64);
            let place = half.map(|half| (stream.uniform() - 0.5) * 1.8 * half);
            let point = Point3::new(place[0], place[1], half[2].copysign(place[2]));
            let impulse = Vector3::from_fn(|_, _| stream.uniform() - 0.5);
            load(&body, &[ContactLoad { point, impulse, radius: 0.12 }])
        };
        let loads: Vec<NodalLoad> = (0..10).map(&mut one).collect();
        let basis = body.reduce(&lattice, &loads, 64, &CancelToken::default()).unwrap().unwrap();
        let own = basis.modes().unwrap().frequencies();
        let span = Span::new(&lattice, &body, &loads);
        assert_eq!(own.len(), span.modes.frequencies().len());
        for (own, other) in own.iter().zip(span.modes.frequencies()) {
            assert!((own / other - 1.0).abs() < tolerance, "{order:?}: {own} for {other}");
        }
    }
}

/// Directions without mass have no frequency.
#[test]
fn masses_that_are_not_positive_have_no_modes() {
    assert_eq!(ReducedModes::new(&[1.0, 0.0, 0.0, -1.0], 2), None);
    assert_eq!(ReducedModes::new(&[1.0, 1.0, 1.0, 1.0], 2), None);
    assert_eq!(ReducedModes::new(&[f64::NAN], 1), None);
    assert_eq!(ReducedModes::new(&[], 0), None);
    assert_eq!(ReducedModes::new(&[0.25], 1).unwrap().frequencies(), [2.0]);
}
