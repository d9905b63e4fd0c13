//! Residuals of solves, and errors of invalid matrices.

use super::{Cholesky, Precision, SolveScratch, SparseError, SymbolicFactor, SymmetricMatrix};
use crate::lattice::block;
use crate::random::RandomStream;
use nalgebra::Matrix3;
use proptest::prelude::*;

/// Connected, diagonally dominant matrix with random entries.
fn dominant(size: usize, seed: u64) -> SymmetricMatrix {
    let mut stream = RandomStream::new(seed, 0);
    let mut triplets = Vec::new();
    for row in 1..size as u32 {
        for _ in 0..3 {
            let column = (stream.uniform() * f64::from(row)) as u32;
            let weight = stream.uniform();
            triplets.extend([(row, column, -weight), (row, row, weight), (column, column, weight)]);
        }
    }
    triplets.push((0, 0, 0.5));
    SymmetricMatrix::from_triplets(size, &triplets).unwrap()
}

/// Block matrix on a block lattice: the same anisotropic spring along every edge, stiffened on the diagonal.
fn vector_matrix(cells: usize) -> SymmetricMatrix<3> {
    let lattice = block([cells; 3], 1.0);
    let spring = Matrix3::new(2.0, 0.3, 0.1, 0.3, 1.5, -0.2, 0.1, -0.2, 1.0);
    SymmetricMatrix::assemble(
        lattice.nodes.len(),
        &lattice.tets,
        |_, i, j| if i == j { spring * 3.01 } else { -spring },
    )
    .unwrap()
}

/// Solves for `k` random columns and checks the residual of each.
fn check<const B: usize>(matrix: &SymmetricMatrix<B>, k: usize) {
    let size = matrix.size();
    let mut stream = RandomStream::new(7, k as u64);
    let rhs: Vec<f64> = (0..size * k).map(|_| stream.uniform() - 0.5).collect();
    let factor = Cholesky::factor(matrix).unwrap();
    let (mut x, mut product) = (rhs.clone(), vec![0.0; size * k]);
    factor.solve_in_place(&mut x, k, &mut SolveScratch::default());
    matrix.multiply(&x, &mut product);
    let error = rhs.iter().zip(&product).map(|(b, ax)| (b - ax).abs()).fold(0.0, f64::max);
    assert!(error < 1e-11, "residual {error:e} of {size} rows, {k} columns");
}

#[test]
fn solves_one_and_many_columns_of_scalar_and_of_block_matrices() {
    for k in [1, 2, 8] {
        check(&dominant(1, 1), k);
        check(&dominant(400, 2), k);
        check(&vector_matrix(4), k);
    }
}

/// Σ c² of the columns of a factor with Σ c entries: at least (Σ c)²/n, at most n Σ c.
#[test]
fn operations_of_a_factor_fit_its_entries() {
    assert_eq!(SymbolicFactor::analyze(&dominant(1, 1)).unwrap().factor_operations(), 1);
    let check = |symbolic: SymbolicFactor, size: usize| {
        // The indices take less than an eighth.
        let entries = symbolic.factor_bytes(Precision::F64) as f64 / 8.0;
        let operations = symbolic.factor_operations() as f64;
        let range = 0.5 * entries * entries / size as f64..size as f64 * entries;
        assert!(range.contains(&operations), "{operations:e}, {range:?}");
    };
    check(SymbolicFactor::analyze(&dominant(400, 2)).unwrap(), 400);
    let block = vector_matrix(8);
    check(SymbolicFactor::analyze(&block).unwrap(), block.size());
}

