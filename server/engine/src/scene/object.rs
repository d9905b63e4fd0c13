//! One object of a scene file.

use super::names::known;
use super::{BakeRecipe, anchors, elements, invalid, unsuitable, warp, wrong_type};
use serde::Deserialize;
use shatter_fracture::cancel_token::CancelToken;
use shatter_fracture::database::{BakeRequest, EXAMPLES_MAX, Tables};
use shatter_fracture::degree::reference_gamma;
use shatter_fracture::lattice::SPACING_RANGE;
use shatter_fracture::pipeline::{AnchorError, DEGREE_MAX, ElementChoice, PreparedObject, SurfaceKind};
use shatter_fracture::scene::{Anchors, Material, Materials, WarpControls, brief};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_proto::Error;
use shatter_proto::effect::{Effect, Effects, conflict};
use shatter_proto::name::{object_name, suggestion};
use shatter_proto::request::{Lift, Quality, Request, RequestedCriterion};
use shatter_proto::text::number;
use std::path::Path;

/// Keys of an object, in the order of the shipped scenes.
pub const OBJECT_KEYS: [&str; 23] = [
    "database",
    "shape",
    "material",
    "fragment_size_m",
    "gamma_j_m2",
    "criterion",
    "strength_scale",
    "elastic_spacing",
    "crack_spacing",
    "elements",
    "surface",
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

/// Effects that need further keys in the scene.
const SCENIC: [Effect; 3] = [Effect::Warp, Effect::Anchored, Effect::Gravity];

/// Lifts by name.
const LIFTS: [(&str, Lift); 3] =
    [("euclidean", Lift::Euclidean), ("interior", Lift::Interior), ("surface_diffusion", Lift::SurfaceDiffusion)];

/// Advice on database names.
const NAMES: &str =
    "use the name of a file in the database folder, without folders, without `.shatter` and without a leading dot";

/// Names of the generated shapes.
pub const SHAPES: [&str; 7] = shapes::NAMES;

/// Object of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// Name of its database: the file name in the database folder, without extension.
    pub database: String,
    /// Generated shape from which it can be baked.
    pub shape: Option<&'static str>,
    /// Name and properties of its material.
    pub material: Option<(String, Material)>,
    /// Spacing of the elastic lattice for baking, as a fraction of the diagonal.
    pub elastic_spacing: Option<f64>,
    /// Spacing of the crack lattice for baking, as a fraction of the diagonal.
    pub crack_spacing: Option<f64>,
    /// Order of the elements for baking.
    pub elements: Option<ElementChoice>,
    /// Surface of the fragments for baking.
    pub surface: Option<SurfaceKind>,
    /// Number of example impacts for baking.
    pub examples: Option<u64>,
    /// Defaults and limits of requests.
    pub terms: ObjectPolicy,
}

/// Defaults and limits of requests for an object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectPolicy {
    /// Effects that are on by default.
    pub on: Effects,
    /// Effects that requests may switch on, including those that are on by default.
    pub allowed: Effects,
    /// Lift for interior distances.
    pub lift: Lift,
    /// Reference fragment size for γ, m.
    pub fragment_size_m: Option<f64>,
    /// γ, J·m²; overrides the fragment size.
    pub gamma_j_m2: Option<f64>,
    /// Rule that decides whether the object breaks, for requests that name none.
    pub criterion: RequestedCriterion,
    /// Factor on the load that the object withstands, under both criteria.
    pub strength_scale: f64,
    /// Maximum number of sites.
    pub sites_max: Option<u32>,
    /// Maximum number of fragments; requests that produce more are refused.
    pub fragments_max: Option<u32>,
    /// Maximum size of a result, bytes.
    pub bytes_max: Option<u64>,
    /// Volume below which a fragment is merged into a neighbor, m³; needs `slivers`.
    pub volume_min_m3: Option<f64>,
    /// Preset of requests that name none, and of the lattices baked for the object; `None`: requests use the preset of the lattices.
    pub quality: Option<Quality>,
    /// Controls for artists; needs `warp`.
    pub controls: WarpControls,
    /// Anchors; used if `anchored` is on.
    pub anchors: Anchors,
}

