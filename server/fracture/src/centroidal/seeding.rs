//! Starting sites: well-spaced nodes among candidates drawn with the optimal site density.
//!
//! Based on: A. Gersho, *Asymptotically optimal block quantization* (1979) and P. Zador (1982) for the density
//! W^(3/5)(det g)^(1/5) of the candidates; T. Gonzalez, *Clustering to minimize the maximum intercluster distance*
//! (1985) for the choice. The spacing of optimal sites is ∝ (W/√det g)^(−1/5). So the next site is the candidate with
//! the largest d²·W^(2/5)/(det g)^(1/5), with d its distance to the sites so far.
//!
//! Measured on 12k nodes, 10 to 200 sites, three fields. Against independent draws: half the excess energy, for a tenth
//! to half a millisecond more. Against k-means++ on all nodes: less excess energy in a tenth of its time.

use super::EnergyField;
use super::vector::square_distance;
use crate::random::RandomStream;

/// Offset of a site from its node, as a share of the way to another candidate.
///
/// Sites exactly at nodes of a regular lattice have many equidistant nodes, and rounding would decide their labels.
const DETOUR: f64 = 1.0 / 1024.0;

/// Candidates drawn per site. Fewer impair the spacing; more favor the boundary.
const CANDIDATES: usize = 4;

/// Working memory of the start, reused between calls.
#[derive(Clone, Debug, Default)]
pub(super) struct SeedScratch {
    prefix: Vec<f64>,
    candidates: Vec<u32>,
    weight: Vec<f64>,
    distance: Vec<f64>,
}

impl SeedScratch {
    /// Writes `count` ≤ nodes sites to `sites`, each slightly off a node of its own. Pinned sites come first.
    pub fn draw(&mut self, field: &EnergyField, count: usize, stream: &mut RandomStream, sites: &mut Vec<f64>) {
        self.gather(field, count, stream);
        self.weight.clear();
        self.weight.extend(self.candidates.iter().map(|&node| spacing_weight(field, node as usize)));
        self.distance.clear();
        self.distance.resize(self.candidates.len(), f64::INFINITY);
        sites.clear();
        let mut next = self.any(stream);
        for index in 0..count {
            let node = field.pins().get(index).copied().unwrap_or(self.candidates[next]) as usize;
            let other = self.candidates[self.any(stream)] as usize;
            let (place, aim) = (field.lift().at(node), field.lift().at(other));
            let first = sites.len();
            sites.extend(place.iter().zip(aim).map(|(x, aim)| x + DETOUR * (aim - x)));
            next = self.spread(field, &sites[first..], node as u32, next);
        }
    }

    /// Index of a random candidate.
    fn any(&self, stream: &mut RandomStream) -> usize {
        ((stream.uniform() * self.candidates.len() as f64) as usize).min(self.candidates.len() - 1)
    }

    /// Draws distinct candidates, at least `count`. Takes all nodes if drawing would not yield enough.
    fn gather(&mut self, field: &EnergyField, count: usize, stream: &mut RandomStream) {
        self.candidates.clear();
        let nodes = field.nodes();
        if count * CANDIDATES < nodes {
            self.prefix.clear();
            self.prefix.extend((0..nodes).scan(0.0, |sum, node| {
                *sum += field.site_share(node);
                Some(*sum)
            }));
            let total = self.prefix[nodes - 1];
            for _ in 0..count * CANDIDATES {
                let target = stream.uniform() * total;
                let node = self.prefix.partition_point(|sum| *sum <= target).min(nodes - 1);
                self.candidates.push(node as u32);
            }
            self.candidates.sort_unstable();
            self.candidates.dedup();
        }
        if self.candidates.len() < 2 * count {
            self.candidates.clear();
            self.candidates.extend(0..nodes as u32);
        }
    }

    /// Removes the chosen node from the candidates, updates the distances, and returns the best next candidate.
    ///
    /// Ties go to the lowest. Returns `last` if none is left.
    fn spread(&mut self, field: &EnergyField, place: &[f64], node: u32, last: usize) -> usize {
        if let Ok(chosen) = self.candidates.binary_search(&node) {
            self.distance[chosen] = -1.0;
        }
        let (mut best, mut next) = (f64::NEG_INFINITY, last);
        for (index, distance) in self.distance.iter_mut().enumerate() {
            if *distance < 0.0 {
                continue;
            }
            *distance = distance.min(square_distance(field.lift().at(self.candidates[index] as usize), place));
            let score = *distance * self.weight[index];
            if score > best {
                (best, next) = (score, index);
            }
        }
        next
    }
}

/// W^(2/5)/(det g)^(1/5), with W in units of its mean; 0 if the lift is flat.
fn spacing_weight(field: &EnergyField, node: usize) -> f64 {
    let flatness = field.lift().density[node];
    let density = field.relative_density(node);
    if flatness > 0.0 { density / (field.relative_density_three_fifths(node) * flatness) } else { 0.0 }
}
