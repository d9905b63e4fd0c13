//! What a scene says about one object.

use super::names::{known, nearest};
use super::{BakeRecipe, anchors, invalid, warp};
use serde::Deserialize;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, Tables};
use shatter_fracture::degree::reference_gamma;
use shatter_fracture::pipeline::{AnchorError, PreparedObject};
use shatter_fracture::scene::{Anchors, Material, Materials, WarpControls, brief, toml_error};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_proto::Error;
use shatter_proto::effect::{Effect, Effects, conflict};
use shatter_proto::name::object_name;
use shatter_proto::request::{Lift, Quality, Request};
use std::path::Path;

/// Keys of an object, in the order in which the shipped scenes have them.
const KEYS: [&str; 19] = [
    "database",
    "shape",
    "material",
    "fragment_size_m",
    "gamma_j_m2",
    "elastic_spacing",
    "crack_spacing",
    "examples",
    "lift",
    "effects",
    "allow",
    "sites_max",
    "fragments_max",
    "bytes_max",
    "volume_min_m3",
    "quality",
    "warp",
    "anchors",
    "gravity_m_s2",
];

/// Effects for which a scene must say more than that they are on.
const SCENIC: [Effect; 3] = [Effect::Warp, Effect::Anchored, Effect::Gravity];

/// Lifts by name.
const LIFTS: [(&str, Lift); 3] =
    [("euclidean", Lift::Euclidean), ("interior", Lift::Interior), ("surface_diffusion", Lift::SurfaceDiffusion)];

/// What names a database.
const NAMES: &str = "it takes the name of a file in the folder that is served, without folders and without `.shatter`";

/// Shapes that the project generates.
pub const SHAPES: [&str; 6] = shapes::NAMES;

/// One object of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// Name of its database: that of the file, without its ending, in the folder that is served.
    pub database: String,
    /// A generated shape that it can be baked from.
    pub shape: Option<&'static str>,
    /// What it is made of.
    pub material: Option<(String, Material)>,
    /// Spacings of its lattices over the diagonal, if it is baked.
    pub elastic_spacing: Option<f64>,
    /// See there.
    pub crack_spacing: Option<f64>,
    /// Impacts that it learns from, if it is baked.
    pub examples: Option<u64>,
    /// How it is struck.
    pub terms: ObjectPolicy,
}

/// On what terms an object is struck: what strikes get that say nothing, and what they may ask for.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectPolicy {
    /// Effects that are on.
    pub on: Effects,
    /// Effects that strikes may switch on, those that are on among them.
    pub allowed: Effects,
    /// The lift where interior distances are on.
    pub lift: Lift,
    /// Reference fragment size, m, for γ.
    pub fragment_size_m: Option<f64>,
    /// γ, J·m²; goes before the fragment size.
    pub gamma_j_m2: Option<f64>,
    /// Sites at most.
    pub sites_max: Option<u32>,
    /// Fragments at most: a strike with more is refused.
    pub fragments_max: Option<u32>,
    /// Bytes of answer at most.
    pub bytes_max: Option<u64>,
    /// Smaller pieces become part of a neighbor, m³; needs `slivers`.
    pub volume_min_m3: Option<f64>,
    /// The preset of strikes that name none, and of the lattices if they are baked for it; without it strikes have that of the lattices.
    pub quality: Option<Quality>,
    /// What an artist says; needs `warp`.
    pub controls: WarpControls,
    /// What holds it where `anchored` is on.
    pub anchors: Anchors,
}

impl Default for ObjectPolicy {
    /// Those of an object that no scene speaks of.
    fn default() -> Self {
        Self {
            on: Effects::usual(),
            allowed: Effects::of(Effect::ALL.into_iter().filter(|effect| !SCENIC.contains(effect))),
            lift: Lift::Interior,
            fragment_size_m: None,
            gamma_j_m2: None,
            sites_max: None,
            fragments_max: None,
            bytes_max: None,
            volume_min_m3: None,
            quality: None,
            controls: WarpControls::default(),
            anchors: Anchors::default(),
        }
    }
}

impl ObjectPolicy {
    /// With everything on that these terms can prepare: what is held here is held there, too.
    #[must_use]
    pub fn rich(&self) -> Self {
        let scenic = SCENIC.into_iter().filter(|effect| self.allowed.has(*effect));
        let all = Effects::of(Self::default().allowed.iter().chain(scenic));
        Self {
            on: all,
            allowed: all,
            anchors: self.anchors.clone(),
            controls: self.controls.clone(),
            ..Self::default()
        }
    }