impl Default for ObjectPolicy {
    /// Policy of an object without a scene.
    fn default() -> Self {
        Self {
            on: Effects::usual(),
            allowed: Effects::of(Effect::ALL.into_iter().filter(|effect| !SCENIC.contains(effect))),
            lift: Lift::Interior,
            fragment_size_m: None,
            gamma_j_m2: None,
            criterion: RequestedCriterion::Paper,
            strength_scale: 1.0,
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
    /// Policy with all effects on that the scene can prepare, with its anchors and controls; without `dynamics`, which
    /// excludes `anchored` and bodies without a basis.
    #[must_use]
    pub fn rich(&self) -> Self {
        let scenic = SCENIC.into_iter().filter(|effect| self.allowed.has(*effect));
        let usual = Self::default().allowed.iter().filter(|effect| *effect != Effect::Dynamics);
        let all = Effects::of(usual.chain(scenic));
        Self {
            on: all,
            allowed: all,
            anchors: self.anchors.clone(),
            controls: self.controls.clone(),
            ..Self::default()
        }
    }

    /// Tables that some request may need. Requests for another lift depend on which lifts were loaded.
    pub fn tables(&self) -> Tables {
        if *self == Self::default() {
            return Tables::ALL;
        }
        let interior = self.allowed.has(Effect::Interior);
        Tables {
            elastic: self.allowed.has(Effect::Elastic),
            interior: interior && self.lift == Lift::Interior,
            surface_diffusion: interior && self.lift == Lift::SurfaceDiffusion,
            // Examples are computed in the interior lift.
            examples: self.allowed.has(Effect::Examples) && interior && self.lift == Lift::Interior,
            attributes: self.allowed.has(Effect::Attributes),
            skin: self.allowed.has(Effect::Skin),
        }
    }

    /// Effects of `strike`. Refuses impossible combinations and effects that the scene does not prepare.
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
            let bake = match effect {
                Effect::Elastic | Effect::Interior | Effect::Attributes | Effect::Skin => {
                    ", bake the object anew by `shatterd bake` if its database has no such table"
                }
                _ => "",
            };
            let message = format!(
                "the effect `{name}` is not prepared: add \"{name}\" to `effects` or `allow` of [objects.{object}] in a scene{key}{bake}, \
                 and serve it by `shatterd serve --scene FILE`"
            );
            return Err(conflict(effect, message));
        }
        let on = self.on.changed(strike.enable, strike.disable)?;
        let curved = |lift| lift != Lift::Euclidean;
        match strike.lift.map(curved) {
            _ if strike.enable.has(Effect::Interior) && !curved(strike.lift.unwrap_or(self.lift)) => {
                Err(conflict(Effect::Interior, "interior distances are on, but the lift is `euclidean`; change one"))
            }
            Some(true) if !on.has(Effect::Interior) => Err(conflict(
                Effect::Interior,
                "the lift needs interior distances, which are off; bake it with `interior`, and enable that",
            )),
            _ => Ok(on),
        }
    }

    /// Adds the anchors to `prepared` if some request may need them, and drops the bases of other anchors.
    ///
    /// # Errors
    /// [`AnchorError`].
    pub fn anchor(&self, prepared: &mut PreparedObject) -> Result<(), AnchorError> {
        if self.allowed.has(Effect::Anchored) {
            prepared.anchor(&self.anchors, &CancelToken::default())?;
        }
        prepared.anchored_bases = Vec::new();
        Ok(())
    }

    /// γ of an object of this material, J·m²; `None` if the database's own γ applies.
    pub fn gamma(&self, material: &Material) -> Option<f64> {
        let sized = |size_m| reference_gamma(material.young_pa, material.strength_pa, size_m);
        let own = self.gamma_j_m2.or(self.fragment_size_m.map(sized));
        own.map(|gamma_j_m2| self.strength_scale.powi(2) * gamma_j_m2)
    }
}

