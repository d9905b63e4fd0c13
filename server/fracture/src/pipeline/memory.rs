//! How much memory a prepared object holds.

use super::{Body, Bound, Example, Held, Learned, Prepared, Solid, Warped};
use crate::elasticity::Reduced;
use crate::lattice::{Lattice, Transfer};
use crate::lift::Lift;
use crate::memory::held;
use crate::skin::Outer;

impl Prepared {
    /// Bytes that the object holds as long as anybody may strike it: lattices, operators, factors, lifts, examples. Left out
    /// are what the allocator adds, and texts.
    pub fn bytes(&self) -> usize {
        let bodies = self.bodies.iter().map(Body::bytes).sum::<usize>() + held(&self.bodies);
        let examples = self.examples.iter().map(example).sum::<usize>() + held(&self.examples);
        let held = self.held.as_ref().map_or(0, Held::bytes);
        let skin = self.skin.as_ref().map_or(0, |skin| skin.bytes());
        bodies + held + skin + examples + self.learned.as_ref().map_or(0, |Learned { network, .. }| network.bytes())
    }
}

impl Body {
    /// Bytes that the body holds. Everything is named, so that what is added to a body is not forgotten here.
    pub fn bytes(&self) -> usize {
        let Self { crack, solid, interior, surface_diffusion, euclidean, volumes, topology, clusters, .. } = self;
        let Self { slenderness: _, boundary, warped, outer, bound, .. } = self;
        let lifts = [interior, surface_diffusion].into_iter().flatten().map(lift).sum::<usize>() + lift(euclidean);
        let lifts = lifts + warped.as_ref().map_or(0, Warped::bytes);
        let looks = outer.as_ref().map_or(0, Outer::bytes);
        let own = lattice(crack) + looks + topology.bytes() + clusters.bytes() + boundary.bytes() + held(volumes);
        let own = own + bound.as_ref().map_or(0, Bound::bytes);
        own + lifts + solid.as_ref().map_or(0, Solid::bytes)
    }
}

impl Warped {
    /// Bytes that it holds.
    pub fn bytes(&self) -> usize {
        let Self { lifts, protected, pins, factors, alike: _ } = self;
        let protected = protected.iter().map(held).sum::<usize>() + held(protected);
        lifts.iter().map(lift).sum::<usize>() + held(lifts) + protected + held(pins) + held(factors)
    }
}

impl Solid {
    /// Bytes that the elasticity holds.
    pub fn bytes(&self) -> usize {
        let Self { lattice: elastic, transfer, elasticity, reduced } = self;
        lattice(elastic) + shares(transfer) + elasticity.bytes() + reduced.as_ref().map_or(0, Reduced::bytes)
    }
}

fn lattice(Lattice { nodes, tets }: &Lattice) -> usize {
    held(nodes) + held(tets)
}

fn shares(Transfer { offsets, tets, shares }: &Transfer) -> usize {
    held(offsets) + held(tets) + held(shares)
}

fn lift(lift: &Lift) -> usize {
    let Lift { coordinates, first_moment, second_moment, density, kind: _, dimension: _ } = lift;
    held(coordinates) + held(first_moment) + held(second_moment) + held(density)
}

fn example(example: &Example) -> usize {
    held(&example.contacts) + held(&example.points) + held(&example.site_nodes)
}
