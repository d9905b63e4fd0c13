//! Conversion of a prepared object to tensors and metadata, and back.

use super::container::{ContainerContents, FLAT, Tensors, write};
use super::lattice_tensors::{lattice, put_lattice};
use super::learned::{self, EXAMPLES_MAX, QUALITY_KEY};
use super::reduced::{self, REDUCTION_KEY};
use super::share::{BakeShare, PartialBake, ShareRemainder, ShareTask};
use super::{DatabaseError, FORMAT, Tables, bake_request, cutting, elastic_values, skins, stored_values};
use crate::cancel_token::CancelToken;
use crate::elasticity::ElementOrder;
use crate::lattice::{EnergyTransfer, Lattice};
use crate::lift::{LiftKind, LiftedLattice};
use crate::pipeline::{
    BakeParameters, BakeReport, ElasticModel, EnergyUpperBound, PreparedBody, PreparedObject, ReductionErrors,
};
use crate::scene::brief;
use crate::surface::LocalFrame;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Largest number of bodies of an object.
pub const BODIES_MAX: usize = 4096;

/// Prefix of the names of tensors that do not depend on examples.
pub(super) const BASE: &str = "body";

/// Tensor of a body's bound of E_1, part of its elasticity; optional.
const BOUND: &str = "elastic.bound";

/// Tensors of a body's elasticity.
const ELASTIC: [&str; 6] =
    ["elastic.nodes", "elastic.tets", "transfer.tets", "transfer.shares", "transfer.offsets", BOUND];

/// Metadata key of [`ShareTask`], present only in a share of a bake.
const SHARE_KEY: &str = "share";

/// Largest dimension of a lift.
const DIMENSION_MAX: usize = 512;

/// Metadata key "shape": data that the tensors alone do not determine.
#[derive(Serialize, Deserialize)]
struct Shape {
    frame: LocalFrame,
    gamma_j_m2: f64,
    kappa: f64,
    /// Dimension of each body's interior lift; `None` without one.
    interior_dimensions: Vec<Option<usize>>,
    /// Dimension of each body's surface lift; `None` without one.
    surface_diffusion_dimensions: Vec<Option<usize>>,
    /// Number of impacts drawn for the examples.
    impacts: u64,
}

/// Metadata key "provenance": the program that wrote the file. No time and no host, so that equal inputs give equal
/// bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the command.
    pub program: String,
    /// Version of the command.
    pub version: String,
}

/// Writes `prepared` to `path`, atomically through a temporary file.
///
/// ```
/// use shatter_fracture::{BakeRequest, Material, database, surface::shapes};
///
/// let request = BakeRequest {
///     elastic_spacing: Some(0.1),
///     crack_spacing: Some(0.08),
///     ..BakeRequest::new("block", "glass", Material::named("glass")?)
/// };
/// let block = request.bake(shapes::cuboid([0.2, 0.1, 0.1]))?;
/// let file = std::env::temp_dir().join(format!("block-{}.shatter", std::process::id()));
/// database::save(&block, &file)?;
/// let loaded = database::load(&file)?;
/// assert_eq!(loaded.gamma_j_m2, block.gamma_j_m2);
/// # std::fs::remove_file(&file)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`DatabaseError`] by the file that cannot be written.
pub fn save(prepared: &PreparedObject, path: &Path) -> Result<(), DatabaseError> {
    write_object(prepared, None, path)
}

/// Writes a share to `path`, atomically through a temporary file.
///
/// # Errors
/// Those of [`save`].
pub fn save_partial(partial: &PartialBake, path: &Path) -> Result<(), DatabaseError> {
    write_object(&partial.prepared, Some(&partial.task), path)
}

