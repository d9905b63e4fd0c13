//! Effects: what a request simulates and sends beyond the bare fragments, one bit each. An effect that is off costs nothing.

use crate::name::suggestion;
use crate::text::quoted;
use crate::{Error, ErrorKind};

/// Kind of change that an effect makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The fragments.
    Physics,
    /// Its own section of the result alone.
    Output,
}

macro_rules! effects {
    ($($(#[$doc:meta])* $bit:literal $effect:ident $name:literal $class:ident $default:literal $needs:expr, $cost:literal;)*) => {
        /// An effect.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u32)]
        #[non_exhaustive]
        pub enum Effect {
            $($(#[$doc])* $effect = $bit,)*
        }

        impl Effect {
            /// Every effect, in the order of its bits, which have no gaps.
            pub const ALL: [Self; [$($bit),*].len()] = [$(Self::$effect),*];

            /// The name used in scenes, on command lines and in JSON.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$effect => $name,)*
                }
            }

            /// Kind of its change.
            pub fn class(self) -> Class {
                match self {
                    $(Self::$effect => Class::$class,)*
                }
            }

            /// Whether it is on by default.
            pub fn default_on(self) -> bool {
                match self {
                    $(Self::$effect => $default,)*
                }
            }

            /// When it costs time or memory: while baking, while loading, with every request.
            pub fn cost(self) -> &'static str {
                match self {
                    $(Self::$effect => $cost,)*
                }
            }

            /// The effect that it needs.
            pub fn needs(self) -> Option<Self> {
                match self {
                    $(Self::$effect => $needs,)*
                }
            }
        }
    };
}

effects! {
    /// Strain energy from the deformation of the body. Off: it falls off with the distance from the contacts.
    0 Elastic "elastic" Physics true None,
        "bake: lattice, basis, bound; load: lattice, stiffness, factor; strike: stage `elasticity`, unless a bound of E_1 is below γ";
    /// Tension alone drives cracks (Miehe et al. 2010).
    1 Tensile "tensile" Physics false Some(Self::Elastic),
        "strike: a spectral split per elastic tetrahedron";
    /// Interior distances. Off: straight ones.
    2 Interior "interior" Physics true None,
        "bake: eigenpairs; load: lift; strike: a longer lift in stage `centroidal`";
    /// The degree from the object's examples. Off: from the closed form.
    3 Examples "examples" Physics true None,
        "bake: optimized examples; load: network; strike: microseconds in stage `degree`";
    /// Slivers become part of the neighbor that they share most with.
    4 Slivers "slivers" Physics true None,
        "strike: areas of cracks, and a second tessellation where there is a sliver";
    /// Velocities of the fragments from the released strain energy.
    5 Release "release" Output false None,
        "strike: one pass over nodes; 48 bytes per fragment";
    /// Normals, one per vertex.
    6 Normals "normals" Output false None,
        "strike: one pass over triangles; 12 bytes per vertex";
    /// Texture coordinates of crack faces, one per vertex.
    7 Uv "uv" Output false None,
        "strike: one pass over vertices; 8 bytes per vertex";
    /// Contact areas between fragments.
    8 Bonds "bonds" Output false None,
        "strike: one pass over crack triangles; 64 bytes per pair";
    /// Points on crack faces from which dust and chips come.
    9 Debris "debris" Output false None,
        "strike: one pass over crack triangles; 40 bytes per point";
    /// Convex proxies of the fragments for collisions.
    10 Hulls "hulls" Output false None,
        "strike: a hull per fragment, fitted and measured; about 1 kB per fragment";
    /// Cells follow an artist's controls: grain, waves, paint, protected regions, sites.
    11 Warp "warp" Physics false None,
        "load: eigenpairs of the bent space, if something bends; strike: one pass over protected nodes";
    /// Nodes in the scene's anchors do not move. Off: the body is free.
    12 Anchored "anchored" Physics false Some(Self::Elastic),
        "load: a second factor; strike: as without, but a solve if the database has no displacements for the anchors, and the degree without examples";
    /// An anchored body has weight.
    13 Gravity "gravity" Physics false Some(Self::Anchored),
        "load: one solve; strike: one pass over elastic nodes";
    /// Outer faces look as the input does there: normals, texture coordinates, colors, materials.
    14 Attributes "attributes" Output false None,
        "bake: the nearest point of the input; load: attributes; strike: 20 bytes per vertex, \
         8 more with a second set of texture coordinates, 4 with colors, and 4 per triangle with materials";
    /// The input's own triangles, cut as the object is.
    15 Skin "skin" Output false None,
        "bake: where the input lies in the lattice; load: the input; strike: one pass over it";
    /// The response to the pulse: slow vibrations of the body follow a short contact only in part. Off: the peak force
    /// acts as if it were at rest.
    16 Dynamics "dynamics" Physics false Some(Self::Elastic),
        "bake: masses of the basis; load: eigenpairs of the basis; strike: 64 times of each vibration, and a second load";
}

impl Effect {
    /// Its bit.
    pub fn bit(self) -> u64 {
        1 << self as u32
    }

    /// The effect of that name.
    ///
    /// # Errors
    /// `unknown_effect`, whose message names the nearest.
    pub fn by_name(name: &str) -> Result<Self, Error> {
        let known = Self::ALL.into_iter().find(|effect| effect.name() == name);
        known.ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            let shown = quoted(name);
            let message = format!("there is no effect `{shown}`; {}", suggestion(name, &names));
            Error::new(ErrorKind::UnknownEffect, shown, message)
        })
    }
}