#[test]
fn a_scratch_serves_factors_of_any_size_and_columns_do_not_disturb_each_other() {
    let mut scratch = SolveScratch::default();
    for matrix in [dominant(20, 3), dominant(300, 4), dominant(50, 5)] {
        let factor = Cholesky::factor(&matrix).unwrap();
        let size = matrix.size();
        let mut many: Vec<f64> = (0..3 * size).map(|i| (i as f64).sin()).collect();
        let mut one = many[size..2 * size].to_vec();
        factor.solve_in_place(&mut many, 3, &mut scratch);
        factor.solve_in_place(&mut one, 1, &mut scratch);
        let error = one.iter().zip(&many[size..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-11, "{error:e}");
    }
}

/// Shifts below, between and above the eigenvalues that a dense solver finds.
#[test]
fn negative_eigenvalues_are_counted() {
    for matrix in [dominant(60, 2), dominant(400, 3)] {
        let (size, symbolic) = (matrix.size(), SymbolicFactor::analyze(&matrix).unwrap());
        let mut dense = nalgebra::DMatrix::<f64>::zeros(size, size);
        for row in 0..size {
            let (columns, blocks) = matrix.row(row);
            columns.iter().zip(blocks).for_each(|(column, block)| dense[(row, *column as usize)] = block[(0, 0)]);
        }
        let mut values: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        for count in [0, 1, 7, size / 2, size] {
            let below = if count == 0 { values[0] - 1.0 } else { values[count - 1] };
            let above = values.get(count).map_or(below + 1.0, |next| *next);
            let mut shifted = matrix.clone();
            shifted.add_diagonal(&vec![-0.5 * (below + above); size]);
            let found = symbolic.signature(&shifted, &vec![0.25; size]).unwrap();
            assert_eq!(found.negative, count);
            // Four times the bound for unit weights, which is at least the rounding error of the largest eigenvalue.
            let least = 4.0 * f64::EPSILON * values[size - 1].abs();
            assert!(found.rounding > least && found.rounding < 1e-8, "{} of {least}", found.rounding);
        }
    }
}

#[test]
fn entries_at_one_place_are_summed_and_mirrored() {
    let matrix = SymmetricMatrix::from_triplets(3, &[(0, 0, 1.0), (2, 0, 3.0), (0, 2, 4.0), (1, 1, 2.0)]).unwrap();
    let mut y = [0.0; 3];
    matrix.multiply(&[1.0, 10.0, 100.0], &mut y);
    assert_eq!(y, [701.0, 20.0, 7.0]);
    assert_eq!(matrix.diagonal(), [1.0, 2.0, 0.0]);
}

#[test]
fn a_shift_acts_as_its_diagonal_matrix() {
    let mut matrix = SymmetricMatrix::from_triplets(2, &[(0, 0, 2.0), (0, 1, 3.0), (1, 1, 4.0)]).unwrap();
    matrix.add_diagonal(&[1.0, 2.0]);
    let mut y = [0.0; 2];
    matrix.multiply(&[1.0, 10.0], &mut y);
    assert_eq!(y, [33.0, 63.0]);
}

#[test]
fn rotation_and_fixing_keep_the_matrix_symmetric_and_solvable() {
    let plain = vector_matrix(2);
    let mut changed = plain.clone();
    let basis = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1);
    changed.rotate(4, basis.matrix());
    for node in 0..changed.nodes() {
        let (columns, blocks) = changed.row(node);
        for (&column, block) in columns.iter().zip(blocks) {
            let (back, mirrored) = changed.row(column as usize);
            let at = back.binary_search(&(node as u32)).unwrap();
            assert!((mirrored[at].transpose() - block).norm() < 1e-12);
        }
    }
    // The rotated matrix acts on rotated components: Qᵀ A Q (Qᵀ x) = Qᵀ (A x).
    let x: Vec<f64> = (0..plain.size()).map(|i| (i as f64).cos()).collect();
    let turned = |v: &[f64]| {
        let mut v = v.to_vec();
        let own = basis.inverse() * nalgebra::Vector3::from_column_slice(&v[12..15]);
        v[12..15].copy_from_slice(own.as_slice());
        v
    };
    let (mut y, mut turned_y) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    plain.multiply(&x, &mut y);
    changed.multiply(&turned(&x), &mut turned_y);
    let error = turned(&y).iter().zip(&turned_y).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(error < 1e-13, "{error:e}");

    changed.fix(4, 1, 5.0);
    let mut x = vec![1.0; changed.size()];
    x[13] = 0.0;
    Cholesky::factor(&changed).unwrap().solve_in_place(&mut x, 1, &mut SolveScratch::default());
    assert_eq!(x[13], 0.0, "a fixed component without a load stays zero");
}

#[test]
fn bad_matrices_are_refused_by_name() {
    let factor = |triplets: &[(u32, u32, f64)], size| {
        SymmetricMatrix::from_triplets(size, triplets).map(|matrix| Cholesky::factor(&matrix).err())
    };
    assert_eq!(factor(&[], 0), Ok(Some(SparseError::Empty)));
    assert_eq!(factor(&[(0, 3, 1.0)], 3).unwrap_err(), SparseError::IndexOutOfRange { index: 3, nodes: 3 });
    let infinite = factor(&[(0, 0, 1.0), (2, 1, f64::INFINITY)], 3).unwrap_err();
    assert_eq!(infinite, SparseError::NonFinite { row: 1, column: 2 });
    let diagonal: Vec<_> = (0..60).map(|i| (i, i, if i == 41 { -1.0 } else { 1.0 })).collect();
    assert_eq!(factor(&diagonal, 60), Ok(Some(SparseError::NotPositiveDefinite { pivot: 41 })));
    let mut sum = SparseError::Empty;
    if let Err(error) = SymmetricMatrix::<3>::assemble(4, &[[0, 1, 2, 9]], |_, _, _| Matrix3::identity()) {
        sum = error;
    }
    assert_eq!(sum, SparseError::IndexOutOfRange { index: 9, nodes: 4 });
}

#[test]
fn an_indefinite_supernodal_matrix_names_a_pivot() {
    let mut matrix = vector_matrix(5);
    let mut shift = vec![0.0; matrix.size()];
    shift[200] = -1e6;
    matrix.add_diagonal(&shift);
    assert_eq!(Cholesky::factor(&matrix).err(), Some(SparseError::NotPositiveDefinite { pivot: 200 }));
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let run = || {
        let matrix = vector_matrix(6);
        let mut x: Vec<f64> = (0..matrix.size()).map(|i| (i as f64 * 0.7).sin()).collect();
        let mut y = vec![0.0; x.len()];
        matrix.multiply(&x, &mut y);
        let mut alone = vec![0.0; x.len()];
        matrix.multiply_alone(&x, &mut alone);
        assert_eq!(alone, y);
        Cholesky::factor(&matrix).unwrap().solve_in_place(&mut x, 1, &mut SolveScratch::default());
        (matrix, x, y)
    };
    let in_pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
    let one = in_pool(1);
    assert!(one == in_pool(2) && one == in_pool(4));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn random_dominant_matrices_solve(size in 1_usize..300, seed: u64, k in 1_usize..5) {
        check(&dominant(size, seed), k);
    }
}
