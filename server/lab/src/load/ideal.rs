//! Ideal queue, a bound for every service: as many servers as the machine has threads, and no time between requests.
//!
//! Based on: J. Kiefer & J. Wolfowitz, *On the theory of queues with many servers* (1955), recursion of waiting times.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Sojourn times of requests (arrival to end) in order of arrival, first come first served by `servers`. Inputs and result in µs.
pub fn sojourns(mut strikes: Vec<(u64, u64)>, servers: usize) -> Vec<u64> {
    strikes.sort_unstable();
    let mut free: BinaryHeap<Reverse<u64>> = (0..servers.max(1)).map(|_| Reverse(0)).collect();
    let serve = |(arrival, service): (u64, u64)| {
        let Reverse(first) = free.pop().unwrap_or(Reverse(0));
        let end = first.max(arrival) + service;
        free.push(Reverse(end));
        end - arrival
    };
    strikes.into_iter().map(serve).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strikes_wait_for_a_server() {
        assert_eq!(sojourns(vec![(0, 10), (1, 10), (2, 10), (30, 5)], 1), [10, 19, 28, 5]);
        assert_eq!(sojourns(vec![(2, 10), (0, 10), (1, 10)], 2), [10, 10, 18]);
        assert!(sojourns(Vec::new(), 0).is_empty());
    }

    #[test]
    fn waiting_is_that_of_the_theory() {
        // M/M/1 at 80 %: the mean sojourn is 1/(μ − λ).
        let mut random = fastrand::Rng::with_seed(5);
        let mut arrival = 0.0;
        let strikes = (0..200_000).map(|_| {
            let mut draw = |mean: f64| -mean * (1.0 - random.f64()).ln();
            arrival += draw(1250.0);
            (arrival as u64, draw(1000.0) as u64)
        });
        let all = sojourns(strikes.collect(), 1);
        let mean = all.iter().sum::<u64>() as f64 / all.len() as f64;
        assert!((mean / 5000.0 - 1.0).abs() < 0.1, "{mean}");
    }
}
