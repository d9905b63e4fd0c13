//! Effects: options of a simulation beyond the bare fragments.

/// An effect. Effects of physics change the fragments; others only add to the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum EffectKind {
    /// Physics: strain energy from the deformation of the body. Off: from the distance to the contacts.
    Elastic = 0,
    /// Physics: only tension drives cracks.
    Tensile = 1,
    /// Physics: interior distances. Off: Euclidean ones.
    Interior = 2,
    /// Physics: the degree from the object's examples. Off: from the closed form.
    Examples = 3,
    /// Physics: slivers are merged into the neighbor with the largest common area.
    Slivers = 4,
    /// Velocities of the fragments from the released strain energy.
    Release = 5,
    /// Normals, one per vertex.
    Normals = 6,
    /// Texture coordinates of crack faces, one per vertex.
    Uv = 7,
    /// Pairs of fragments in contact, with areas and normals.
    Bonds = 8,
    /// Sources of dust and chips on crack faces.
    Debris = 9,
    /// Convex collision proxies of the fragments.
    Hulls = 10,
    /// Physics: cells follow an artist's controls.
    Warp = 11,
    /// Physics: nodes in the scene's anchors do not move. Off: the body is free.
    Anchored = 12,
    /// Physics: an anchored body has weight.
    Gravity = 13,
    /// Normals, texture coordinates and materials of the input on outer faces.
    Attributes = 14,
    /// Triangles of the input, cut into those of the fragments.
    Skin = 15,
    /// Physics: slow vibrations of a free body follow a short contact only in part. Off: the peak force acts as if it
    /// were at rest.
    Dynamics = 16,
}

impl EffectKind {
    /// All effects, by number.
    pub const ALL: [Self; 17] = [
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
        Self::Dynamics,
    ];

    /// Name used in scenes and JSON.
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
            Self::Dynamics => "dynamics",
        }
    }
}

/// A set of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EffectSet(u32);

impl Default for EffectSet {
    /// The effects that are on by default.
    fn default() -> Self {
        Self::of([EffectKind::Elastic, EffectKind::Interior, EffectKind::Examples, EffectKind::Slivers])
    }
}

impl EffectSet {
    /// The empty set.
    pub const NONE: Self = Self(0);

    /// The set of the given effects.
    pub fn of(effects: impl IntoIterator<Item = EffectKind>) -> Self {
        Self(effects.into_iter().fold(0, |bits, effect| bits | 1 << effect as u32))
    }

    /// True if the set contains `effect`.
    pub fn has(self, effect: EffectKind) -> bool {
        self.0 & (1 << effect as u32) != 0
    }

    /// The set with `effect`.
    #[must_use]
    pub fn with(self, effect: EffectKind) -> Self {
        Self(self.0 | 1 << effect as u32)
    }

    /// The set without `effect`.
    #[must_use]
    pub fn without(self, effect: EffectKind) -> Self {
        Self(self.0 & !(1 << effect as u32))
    }
}