fn write_object(prepared: &PreparedObject, task: Option<&ShareTask>, path: &Path) -> Result<(), DatabaseError> {
    let mut tensors = Tensors::default();
    for (index, body) in prepared.bodies.iter().enumerate() {
        let name = |part: &str| format!("{BASE}{index}.{part}");
        if let Some(solid) = &body.solid {
            put_lattice(&mut tensors, &name("elastic"), &solid.lattice);
            let EnergyTransfer { offsets, tets, shares } = &solid.transfer;
            tensors.u32(name("transfer.offsets"), &[offsets.len()], offsets);
            tensors.u32(name("transfer.tets"), &[tets.len()], tets);
            tensors.f64(name("transfer.shares"), &[shares.len()], shares);
        }
        if let Some(bound) = &body.bound {
            let values = bound.values();
            tensors.f64(name(BOUND), &[values.len()], &values);
        }
        put_lattice(&mut tensors, &name("crack"), &body.crack);
        if let Some(cutting) = &body.cutting {
            cutting::put(&mut tensors, &name, cutting);
        }
        for (part, lift) in [("interior", &body.interior), ("surface_diffusion", &body.surface_diffusion)] {
            if let Some(lift) = lift {
                let shape = [body.crack.nodes.len(), lift.dimension];
                tensors.f64(name(part), &shape, &lift.coordinates);
            }
        }
    }
    skins::put(&mut tensors, prepared);
    reduced::put(&mut tensors, prepared);
    learned::put_examples(&mut tensors, &prepared.examples);
    if let Some(learned) = &prepared.learned {
        learned::put_network(&mut tensors, &learned.network);
    }
    let dimensions = |lift: fn(&PreparedBody) -> Option<&LiftedLattice>| {
        prepared.bodies.iter().map(|body| lift(body).map(|lift| lift.dimension)).collect()
    };
    let shape = Shape {
        frame: prepared.frame,
        gamma_j_m2: prepared.gamma_j_m2,
        kappa: prepared.kappa,
        interior_dimensions: dimensions(|body| body.interior.as_ref()),
        surface_diffusion_dimensions: dimensions(|body| body.surface_diffusion.as_ref()),
        impacts: prepared.impacts,
    };
    let provenance = Provenance { program: "shatterd bake".into(), version: env!("CARGO_PKG_VERSION").into() };
    let mut metadata = BTreeMap::from([
        ("shatter_format".to_owned(), FORMAT.to_owned()),
        ("object".to_owned(), prepared.name.clone()),
        ("parameters".to_owned(), json("parameters", &prepared.parameters)?),
        ("report".to_owned(), json("report", &prepared.report)?),
        ("shape".to_owned(), json("shape", &shape)?),
        ("provenance".to_owned(), json("provenance", &provenance)?),
    ]);
    if let Some(learned) = &prepared.learned {
        metadata.insert(QUALITY_KEY.to_owned(), json(QUALITY_KEY, &learned.quality)?);
    }
    if let Some(reduction) = &prepared.reduction {
        metadata.insert(REDUCTION_KEY.to_owned(), json(REDUCTION_KEY, reduction)?);
    }
    if let Some(task) = task {
        metadata.insert(SHARE_KEY.to_owned(), json(SHARE_KEY, task)?);
    }
    write(path, &tensors, metadata)
}

fn json<T: Serialize>(key: &'static str, value: &T) -> Result<String, DatabaseError> {
    serde_json::to_string(value).map_err(|error| DatabaseError::Metadata { key, reason: error.to_string() })
}

/// Loads and verifies `path`: checksums, shapes, ranges, finite values, orientation.
///
/// Bodies without a reduced basis are factored. Other bodies are factored when first needed
/// ([`PreparedObject::factor`]).
///
/// # Errors
/// [`DatabaseError`] by what is damaged, missing, or of another format.
pub fn load(path: &Path) -> Result<PreparedObject, DatabaseError> {
    load_tables(path, Tables::ALL)
}

/// As [`load`], but only the given tables, if the object has them. Other tables are neither verified nor loaded.
///
/// # Errors
/// Those of [`load`].
pub fn load_tables(path: &Path, tables: Tables) -> Result<PreparedObject, DatabaseError> {
    let contents = verified_tables(path, tables)?;
    no_share(&contents)?;
    let prepared = object(&contents, tables)?;
    stored_values::impacts(&prepared)?;
    Ok(prepared)
}

fn no_share(contents: &ContainerContents) -> Result<(), DatabaseError> {
    if contents.metadata.contains_key(SHARE_KEY) { Err(DatabaseError::Share) } else { Ok(()) }
}

/// As [`load`], for a share.
///
/// # Errors
/// Those of [`load`], and for a database that is no share.
pub fn load_partial(path: &Path) -> Result<PartialBake, DatabaseError> {
    let contents = verified(path)?;
    let task = task(&contents)?;
    Ok(PartialBake { prepared: object(&contents, Tables::ALL)?, task })
}

