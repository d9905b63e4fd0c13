//! What the databases of a scene are baked from.

use super::{Scene, SceneObject, invalid};
use crate::wire::preset;
use shatter_fracture::database::{BakeRequest, Tables};
use shatter_fracture::pipeline;
use shatter_fracture::scene::Material;
use shatter_fracture::surface::{RawMesh, shapes};
use shatter_proto::Error;
use std::collections::BTreeMap;

/// What a database is baked from.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeRecipe {
    /// The objects that are made of it.
    pub objects: Vec<String>,
    shape: Option<&'static str>,
    material: Option<(String, Material)>,
    elastic_spacing: Option<f64>,
    crack_spacing: Option<f64>,
    quality: pipeline::Preset,
    /// Whether the preset is named; one that is not must not sever parts.
    named: bool,
    examples: u64,
    fragment_size_m: Option<f64>,
    gamma_j_m2: Option<f64>,
    tables: Tables,
}

impl BakeRecipe {
    /// Of the database of one object.
    pub(super) fn of(name: &str, object: &SceneObject) -> Self {
        Self {
            objects: vec![name.to_owned()],
            shape: object.shape,
            material: object.material.clone(),
            elastic_spacing: object.elastic_spacing,
            crack_spacing: object.crack_spacing,
            quality: preset(object.terms.quality.unwrap_or_default()),
            named: object.terms.quality.is_some(),
            examples: object.examples.unwrap_or(0),
            fragment_size_m: object.terms.fragment_size_m,
            gamma_j_m2: object.terms.gamma_j_m2,
            tables: object.terms.tables(),
        }
    }

    /// Of a database that several objects are made of: what one of them says, and the tables of all. The threshold is each object's
    /// own; the database has what they agree on, if they do.
    fn of_all(all: &[(&str, &SceneObject)]) -> Result<Self, Error> {
        let objects = || all.iter().map(|(_, object)| *object);
        Ok(Self {
            objects: all.iter().map(|(name, _)| (*name).to_owned()).collect(),
            shape: said(all, "shape", |object| object.shape)?,
            material: said(all, "material", |object| object.material.clone())?,
            elastic_spacing: said(all, "elastic_spacing", |object| object.elastic_spacing)?,
            crack_spacing: said(all, "crack_spacing", |object| object.crack_spacing)?,
            named: objects().any(|object| object.terms.quality.is_some()),
            // Finer lattices serve coarser strikes.
            quality: objects().map(|object| preset(object.terms.quality.unwrap_or_default())).max().unwrap_or_default(),
            examples: said(all, "examples", |object| object.examples)?.unwrap_or(0),
            fragment_size_m: agreed(objects().filter_map(|object| object.terms.fragment_size_m)),
            gamma_j_m2: agreed(objects().filter_map(|object| object.terms.gamma_j_m2)),
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
            allows_severed: self.named,
            examples: self.examples,
            tables: self.tables,
            ..BakeRequest::new(name, material_name, material)
        };
        Some((mesh, request))
    }
}

impl Scene {
    /// What its databases are baked from, by their names. Refused by key: objects of one database that do not agree on what it is baked
    /// from, a shape without a material.
    ///
    /// # Errors
    /// `configuration` at a key on which the objects of one database differ, or for a shape without a material.
    pub fn recipes(&self) -> Result<BTreeMap<String, BakeRecipe>, Error> {
        let mut databases: BTreeMap<&str, Vec<(&str, &SceneObject)>> = BTreeMap::new();
        for (name, object) in &self.objects {
            databases.entry(&object.database).or_default().push((name, object));
        }
        let recipe = |(database, objects): (&str, Vec<(&str, &SceneObject)>)| {
            let recipe = BakeRecipe::of_all(&objects)?;
            if let (Some(_), None, Some(name)) = (recipe.shape, &recipe.material, recipe.objects.first()) {
                return Err(invalid(format!("objects.{name}.material"), "a shape is baked of a material"));
            }
            Ok((database.to_owned(), recipe))
        };
        databases.into_iter().map(recipe).collect()
    }
}

/// What those objects say under `key` that say anything; refused where two of them differ.
fn said<T: PartialEq>(
    all: &[(&str, &SceneObject)],
    key: &str,
    of: impl Fn(&SceneObject) -> Option<T>,
) -> Result<Option<T>, Error> {
    let mut values = all.iter().filter_map(|(name, object)| Some((name, &object.database, of(object)?)));
    let Some((first, database, value)) = values.next() else { return Ok(None) };
    match values.find(|(.., other)| *other != value) {
        None => Ok(Some(value)),
        Some((name, ..)) => {
            let why = format!("objects.{first}, of the same database `{database}`, says otherwise");
            Err(invalid(format!("objects.{name}.{key}"), why))
        }
    }
}

/// The one value of all, if there is one.
fn agreed(mut values: impl Iterator<Item = f64>) -> Option<f64> {
    let first = values.next()?;
    values.all(|other| other == first).then_some(first)
}