/// Some effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effects(u64);

impl Effects {
    /// The effects of these bits.
    ///
    /// # Errors
    /// `unknown_effect` at the lowest bit without an effect.
    pub fn from_bits(key: &str, bits: u64) -> Result<Self, Error> {
        let unknown = bits & !Self::of(Effect::ALL).0;
        if unknown == 0 {
            return Ok(Self(bits));
        }
        let bit = unknown.trailing_zeros();
        Err(Error::new(
            ErrorKind::UnknownEffect,
            bit.to_string(),
            format!("{key} bit {bit}: this version has no such effect"),
        ))
    }

    /// These.
    pub fn of(effects: impl IntoIterator<Item = Effect>) -> Self {
        Self(effects.into_iter().fold(0, |bits, effect| bits | effect.bit()))
    }

    /// The effects that are on by default.
    pub fn usual() -> Self {
        Self::of(Effect::ALL.into_iter().filter(|effect| effect.default_on()))
    }

    /// As bits.
    pub fn bits(self) -> u64 {
        self.0
    }

    /// Whether `effect` is one of them.
    pub fn has(self, effect: Effect) -> bool {
        self.0 & effect.bit() != 0
    }

    /// All of them, in the order of their bits.
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |effect| self.has(*effect))
    }

    /// These with `on` and without `off`. An effect that `on` does not name goes off with the effect that it needs.
    ///
    /// # Errors
    /// `effect` for one in both sets, and for one in `on` that needs another which is then off.
    pub fn changed(self, on: Self, off: Self) -> Result<Self, Error> {
        if let Some(effect) = Self(on.0 & off.0).iter().next() {
            let name = effect.name();
            return Err(conflict(effect, format!("the effect `{name}` is both switched on and switched off")));
        }
        let mut changed = Self((self.0 | on.0) & !off.0);
        for effect in changed.iter() {
            let Some(needs) = effect.needs().filter(|needs| !changed.has(*needs)) else { continue };
            if on.has(effect) {
                let missing = std::iter::successors(Some(needs), |effect| effect.needs());
                let missing: Vec<_> = missing.filter(|effect| !changed.has(*effect)).map(Effect::name).collect();
                let (are, them) = if missing.len() > 1 { ("are", "them") } else { ("is", "it") };
                let (name, missing) = (effect.name(), missing.join("` and `"));
                let message = format!("the effect `{name}` needs `{missing}`, which {are} off; switch {them} on, too");
                return Err(conflict(effect, message));
            }
            changed.0 &= !effect.bit();
        }
        Ok(changed)
    }
}

/// The error for an effect that cannot be switched as the request says.
pub fn conflict(effect: Effect, message: impl Into<String>) -> Error {
    Error::new(ErrorKind::Effect, effect.name(), message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effect_bits_are_positions_and_names_round_trip() {
        for (place, effect) in Effect::ALL.into_iter().enumerate() {
            assert_eq!((effect.bit(), Effect::by_name(effect.name()).unwrap()), (1 << place, effect));
            assert!(effect.needs().is_none_or(|needs| (needs as usize) < place), "needed effects come first");
        }
    }

    #[test]
    fn unknown_effects_are_rejected_with_a_suggestion() {
        for (name, nearest) in [("bond", "bonds"), ("tensil", "tensile"), ("normal", "normals"), ("UV", "uv")] {
            let error = Effect::by_name(name).unwrap_err();
            assert_eq!((error.kind, error.at.as_str()), (ErrorKind::UnknownEffect, name));
            assert!(name == "UV" || error.message.contains(&format!("`{nearest}`")), "{error}");
        }
        let error = Effects::from_bits("effects_on", 1 << 40 | 1).unwrap_err();
        assert_eq!((error.kind, error.at.as_str()), (ErrorKind::UnknownEffect, "40"));
    }

    #[test]
    fn invalid_values_are_rejected_by_name() {
        let changed = |on: &[Effect], off: &[Effect]| {
            Effects::usual().changed(Effects::of(on.iter().copied()), Effects::of(off.iter().copied()))
        };
        assert_eq!(changed(&[], &[]).unwrap(), Effects::usual());
        assert!(changed(&[Effect::Bonds], &[Effect::Interior]).unwrap().has(Effect::Bonds));
        assert_eq!(changed(&[Effect::Uv], &[Effect::Uv]).unwrap_err().at, "uv");
        let needy = changed(&[Effect::Tensile], &[Effect::Elastic]).unwrap_err();
        assert_eq!((needy.kind, needy.at.as_str()), (ErrorKind::Effect, "tensile"));
        let weight = Effects::default().changed(Effects::of([Effect::Gravity]), Effects::default()).unwrap_err();
        assert_eq!(
            weight.message,
            "the effect `gravity` needs `anchored` and `elastic`, which are off; switch them on, too"
        );
        let scene = Effects::of([Effect::Elastic, Effect::Tensile]);
        assert_eq!(scene.changed(Effects::default(), Effects::of([Effect::Elastic])).unwrap(), Effects::default());
    }
}