    /// The tables that some strike may need. Whether strikes may name another lift is a matter of what is loaded.
    pub fn tables(&self) -> Tables {
        if *self == Self::default() {
            return Tables::ALL;
        }
        let interior = self.allowed.has(Effect::Interior);
        Tables {
            elastic: self.allowed.has(Effect::Elastic),
            interior: interior && self.lift == Lift::Interior,
            surface_diffusion: interior && self.lift == Lift::SurfaceDiffusion,
            // They are made in the interior lift.
            examples: self.allowed.has(Effect::Examples) && interior && self.lift == Lift::Interior,
            attributes: self.allowed.has(Effect::Attributes),
            skin: self.allowed.has(Effect::Skin),
        }
    }

    /// The effects of `strike`. Refused by name: what cannot be, and what the scene does not prepare.
    ///
    /// # Errors
    /// `effect`: an effect that the scene does not prepare, that is on and off at once, or without what it needs.
    pub fn effects(&self, strike: &Request) -> Result<Effects, Error> {
        if let Some(effect) = strike.enable.iter().find(|effect| !self.allowed.has(*effect)) {
            let (object, name) = (&strike.object, effect.name());
            let key = match effect {
                Effect::Warp => ", with the table `warp`",
                _ if SCENIC.contains(&effect) => ", with the key `anchors`",
                _ => "",
            };
            let message = format!(
                "the effect `{name}` is not prepared: add \"{name}\" to `effects` or `allow` of [objects.{object}] in a scene{key}, and \
                 serve that scene"
            );
            return Err(conflict(effect, message));
        }
        let on = self.on.changed(strike.enable, strike.disable)?;
        let curved = |lift| lift != Lift::Euclidean;
        match strike.lift.map(curved) {
            _ if strike.enable.has(Effect::Interior) && !curved(strike.lift.unwrap_or(self.lift)) => {
                Err(conflict(Effect::Interior, "interior distances are switched on, but the lift is `euclidean`"))
            }
            Some(true) if !on.has(Effect::Interior) => {
                Err(conflict(Effect::Interior, "interior distances are off, but the lift has them"))
            }
            _ => Ok(on),
        }
    }

    /// Holds `prepared` if some strike may want it held.
    ///
    /// # Errors
    /// [`AnchorError`].
    pub fn anchor(&self, prepared: &mut PreparedObject) -> Result<(), AnchorError> {
        match self.allowed.has(Effect::Anchored) {
            true => prepared.anchor(&self.anchors, &CancelToken::default()),
            false => Ok(()),
        }
    }

    /// γ of an object of this material, unless it is the object's own.
    pub fn gamma(&self, material: &Material) -> Option<f64> {
        let sized = |size_m| reference_gamma(material.young_pa, material.strength_pa, size_m);
        self.gamma_j_m2.or(self.fragment_size_m.map(sized))
    }
}

/// Types of the values, after the keys have been checked.
#[derive(Deserialize)]
struct Values {
    database: Option<String>,
    shape: Option<String>,
    material: Option<String>,
    fragment_size_m: Option<f64>,
    gamma_j_m2: Option<f64>,
    elastic_spacing: Option<f64>,
    crack_spacing: Option<f64>,
    examples: Option<u64>,
    lift: Option<String>,
    effects: Option<Vec<String>>,
    #[serde(default)]
    allow: Vec<String>,
    sites_max: Option<u32>,
    fragments_max: Option<u32>,
    bytes_max: Option<u64>,
    volume_min_m3: Option<f64>,
    quality: Option<String>,
    #[serde(default)]
    warp: toml::Table,
    anchors: Option<Vec<toml::Table>>,
    gravity_m_s2: Option<[f64; 3]>,
}