/// The examples and the task of a share. Its lattices are not read.
pub(super) fn load_rest(path: &Path) -> Result<ShareRemainder, DatabaseError> {
    let contents = verified(path)?;
    let shape: Shape = contents.json("shape")?;
    let report: BakeReport = contents.json("report")?;
    let crack_nodes: Vec<usize> = (0..shape.interior_dimensions.len())
        .map(|index| contents.rows(&format!("{BASE}{index}.crack.nodes")))
        .collect();
    Ok(ShareRemainder {
        task: task(&contents)?,
        input_hash: report.input_hash,
        examples: learned::examples(&contents, &crack_nodes)?,
        checksums: contents.checksums()?,
    })
}

/// The task of a share, with its progress. The rest is only verified.
///
/// # Errors
/// Those of [`load_partial`].
pub fn load_task(path: &Path) -> Result<ShareTask, DatabaseError> {
    task(&verified(path)?)
}

/// Name and length in bytes of every tensor of `path`, from its header only, without verification.
///
/// # Errors
/// [`DatabaseError`] for a file or header that cannot be read.
pub fn tensor_bytes(path: &Path) -> Result<Vec<(String, u64)>, DatabaseError> {
    Ok(ContainerContents::open(path)?.lengths())
}

/// Bake parameters of the database or share `path`, from its header only, without verification.
///
/// # Errors
/// Those of [`tensor_bytes`].
pub fn load_parameters(path: &Path) -> Result<BakeParameters, DatabaseError> {
    ContainerContents::open(path)?.json("parameters")
}

/// The program that wrote the database or share `path`.
///
/// # Errors
/// Those of [`tensor_bytes`].
pub fn load_provenance(path: &Path) -> Result<Provenance, DatabaseError> {
    ContainerContents::open(path)?.json("provenance")
}

/// Loads only the hash of the mesh and the cracks from which a database or a share was baked.
///
/// # Errors
/// Those of [`load_parameters`].
pub fn load_input_hash(path: &Path) -> Result<String, DatabaseError> {
    Ok(ContainerContents::open(path)?.json::<BakeReport>("report")?.input_hash)
}

/// The task of a share, after a check of its numbers.
fn task(contents: &ContainerContents) -> Result<ShareTask, DatabaseError> {
    if !contents.metadata.contains_key(SHARE_KEY) {
        return Err(DatabaseError::Whole);
    }
    let task: ShareTask = contents.json(SHARE_KEY)?;
    if let Some(request) = &task.request {
        bake_request::check(request)
            .map_err(|error| DatabaseError::Metadata { key: SHARE_KEY, reason: error.to_string() })?;
    }
    let share = BakeShare::new(task.share.index, task.share.count);
    let reason = match share {
        Err(error) => error.to_string(),
        Ok(_) if task.end < task.first || task.end > EXAMPLES_MAX as u64 => "impacts out of range".to_owned(),
        Ok(_) if task.done > task.impacts().len() as u64 => "more impacts are done than the share has".to_owned(),
        Ok(_) => return Ok(task),
    };
    Err(DatabaseError::Metadata { key: SHARE_KEY, reason })
}

/// The contents of a file, after comparison of all checksums.
fn verified(path: &Path) -> Result<ContainerContents, DatabaseError> {
    verified_tables(path, Tables::ALL)
}

/// As [`verified`], with the checksums of the given tables only.
fn verified_tables(path: &Path, tables: Tables) -> Result<ContainerContents, DatabaseError> {
    let mut contents = ContainerContents::open(path)?;
    let found = contents.text("shatter_format")?;
    if found != FORMAT {
        return Err(DatabaseError::Format { found: brief(found), known: FORMAT });
    }
    contents.verify(|tensor| tables.want(tensor))?;
    Ok(contents)
}

