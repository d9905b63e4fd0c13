//! What effects need, and when it is paid.

use shatter_fracture::database::Tables;
use shatter_proto::effect::Effect;

/// A table of a database that objects can do without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OptionalTable {
    /// What it is called in a plan.
    pub name: &'static str,
    /// Whether it is wanted.
    pub wanted: bool,
    /// Names of its tensors contain one of these.
    pub tensors: &'static [&'static str],
}

/// All tables, and which of them are wanted.
pub fn tables(wanted: Tables) -> [OptionalTable; 6] {
    [
        OptionalTable { name: "elastic", wanted: wanted.elastic, tensors: &[".elastic.", ".transfer.", "reduced"] },
        OptionalTable { name: "interior", wanted: wanted.interior, tensors: &[".interior"] },
        OptionalTable { name: "surface_diffusion", wanted: wanted.surface_diffusion, tensors: &[".surface_diffusion"] },
        OptionalTable { name: "examples", wanted: wanted.examples, tensors: &["examples.", "network."] },
        OptionalTable { name: "attributes", wanted: wanted.attributes, tensors: &[".outer."] },
        OptionalTable { name: "skin", wanted: wanted.skin, tensors: &["skin."] },
    ]
}

/// When an effect is paid: while baking, while loading, with every strike.
pub fn paid(effect: Effect) -> &'static str {
    match effect {
        Effect::Elastic => {
            "bake: lattice, basis, bound; load: lattice, stiffness, factor; strike: stage `elasticity`, unless a bound of E_1 is below γ"
        }
        Effect::Tensile => "strike: a spectral split per elastic tetrahedron",
        Effect::Interior => "bake: eigenpairs; load: lift; strike: a longer lift in stage `centroidal`",
        Effect::Examples => "bake: optimised examples; load: network; strike: microseconds in stage `degree`",
        Effect::Slivers => "strike: areas of cracks, and a second tessellation where there is a sliver",
        Effect::Release => "strike: one pass over nodes; 48 bytes per fragment",
        Effect::Normals => "strike: one pass over triangles; 12 bytes per vertex",
        Effect::Uv => "strike: one pass over vertices; 8 bytes per vertex",
        Effect::Bonds => "strike: one pass over crack triangles; 64 bytes per pair",
        Effect::Debris => "strike: one pass over crack triangles; 40 bytes per point",
        Effect::Hulls => "strike: a hull per fragment, fitted and measured; about 1 kB per fragment",
        Effect::Warp => "load: eigenpairs of the bent space, if something bends; strike: one pass over protected nodes",
        Effect::Anchored => "load: a second factor; strike: a solve, never the basis, and the degree without examples",
        Effect::Attributes => {
            "bake: the nearest point of the input; load: looks; strike: 20 bytes per vertex, 4 per triangle"
        }
        Effect::Skin => "bake: where the input lies in the lattice; load: the input; strike: one pass over it",
        Effect::Gravity => "load: one solve; strike: one pass over elastic nodes",
    }
}