/// Values of an object's table, after the keys have been checked.
#[derive(Deserialize)]
struct Values {
    database: Option<String>,
    shape: Option<String>,
    material: Option<String>,
    fragment_size_m: Option<f64>,
    gamma_j_m2: Option<f64>,
    criterion: Option<String>,
    strength_scale: Option<f64>,
    elastic_spacing: Option<f64>,
    crack_spacing: Option<f64>,
    elements: Option<String>,
    surface: Option<String>,
    examples: Option<u64>,
    lift: Option<String>,
    effects: Option<Vec<toml::Value>>,
    #[serde(default)]
    allow: Vec<toml::Value>,
    sites_max: Option<u32>,
    fragments_max: Option<u32>,
    bytes_max: Option<u64>,
    volume_min_m3: Option<f64>,
    quality: Option<String>,
    #[serde(default)]
    warp: toml::Table,
    #[serde(default)]
    anchors: Vec<toml::Value>,
    gravity_m_s2: Option<[f64; 3]>,
}

/// Possible values of the numbers, by key.
pub(super) const RANGES: [(&str, &str); 10] = [
    ("fragment_size_m", "a number of meters from 1e-9 to 1e9, without quotes or unit, as in 0.02"),
    ("gamma_j_m2", "a number from 1e-30 to 1e30"),
    ("strength_scale", "a number from 0.001 to 1000"),
    ("elastic_spacing", SPACING),
    ("crack_spacing", SPACING),
    ("volume_min_m3", POSITIVE),
    ("examples", "a whole number from 0 to 1048576"),
    ("sites_max", SITES),
    ("fragments_max", COUNT),
    ("bytes_max", "a whole number from 1 to 9223372036854775807"),
];

const POSITIVE: &str = "a finite number above 0";
const SPACING: &str = "a number from 0.002 to 0.25, a fraction of the bounding-box diagonal";
const COUNT: &str = "a whole number from 1 to 4294967295";
const SITES: &str = "a whole number from 1 to 512";
const _: () =
    assert!(SPACING_RANGE[0] == 0.002 && SPACING_RANGE[1] == 0.25 && EXAMPLES_MAX == 1_048_576 && DEGREE_MAX == 512);

impl Values {
    /// Checks the ranges of the numbers of the object at `path`.
    ///
    /// # Errors
    /// `configuration` at the first number that is not possible.
    fn check_numbers(&self, path: &str) -> Result<(), Error> {
        let positive = |value: Option<f64>| value.map(|value| (number(value), value.is_finite() && value > 0.0));
        let within = |value: Option<f64>, [low, high]: [f64; 2]| {
            value.map(|value| (number(value), (low..=high).contains(&value)))
        };
        let count = |value: Option<u32>| value.map(|value| (value.to_string(), value > 0));
        let values = [
            within(self.fragment_size_m, [1e-9, 1e9]),
            within(self.gamma_j_m2, [1e-30, 1e30]),
            within(self.strength_scale, [1e-3, 1e3]),
            within(self.elastic_spacing, SPACING_RANGE),
            within(self.crack_spacing, SPACING_RANGE),
            positive(self.volume_min_m3),
            self.examples.map(|value| (value.to_string(), value <= EXAMPLES_MAX as u64)),
            self.sites_max.map(|value| (value.to_string(), (1..=DEGREE_MAX).contains(&value))),
            count(self.fragments_max),
            self.bytes_max.map(|value| (value.to_string(), value > 0)),
        ];
        let wrong = RANGES.iter().zip(values).find_map(|((key, range), value)| match value {
            Some((value, false)) => Some(unsuitable(format!("{path}.{key}"), &value, range)),
            _ => None,
        });
        wrong.map_or(Ok(()), Err)?;
        match (self.elastic_spacing, self.crack_spacing) {
            (Some(elastic), Some(crack)) if crack > elastic => {
                let range = format!("{}, the value of `elastic_spacing`, or less", number(elastic));
                Err(unsuitable(format!("{path}.crack_spacing"), &number(crack), &range))
            }
            _ => Ok(()),
        }
    }
}