fn object(contents: &ContainerContents, tables: Tables) -> Result<PreparedObject, DatabaseError> {
    let mut prepared = bare(contents, tables)?;
    let solids = prepared.bodies.iter_mut().enumerate().filter_map(|(index, body)| Some((index, body.solid.as_mut()?)));
    for (index, solid) in solids {
        solid.reduced = reduced::reduced(contents, index, &solid.elasticity)?;
        if solid.reduced.is_none() || solid.elasticity.order() == ElementOrder::Quadratic {
            // Every request will need the factor; with quadratic elements, those that complete a reduced displacement.
            solid.elasticity.factor().map_err(|source| DatabaseError::Elasticity { body: index, source })?;
        }
    }
    prepared.anchored_bases = reduced::anchored(contents, &prepared.bodies)?;
    prepared.impacts = contents.json::<Shape>("shape")?.impacts;
    if !tables.examples {
        return Ok(prepared);
    }
    let crack_nodes: Vec<usize> = prepared.bodies.iter().map(|body| body.crack.nodes.len()).collect();
    prepared.examples = learned::examples(contents, &crack_nodes)?;
    prepared.learned = learned::learned(contents, &prepared.examples)?;
    prepared.reduction = reduction(contents, &prepared.bodies)?;
    Ok(prepared)
}

/// Everything except the impacts and the data learned from them.
fn bare(contents: &ContainerContents, tables: Tables) -> Result<PreparedObject, DatabaseError> {
    let name = contents.text("object")?;
    let parameters: BakeParameters = contents.json("parameters")?;
    stored_values::parameters(name, &parameters)?;
    let report: BakeReport = contents.json("report")?;
    let shape: Shape = contents.json("shape")?;
    check_shape(&shape)?;
    stored_values::usual(&parameters, &shape.frame, shape.gamma_j_m2, shape.kappa)?;
    let bodies = (0..shape.interior_dimensions.len())
        .map(|index| body(contents, index, &shape, (&parameters, &report), tables))
        .collect::<Result<Vec<_>, _>>()?;
    stored_values::report(&report, &shape.frame, &bodies)?;
    let names = report.materials.len();
    let skin = match tables.skin {
        true => skins::skin(contents, &bodies, names, parameters.crack_spacing, report.cracks.is_some())?,
        false => None,
    };
    let skin = skin.map(Arc::new);
    Ok(PreparedObject {
        name: name.to_owned(),
        frame: shape.frame,
        parameters,
        gamma_j_m2: shape.gamma_j_m2,
        kappa: shape.kappa,
        report,
        bodies,
        impacts: 0,
        examples: Vec::new(),
        learned: None,
        reduction: None,
        anchored_bases: Vec::new(),
        held: None,
        skin,
    })
}

fn reduction(contents: &ContainerContents, bodies: &[PreparedBody]) -> Result<Option<ReductionErrors>, DatabaseError> {
    if !contents.metadata.contains_key(REDUCTION_KEY) {
        return Ok(None);
    }
    let reduction = contents.json(REDUCTION_KEY)?;
    stored_values::reduction(&reduction, bodies)?;
    Ok(Some(reduction))
}

fn check_shape(shape: &Shape) -> Result<(), DatabaseError> {
    let Shape { interior_dimensions: interior, surface_diffusion_dimensions: surface, .. } = shape;
    let found = interior.len();
    if found > BODIES_MAX {
        return Err(DatabaseError::TooLarge { what: "bodies", found, cap: BODIES_MAX });
    }
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let reason = if found == 0 {
        "no bodies"
    } else if surface.len() != found {
        "the lifts have different numbers of bodies"
    } else if !positive(shape.gamma_j_m2) || !positive(shape.kappa) {
        "gamma or kappa is not positive"
    } else if interior.iter().chain(surface).flatten().any(|dimension| !(3..=DIMENSION_MAX).contains(dimension)) {
        "a lift's dimension is out of range"
    } else {
        return stored_values::frame(&shape.frame);
    };
    Err(DatabaseError::Metadata { key: "shape", reason: reason.to_owned() })
}

