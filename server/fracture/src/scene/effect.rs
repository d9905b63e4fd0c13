//! What a strike simulates beyond the bare pieces.

/// An effect. Those of physics change the pieces; the others change nothing but what they add to the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum EffectKind {
    /// Strain energy from the deformation of the body. Off: it falls off with the distance from the contacts.
    Elastic = 0,
    /// Physics: tension alone drives cracks.
    Tensile = 1,
    /// Physics: interior distances. Off: straight ones.
    Interior = 2,
    /// Physics: the degree from the object's examples. Off: from the closed form.
    Examples = 3,
    /// Physics: slivers become part of the neighbor that they share most with.
    Slivers = 4,
    /// Velocities of the fragments from the strain energy that is set free.
    Release = 5,
    /// Normals, one per vertex.
    Normals = 6,
    /// Texture coordinates of crack faces, one per vertex.
    Uv = 7,
    /// Which fragments touch, and how.
    Bonds = 8,
    /// Points on crack faces from which dust and chips come.
    Debris = 9,
    /// Convex proxies of the fragments for collisions.
    Hulls = 10,
    /// Physics: cells follow what an artist says.
    Warp = 11,
    /// Physics: what lies in the scene's anchors does not move. Off: the body is free.
    Anchored = 12,
    /// Physics: an anchored body has weight.
    Gravity = 13,
    /// Outer faces look as the input does there.
    Attributes = 14,
    /// The input's own triangles, cut as the object is.
    Skin = 15,
}

impl EffectKind {
    /// Every effect, by number.
    pub const ALL: [Self; 16] = [
        Self::Elastic,
        Self::Tensile,
        Self::Interior,
        Self::Examples,
        Self::Slivers,
        Self::Release,
        Self::Normals,
        Self::Uv,
        Self::Bonds,
        Self::Debris,
        Self::Hulls,
        Self::Warp,
        Self::Anchored,
        Self::Gravity,
        Self::Attributes,
        Self::Skin,
    ];

    /// The name used in scenes and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elastic => "elastic",
            Self::Tensile => "tensile",
            Self::Interior => "interior",
            Self::Examples => "examples",
            Self::Slivers => "slivers",
            Self::Release => "release",
            Self::Normals => "normals",
            Self::Uv => "uv",
            Self::Bonds => "bonds",
            Self::Debris => "debris",
            Self::Hulls => "hulls",
            Self::Warp => "warp",
            Self::Anchored => "anchored",
            Self::Gravity => "gravity",
            Self::Attributes => "attributes",
            Self::Skin => "skin",
        }
    }
}

/// Some effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EffectSet(u32);

impl Default for EffectSet {
    /// Those that are on where nobody says otherwise.
    fn default() -> Self {
        Self::of([EffectKind::Elastic, EffectKind::Interior, EffectKind::Examples, EffectKind::Slivers])
    }
}

impl EffectSet {
    /// None.
    pub const NONE: Self = Self(0);

    /// These.
    pub fn of(effects: impl IntoIterator<Item = EffectKind>) -> Self {
        Self(effects.into_iter().fold(0, |bits, effect| bits | 1 << effect as u32))
    }

    /// True if `effect` is one of them.
    pub fn has(self, effect: EffectKind) -> bool {
        self.0 & (1 << effect as u32) != 0
    }

    /// These and `effect`.
    pub fn with(self, effect: EffectKind) -> Self {
        Self(self.0 | 1 << effect as u32)
    }

    /// These without `effect`.
    pub fn without(self, effect: EffectKind) -> Self {
        Self(self.0 & !(1 << effect as u32))
    }
}