impl SceneObject {
    /// The object `name`, from its table.
    pub(super) fn read(name: &str, table: &toml::Table, materials: &Materials, folder: &Path) -> Result<Self, Error> {
        let path = format!("objects.{name}");
        let path = path.as_str();
        known(path, table.keys(), &KEYS)?;
        let values = toml::Value::Table(table.clone()).try_into();
        let values: Values = values.map_err(|error: toml::de::Error| invalid(path, toml_error("", &error)))?;
        let at = |key: &str| format!("{path}.{key}");
        let numbers = [
            ("fragment_size_m", values.fragment_size_m),
            ("gamma_j_m2", values.gamma_j_m2),
            ("elastic_spacing", values.elastic_spacing),
            ("crack_spacing", values.crack_spacing),
            ("volume_min_m3", values.volume_min_m3),
            ("sites_max", values.sites_max.map(f64::from)),
            ("fragments_max", values.fragments_max.map(f64::from)),
            ("bytes_max", values.bytes_max.map(|bytes| bytes as f64)),
        ];
        for (key, value) in numbers {
            if value.is_some_and(|value| !(value.is_finite() && value > 0.0)) {
                return Err(invalid(at(key), "must be finite and above zero"));
            }
        }
        let database = values.database.unwrap_or_else(|| name.to_owned());
        object_name(&database)
            .map_err(|_| invalid(at("database"), format!("`{}` names no database: {NAMES}", brief(&database))))?;
        let material = values.material.map(|name| match materials.get(&name) {
            Ok(material) => Ok((name, material.clone())),
            Err(error) => Err(invalid(at("material"), error)),
        });
        let shape = values.shape.map(|name| {
            let found = SHAPES.into_iter().find(|shape| *shape == name);
            found.ok_or_else(|| {
                invalid(at("shape"), format!("`{}` is no shape; `{}` is", brief(&name), nearest(&name, &SHAPES)))
            })
        });
        let lift = values.lift.map_or(Ok(Lift::Interior), |name| named(&at("lift"), "lift", &name, LIFTS))?;
        let qualities = Quality::ALL.map(|quality| (quality.name(), quality));
        let quality = values.quality.map(|name| named(&at("quality"), "quality", &name, qualities)).transpose()?;
        let on = values.effects.map_or(Ok(Effects::usual()), |names| effects(&at("effects"), &names))?;
        // What is on must not need what is off.
        let on =
            Effects::default().changed(on, Effects::default()).map_err(|refusal| placed(&at("effects"), refusal))?;
        let more = effects(&at("allow"), &values.allow)?;
        if values.volume_min_m3.is_some() && !on.has(Effect::Slivers) {
            return Err(invalid(at("volume_min_m3"), "needs the effect `slivers`, which is off"));
        }
        let allowed = on.changed(more, Effects::default()).map_err(|refusal| placed(&at("allow"), refusal))?;
        let controls = warp::read(&at("warp"), &values.warp, folder)?;
        if controls.is_silent() == allowed.has(Effect::Warp) {
            return Err(invalid(
                at("warp"),
                "this table and the effect `warp` go together: one is there, the other is not",
            ));
        }
        let anchors = anchors::read(path, values.anchors.as_deref(), values.gravity_m_s2, allowed)?;
        let terms = ObjectPolicy {
            on,
            allowed,
            lift,
            fragment_size_m: values.fragment_size_m,
            gamma_j_m2: values.gamma_j_m2,
            sites_max: values.sites_max,
            fragments_max: values.fragments_max,
            bytes_max: values.bytes_max,
            volume_min_m3: values.volume_min_m3,
            quality,
            controls,
            anchors,
        };
        Ok(Self {
            database,
            shape: shape.transpose()?,
            material: material.transpose()?,
            elastic_spacing: values.elastic_spacing,
            crack_spacing: values.crack_spacing,
            examples: values.examples,
            terms,
        })
    }
}

impl SceneObject {
    /// What it is baked from, if its shape is a generated one.
    pub fn bake(&self, name: &str) -> Option<(RawMesh, BakeRequest)> {
        BakeRecipe::of(name, self).bake(name)
    }
}

/// What `name` stands for among `all`.
fn named<T: Copy, const N: usize>(path: &str, what: &str, name: &str, all: [(&str, T); N]) -> Result<T, Error> {
    let found = all.iter().find(|(known, _)| *known == name);
    let names = all.map(|(known, _)| known);
    let unknown = || invalid(path, format!("`{}` is no {what}; `{}` is", brief(name), nearest(name, &names)));
    found.map(|(_, value)| *value).ok_or_else(unknown)
}

fn effects(path: &str, names: &[String]) -> Result<Effects, Error> {
    let found = names.iter().map(|name| Effect::by_name(name));
    Ok(Effects::of(found.collect::<Result<Vec<_>, _>>().map_err(|refusal| placed(path, refusal))?))
}

/// The refusal, with where in the scene it is.
fn placed(path: &str, refusal: Error) -> Error {
    Error { message: format!("{path}: {}", refusal.message), ..refusal }
}