fn body(
    contents: &ContainerContents,
    index: usize,
    shape: &Shape,
    (parameters, report): (&BakeParameters, &BakeReport),
    tables: Tables,
) -> Result<PreparedBody, DatabaseError> {
    let name = |part: &str| format!("{BASE}{index}.{part}");
    let crack = lattice(contents, &name("crack"))?;
    // Incomplete elasticity means a damaged file; the reader then names the missing tensor.
    let is_elastic = ELASTIC.iter().any(|part| contents.holds(&name(part)));
    let solid = match tables.elastic && is_elastic {
        true => Some(solid(contents, index, &crack, (parameters, report))?),
        false => None,
    };
    let lift = |part: &str, kind, dimension: Option<usize>, is_wanted: bool| {
        if dimension.is_none() && contents.holds(&name(part)) {
            let reason = format!("the lift `{}` is there, but its dimension is null", name(part));
            return Err(DatabaseError::Metadata { key: "shape", reason });
        }
        let measured = |dimension| {
            let coordinates = contents.f64(&name(part), Some(crack.nodes.len()), dimension)?;
            stored_values::lift(&name(part), &coordinates)?;
            Ok::<_, DatabaseError>(LiftedLattice::measured(kind, &crack, dimension, coordinates))
        };
        dimension.filter(|_| is_wanted).map(measured).transpose()
    };
    let interior = lift("interior", LiftKind::Interior, shape.interior_dimensions[index], tables.interior)?;
    let surface = shape.surface_diffusion_dimensions[index];
    let surface_diffusion = lift("surface_diffusion", LiftKind::SurfaceDiffusion, surface, tables.surface_diffusion)?;
    let mut body = PreparedBody { solid, interior, surface_diffusion, ..PreparedBody::new(crack) };
    if tables.elastic && contents.holds(&name(BOUND)) {
        body.bound = bound(contents, name(BOUND), &body)?;
    }
    if let Some(cutting) = cutting::read(contents, &name, &body.crack, tables, report.materials.len())? {
        body.set_cutting(cutting);
    }
    if tables.attributes {
        body.outer = skins::outer(contents, index, &body, report.materials.len())?;
    }
    Ok(body)
}

/// The bound of E_1 of `body`, checked against its stiffness and lifts; `None` for a body without elasticity.
fn bound(
    contents: &ContainerContents,
    tensor: String,
    body: &PreparedBody,
) -> Result<Option<EnergyUpperBound>, DatabaseError> {
    let mut values = [0.0; 4];
    let stored = contents.f64(&tensor, Some(values.len()), FLAT)?;
    values.copy_from_slice(&stored);
    let (Some(solid), Some(ranges)) = (&body.solid, EnergyUpperBound::ranges(body)) else { return Ok(None) };
    stored_values::bound(&tensor, &values, &ranges)?;
    Ok(Some(EnergyUpperBound::stored(&solid.elasticity, values)))
}

fn solid(
    contents: &ContainerContents,
    index: usize,
    crack: &Lattice,
    (parameters, report): (&BakeParameters, &BakeReport),
) -> Result<ElasticModel, DatabaseError> {
    let name = |part: &str| format!("{BASE}{index}.{part}");
    let law = (parameters.material.poisson, parameters.factor);
    let spacing = parameters.elastic_spacing.max(parameters.crack_spacing);
    let elastic = lattice(contents, &name("elastic"))?;
    let transfer = transfer(contents, &name("transfer"), &elastic, crack)?;
    elastic_values::check(&format!("{BASE}{index}"), &elastic, crack, &transfer, (spacing, report.stretch.as_ref()))?;
    let failed = |source| DatabaseError::Elasticity { body: index, source };
    ElasticModel::new(elastic, transfer, law, report.order(index), &CancelToken::default()).map_err(failed)
}

fn transfer(
    contents: &ContainerContents,
    name: &str,
    elastic: &Lattice,
    crack: &Lattice,
) -> Result<EnergyTransfer, DatabaseError> {
    let tets = contents.u32(&format!("{name}.tets"), None, FLAT, elastic.tets.len() as u64)?;
    let shares = contents.f64(&format!("{name}.shares"), Some(tets.len()), FLAT)?;
    let tensor = format!("{name}.offsets");
    let offsets = contents.u32(&tensor, Some(crack.nodes.len() + 1), FLAT, tets.len() as u64 + 1)?;
    let falls = offsets.windows(2).position(|pair| pair[1] < pair[0]);
    let ends = offsets.first() == Some(&0) && offsets.last() == Some(&(tets.len() as u32));
    match falls {
        Some(index) => Err(DatabaseError::OutOfRange {
            tensor,
            index,
            value: u64::from(offsets[index]),
            limit: u64::from(offsets[index + 1]) + 1,
        }),
        None if !ends => Err(DatabaseError::Shape {
            tensor,
            found: "offsets that do not span the shares".to_owned(),
            wanted: "0 ..= number of shares".to_owned(),
        }),
        None => {
            let transfer = EnergyTransfer { offsets, tets, shares };
            stored_values::rows(&tensor, &transfer)?;
            stored_values::shares(&format!("{name}.shares"), &transfer, elastic)?;
            Ok(transfer)
        }
    }
}
