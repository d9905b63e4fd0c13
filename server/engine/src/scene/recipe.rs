//! Inputs of the databases of a scene.

use super::{Scene, SceneObject, invalid};
use crate::wire::preset;
use shatter_fracture::database::{BakeRequest, Tables};
use shatter_fracture::pipeline::{self, ElementChoice, SurfaceKind};
use shatter_fracture::scene::{MATERIALS, Material, Materials};
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_proto::Error;
use std::collections::BTreeMap;

/// Inputs of a database.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeRecipe {
    /// Objects that use the database.
    pub objects: Vec<String>,
    shape: Option<&'static str>,
    material: Option<(String, Material)>,
    elastic_spacing: Option<f64>,
    crack_spacing: Option<f64>,
    elements: ElementChoice,
    surface: SurfaceKind,
    quality: pipeline::Preset,
    /// Whether the scene names the preset; an unnamed preset must not sever parts.
    named: bool,
    examples: u64,
    fragment_size_m: Option<f64>,
    gamma_j_m2: Option<f64>,
    tables: Tables,
}

impl BakeRecipe {
    /// Inputs of the database of one object.
    pub(super) fn of(name: &str, object: &SceneObject) -> Self {
        Self {
            objects: vec![name.to_owned()],
            shape: object.shape,
            material: object.material.clone(),
            elastic_spacing: object.elastic_spacing,
            crack_spacing: object.crack_spacing,
            elements: object.elements.unwrap_or_default(),
            surface: object.surface.unwrap_or(SurfaceKind::Exact),
            quality: preset(object.terms.quality.unwrap_or_default()),
            named: object.terms.quality.is_some(),
            examples: object.examples.unwrap_or(0),
            fragment_size_m: object.terms.fragment_size_m,
            gamma_j_m2: object.terms.gamma_j_m2,
            tables: object.terms.tables(),
        }
    }

    /// Inputs of a database that several objects share: the values that any of them gives, and the tables of all. The fracture threshold is
    /// per object; the database stores it only if all objects agree.
    fn of_all(all: &[(&str, &SceneObject)]) -> Result<Self, Error> {
        let objects = || all.iter().map(|(_, object)| *object);
        Ok(Self {
            objects: all.iter().map(|(name, _)| (*name).to_owned()).collect(),
            shape: stated(all, "shape", |object| object.shape)?,
            material: stated(all, "material", |object| object.material.clone())?,
            elastic_spacing: stated(all, "elastic_spacing", |object| object.elastic_spacing)?,
            crack_spacing: stated(all, "crack_spacing", |object| object.crack_spacing)?,
            elements: stated(all, "elements", |object| object.elements)?.unwrap_or_default(),
            surface: stated(all, "surface", |object| object.surface)?.unwrap_or(SurfaceKind::Exact),
            named: objects().any(|object| object.terms.quality.is_some()),
            // Finer lattices also serve requests of coarser presets.
            quality: objects().map(|object| preset(object.terms.quality.unwrap_or_default())).max().unwrap_or_default(),
            examples: stated(all, "examples", |object| object.examples)?.unwrap_or(0),
            fragment_size_m: common_value(objects().filter_map(|object| object.terms.fragment_size_m)),
            gamma_j_m2: common_value(objects().filter_map(|object| object.terms.gamma_j_m2)),
            tables: objects().map(|object| object.terms.tables()).fold(Tables::NONE, Tables::and),
        })
    }

    /// Mesh and parameters of the database `name`; `None` without a generated shape and a material.
    pub fn bake(&self, name: &str) -> Option<(RawMesh, BakeRequest)> {
        let mesh = shapes::by_name(self.shape?)?;
        let (material_name, material) = self.material.clone()?;
        let request = BakeRequest {
            fragment_size_m: self.fragment_size_m,
            gamma_j_m2: self.gamma_j_m2,
            elastic_spacing: self.elastic_spacing,
            crack_spacing: self.crack_spacing,
            quality: self.quality,
            elements: self.elements,
            surface: self.surface,
            allows_severed: self.named,
            examples: self.examples,
            tables: self.tables,
            ..BakeRequest::new(name, material_name, material)
        };
        Some((mesh, request))
    }
}

impl Scene {
    /// Inputs of the databases, by name.
    ///
    /// Refuses objects of one database with different inputs, and a shape without a material; errors name the key.
    ///
    /// # Errors
    /// `configuration` at a key on which the objects of one database differ, or for a shape without a material.
    pub fn recipes(&self) -> Result<BTreeMap<String, BakeRecipe>, Error> {
        let mut databases: BTreeMap<&str, Vec<(&str, &SceneObject)>> = BTreeMap::new();
        for (name, object) in &self.objects {
            databases.entry(&object.database).or_default().push((name, object));
        }
        let materials = Materials::parse(MATERIALS);
        let recipe = |(database, objects): (&str, Vec<(&str, &SceneObject)>)| {
            let recipe = BakeRecipe::of_all(&objects)?;
            if let (Some(_), None, Some(name)) = (recipe.shape, &recipe.material, recipe.objects.first()) {
                let key = format!("objects.{name}.material");
                let known: Vec<&str> = materials.iter().flat_map(Materials::names).collect();
                let reason = format!("missing; an object with a `shape` needs one of {}", known.join(", "));
                return Err(invalid(key, reason));
            }
            Ok((database.to_owned(), recipe))
        };
        databases.into_iter().map(recipe).collect()
    }
}

/// Refuses keys that set how a database is baked if no object that uses the database has a shape: they would change nothing.
pub(super) fn check_unused_keys(objects: &BTreeMap<String, SceneObject>) -> Result<(), Error> {
    let has_shape = |of: &SceneObject| objects.values().any(|own| own.database == of.database && own.shape.is_some());
    for (name, object) in objects.iter().filter(|(_, object)| !has_shape(object)) {
        for (key, option, is_given) in [
            ("elastic_spacing", "--elastic-spacing", object.elastic_spacing.is_some()),
            ("crack_spacing", "--crack-spacing", object.crack_spacing.is_some()),
            ("elements", "--elements", object.elements.is_some()),
            ("surface", "--surface", object.surface.is_some()),
            ("examples", "--examples", object.examples.is_some()),
        ] {
            if is_given {
                let why = format!("needs `shape`; for a mesh of your own, remove it and bake with `{option}`");
                return Err(invalid(format!("objects.{name}.{key}"), why));
            }
        }
    }
    Ok(())
}

/// Value that the objects give under `key`; refuses different values.
fn stated<T: PartialEq>(
    all: &[(&str, &SceneObject)],
    key: &str,
    of: impl Fn(&SceneObject) -> Option<T>,
) -> Result<Option<T>, Error> {
    let mut values = all.iter().filter_map(|(name, object)| Some((name, &object.database, of(object)?)));
    let Some((first, database, value)) = values.next() else { return Ok(None) };
    match values.find(|(.., other)| *other != value) {
        None => Ok(Some(value)),
        Some((name, ..)) => {
            let why =
                format!("differs from objects.{first}, which uses the same database `{database}`; make them equal");
            Err(invalid(format!("objects.{name}.{key}"), why))
        }
    }
}

/// The common value, if all values are equal.
fn common_value(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|other| other == first).then_some(first)
}
