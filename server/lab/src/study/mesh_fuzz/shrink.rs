//! Reduction of a failing mesh to few triangles.
//!
//! Based on: A. Zeller, R. Hildebrandt, *Simplifying and isolating failure-inducing input* (2002): ddmin, on triangles.

use super::Judge;
use super::check::FuzzFault;
use super::judge::FuzzVerdict;
use shatter_fracture::surface::RawMesh;

/// Reduced mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct ShrunkMesh {
    /// Mesh that still fails.
    pub mesh: RawMesh,
    /// Number of meshes tried.
    pub tries: usize,
}

/// Removes triangles while `fails` is true for the rest, then unused vertices; tries at most `tries_max` meshes.
///
/// `mesh` itself must fail.
pub fn shrink(mesh: &RawMesh, tries_max: usize, fails: &mut dyn FnMut(&RawMesh) -> bool) -> ShrunkMesh {
    let mut shrunk = ShrunkMesh { mesh: RawMesh { faces: Vec::new(), ..mesh.clone() }, tries: 0 };
    let mut parts = 2;
    while shrunk.mesh.triangles.len() > 1 && shrunk.tries < tries_max {
        let count = shrunk.mesh.triangles.len();
        let size = count.div_ceil(parts);
        if (0..count).step_by(size).any(|first| shrunk.without(first, size, tries_max, fails)) {
            parts = (parts - 1).max(2);
        } else if size == 1 {
            break;
        } else {
            parts = (2 * parts).min(count);
        }
    }
    let compact = compacted(&shrunk.mesh);
    if shrunk.tries < tries_max && fails(&compact) {
        shrunk.mesh = compact;
    }
    shrunk
}

impl ShrunkMesh {
    /// Removes `size` triangles from `first` on if the rest still fails.
    fn without(
        &mut self,
        first: usize,
        size: usize,
        tries_max: usize,
        fails: &mut dyn FnMut(&RawMesh) -> bool,
    ) -> bool {
        if self.tries == tries_max {
            return false;
        }
        self.tries += 1;
        let mut rest = self.mesh.clone();
        rest.triangles.drain(first..rest.triangles.len().min(first + size));
        let fails = fails(&rest);
        if fails {
            self.mesh = rest;
        }
        fails
    }
}

/// Mesh without unused vertices; the mesh itself if an index is out of range.
fn compacted(mesh: &RawMesh) -> RawMesh {
    let mut place = vec![None; mesh.positions_m.len()];
    let mut compact = RawMesh { rounding: mesh.rounding, ..RawMesh::new(Vec::new(), mesh.triangles.clone()) };
    for vertex in compact.triangles.iter_mut().flatten() {
        let Some(place) = place.get_mut(*vertex as usize) else { return mesh.clone() };
        *vertex = *place.get_or_insert_with(|| {
            compact.positions_m.push(mesh.positions_m[*vertex as usize]);
            compact.positions_m.len() as u32 - 1
        });
    }
    compact
}

impl Judge {
    /// Whether `mesh` fails with the same kind of fault as `fault`, whatever the message.
    pub fn fails_like(&self, mesh: &RawMesh, must_accept: bool, seed: u64, fault: &FuzzFault) -> bool {
        match self.mesh(mesh, must_accept, seed) {
            FuzzVerdict::Failed(other) => std::mem::discriminant(&other) == std::mem::discriminant(fault),
            FuzzVerdict::Checked { .. } | FuzzVerdict::Refused { .. } => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_fracture::surface::shapes;

    #[test]
    fn only_what_the_failure_needs_is_left() {
        let ball = shapes::sphere(1.0, 3);
        let (one, two) = (ball.triangles[17], ball.triangles[1200]);
        let mut fails = |mesh: &RawMesh| {
            let corners = |t: &[u32; 3]| t.map(|vertex| mesh.positions_m[vertex as usize]);
            let wanted = [one, two].map(|t| t.map(|vertex| ball.positions_m[vertex as usize]));
            wanted.iter().all(|wanted| mesh.triangles.iter().any(|t| corners(t) == *wanted))
        };
        let shrunk = shrink(&ball, 1000, &mut fails);
        assert_eq!(shrunk.mesh.triangles.len(), 2);
        assert_eq!(shrunk.mesh.positions_m.len(), 6);
        assert!(fails(&shrunk.mesh) && shrunk.tries < 200, "{}", shrunk.tries);
    }

    #[test]
    fn shrinking_stops_on_cancellation() {
        let ball = shapes::sphere(1.0, 2);
        let mut tried = 0;
        let shrunk = shrink(&ball, 3, &mut |_| {
            tried += 1;
            false
        });
        assert_eq!((shrunk.mesh, shrunk.tries, tried), (ball, 3, 3));
    }
}
