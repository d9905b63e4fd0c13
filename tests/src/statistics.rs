//! Statistics for the tests.

/// Ranks from 0; ties share their mean rank.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for tied in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let mean = first as f64 + (tied.len() - 1) as f64 / 2.0;
        tied.iter().for_each(|&index| ranks[index] = mean);
        first += tied.len();
    }
    ranks
}

/// Spearman's rank correlation of two samples of one length, −1 ..= 1.
pub fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let mean = (a.len() - 1) as f64 / 2.0;
    let covariance = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - mean) * (y - mean)).sum::<f64>();
    covariance(&a, &b) / (covariance(&a, &a) * covariance(&b, &b)).sqrt()
}

/// Median; NaN of an empty sample.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        odd if odd % 2 == 1 => sorted[odd / 2],
        even => 0.5 * (sorted[even / 2 - 1] + sorted[even / 2]),
    }
}

/// Exponent and factor of y = factor·x^exponent, by least squares of logarithms; all values above 0.
pub fn power_law(points: &[(f64, f64)]) -> [f64; 2] {
    let count = points.len() as f64;
    let logarithms = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let mean = logarithms().fold([0.0; 2], |[x, y], (u, v)| [x + u / count, y + v / count]);
    let products = logarithms().map(|(u, v)| ((u - mean[0]) * (v - mean[1]), (u - mean[0]).powi(2)));
    let [both, square] = products.fold([0.0; 2], |[both, square], (b, s)| [both + b, square + s]);
    let exponent = both / square;
    [exponent, (mean[1] - exponent * mean[0]).exp()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rank_correlation_knows_order_alone() {
        assert_eq!(rank_correlation(&[1.0, 2.0, 9.0], &[-3.0, 0.0, 0.1]), 1.0);
        assert_eq!(rank_correlation(&[1.0, 2.0, 9.0], &[3.0, 2.0, 1.0]), -1.0);
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0]), 2.5);
    }

    #[test]
    fn a_power_law_is_found_and_noise_cancels() {
        let points = |noise: f64| [1.0, 2.0, 4.0, 8.0].map(|x: f64| (x, 3.0 * x.powf(0.7) * noise));
        let exact = power_law(&points(1.0));
        assert!((exact[0] - 0.7).abs() < 1e-12 && (exact[1] - 3.0).abs() < 1e-12, "{exact:?}");
        let noisy = power_law(&[points(1.1), points(1.0 / 1.1)].concat());
        assert!((noisy[0] - 0.7).abs() < 1e-12 && (noisy[1] - 3.0).abs() < 1e-12, "{noisy:?}");
    }
}