impl SceneObject {
    /// Reads the object `name` from its table.
    pub(super) fn read(name: &str, table: &toml::Table, materials: &Materials, folder: &Path) -> Result<Self, Error> {
        let path = format!("objects.{name}");
        let path = path.as_str();
        known(path, table.keys(), &OBJECT_KEYS)?;
        let values = toml::Value::Table(table.clone()).try_into();
        let values: Values = values.map_err(|error| wrong_type(path, &error, &RANGES))?;
        let at = |key: &str| format!("{path}.{key}");
        values.check_numbers(path)?;
        let database = values.database.unwrap_or_else(|| name.to_owned());
        if object_name(&database).is_err() || database.starts_with('.') {
            return Err(invalid(at("database"), format!("`{}` is no database name; {NAMES}", brief(&database))));
        }
        let material = values.material.map(|name| match materials.get(&name) {
            Ok(material) => Ok((name, material.clone())),
            Err(error) => Err(invalid(at("material"), error)),
        });
        let shape = values.shape.map(|name| {
            let found = SHAPES.into_iter().find(|shape| *shape == name);
            found.ok_or_else(|| {
                invalid(at("shape"), format!("`{}` is not a shape; {}", brief(&name), suggestion(&name, &SHAPES)))
            })
        });
        let lift = values.lift.map_or(Ok(Lift::Interior), |name| named(&at("lift"), "lift", &name, LIFTS))?;
        let criteria = RequestedCriterion::ALL.map(|criterion| (criterion.name(), criterion));
        let criterion = values
            .criterion
            .map_or(Ok(RequestedCriterion::Paper), |name| named(&at("criterion"), "criterion", &name, criteria))?;
        let qualities = Quality::ALL.map(|quality| (quality.name(), quality));
        let quality = values.quality.map(|name| named(&at("quality"), "quality", &name, qualities)).transpose()?;
        let orders = ElementChoice::ALL.map(|kind| (kind.name(), kind));
        let elements = values.elements.map(|name| named(&at("elements"), "elements", &name, orders)).transpose()?;
        let surfaces = SurfaceKind::ALL.map(|kind| (kind.name(), kind));
        let surface = values.surface.map(|name| named(&at("surface"), "surface", &name, surfaces)).transpose()?;
        let on = values.effects.map_or(Ok(Effects::usual()), |names| effects(&at("effects"), &names))?;
        // An effect that is on must not need one that is off.
        let on = Effects::default().changed(on, Effects::default()).map_err(|error| placed(&at("effects"), error))?;
        let more = effects(&at("allow"), &values.allow)?;
        if values.volume_min_m3.is_some() && !on.has(Effect::Slivers) {
            return Err(invalid(at("volume_min_m3"), "needs the effect `slivers`, which is off"));
        }
        let allowed = on.changed(more, Effects::default()).map_err(|error| placed(&at("allow"), error))?;
        let controls = warp::read(&at("warp"), &values.warp, folder)?;
        if controls.is_silent() == allowed.has(Effect::Warp) {
            return Err(invalid(
                at("warp"),
                "this table and the effect `warp` go together; add the missing one or remove both",
            ));
        }
        let anchors = anchors::read(path, &values.anchors, values.gravity_m_s2, allowed)?;
        let terms = ObjectPolicy {
            on,
            allowed,
            lift,
            fragment_size_m: values.fragment_size_m,
            gamma_j_m2: values.gamma_j_m2,
            criterion,
            strength_scale: values.strength_scale.unwrap_or(1.0),
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
            elements,
            surface,
            examples: values.examples,
            terms,
        })
    }
}

impl SceneObject {
    /// Mesh and parameters for baking the object, if its shape is a generated one.
    pub fn bake(&self, name: &str) -> Option<(RawMesh, BakeRequest)> {
        BakeRecipe::of(name, self).bake(name)
    }
}

/// Looks `name` up in `all`.
fn named<T: Copy, const N: usize>(path: &str, what: &str, name: &str, all: [(&str, T); N]) -> Result<T, Error> {
    let found = all.iter().find(|(known, _)| *known == name);
    let names = all.map(|(known, _)| known);
    let unknown = || invalid(path, format!("`{}` is not a {what}; {}", brief(name), suggestion(name, &names)));
    found.map(|(_, value)| *value).ok_or_else(unknown)
}

fn effects(path: &str, names: &[toml::Value]) -> Result<Effects, Error> {
    let names: Vec<String> = elements(path, names)?;
    let found = names.iter().map(|name| Effect::by_name(name));
    Ok(Effects::of(found.collect::<Result<Vec<_>, _>>().map_err(|error| placed(path, error))?))
}

/// Prefixes an error with its place in the scene.
fn placed(path: &str, error: Error) -> Error {
    Error { message: format!("{path}: {}", error.message), ..error }
}
