//! Conversion of examples and the network to tensors, and back.
//!
//! Checksums ensure that a file is unchanged. The checks here ensure that its values can be used.

use super::container::{ContainerContents, FLAT, Tensors};
use super::{DatabaseError, stored_values};
use crate::degree::{DESCRIPTOR_LENGTH, PoseNetwork};
use crate::pipeline::{DegreeCurvePoint, ImpactContact, LearnedErrors, LearnedModel, TrainingExample, samples};

/// Tensor of the examples' impacts and bodies; absent without examples.
const HEADS: &str = "examples.heads";

/// Metadata key of [`LearnedErrors`]; absent without a network.
pub(super) const QUALITY_KEY: &str = "learned";

/// Largest number of examples of an object.
pub const EXAMPLES_MAX: usize = 1 << 20;

/// Largest number of centers of a network.
const NETWORK_MAX: usize = 1 << 12;

/// Encodes a default among positive numbers.
const DEFAULT: f64 = 0.0;

/// Adds the tensors of `examples`, if there are any.
pub(super) fn put_examples(tensors: &mut Tensors, examples: &[TrainingExample]) {
    let count = examples.len();
    if count == 0 {
        return;
    }
    let heads: Vec<u32> = examples.iter().flat_map(|example| [example.impact as u32, example.body as u32]).collect();
    tensors.u32(HEADS.into(), &[count, 2], &heads);
    let scalars: Vec<f64> =
        examples.iter().flat_map(|example| [example.energy_j, example.first_moment, example.evenness]).collect();
    tensors.f64("examples.scalars".into(), &[count, 3], &scalars);
    let contacts: Vec<f64> = examples.iter().flat_map(|example| &example.contacts).flat_map(contact).collect();
    tensors.u32("examples.contact_offsets".into(), &[count + 1], &offsets(examples, |example| example.contacts.len()));
    tensors.f64("examples.contacts".into(), &[contacts.len() / 8, 8], &contacts);
    let points: Vec<&DegreeCurvePoint> = examples.iter().flat_map(|example| &example.points).collect();
    let sites: Vec<u32> = points.iter().map(|point| point.sites).collect();
    let energies =
        |point: &&DegreeCurvePoint| [point.energy_max, point.energy_max_worst, point.energy_max_again, point.estimate];
    let energies: Vec<f64> = points.iter().flat_map(energies).collect();
    tensors.u32("examples.point_offsets".into(), &[count + 1], &offsets(examples, |example| example.points.len()));
    tensors.u32("examples.sites".into(), &[sites.len()], &sites);
    tensors.f64("examples.energies".into(), &[sites.len(), 4], &energies);
    let nodes: Vec<u32> = examples.iter().flat_map(|example| example.site_nodes.iter().copied()).collect();
    tensors.u32("examples.site_nodes".into(), &[nodes.len()], &nodes);
}

/// Adds the tensors of the network.
pub(super) fn put_network(tensors: &mut Tensors, network: &PoseNetwork) {
    let columns = network.mean.len();
    tensors.f64("network.mean".into(), &[columns], &network.mean);
    tensors.f64("network.spread".into(), &[columns], &network.spread);
    tensors.f64("network.centers".into(), &[network.centers.len() / columns, columns], &network.centers);
    tensors.f64("network.weights".into(), &[network.weights.len()], &network.weights);
    tensors.f64("network.scales".into(), &[2], &[network.width, network.reach]);
}

fn contact(contact: &ImpactContact) -> [f64; 8] {
    let (p, j) = (contact.point_m, contact.impulse_ns);
    let [duration_s, radius_m] = [contact.duration_s, contact.radius_m].map(|given| given.unwrap_or(DEFAULT));
    [p.x, p.y, p.z, j.x, j.y, j.z, duration_s, radius_m]
}

/// First row of each example, and the end of the last.
fn offsets(examples: &[TrainingExample], rows: impl Fn(&TrainingExample) -> usize) -> Vec<u32> {
    let mut offsets = vec![0];
    let mut sum = 0;
    offsets.extend(examples.iter().map(|example| {
        sum += rows(example) as u32;
        sum
    }));
    offsets
}

/// The examples of an object. `bodies`: number of crack nodes of each body. Empty if the file has none.
pub(super) fn examples(contents: &ContainerContents, bodies: &[usize]) -> Result<Vec<TrainingExample>, DatabaseError> {
    if !contents.holds(HEADS) {
        return Ok(Vec::new());
    }
    let heads = contents.u32(HEADS, None, 2, u64::from(u32::MAX))?;
    let (heads, _) = heads.as_chunks::<2>();
    if heads.len() > EXAMPLES_MAX {
        return Err(DatabaseError::TooLarge { what: "examples", found: heads.len(), cap: EXAMPLES_MAX });
    }
    if let Some(index) = heads.iter().position(|head| head[1] as usize >= bodies.len()) {
        let (value, limit) = (u64::from(heads[index][1]), bodies.len() as u64);
        return Err(DatabaseError::OutOfRange { tensor: HEADS.into(), index, value, limit });
    }
    if let Some(index) = heads.windows(2).position(|pair| pair[1] <= pair[0]) {
        let (value, limit) = (u64::from(heads[index + 1][0]), u64::from(heads[index][0]));
        return Err(DatabaseError::OutOfRange { tensor: HEADS.into(), index: index + 1, value, limit });
    }
    let scalars = contents.f64("examples.scalars", Some(heads.len()), 3)?;
    positive("examples.scalars", &scalars)?;
    let contacts = contents.f64("examples.contacts", None, 8)?;
    let (contacts, _) = contacts.as_chunks::<8>();
    let contact_rows = rows(contents, "examples.contact_offsets", heads.len(), contacts.len())?;
    let sites = contents.u32("examples.sites", None, FLAT, u64::from(u32::MAX))?;
    let energies = contents.f64("examples.energies", Some(sites.len()), 4)?;
    let (energies, _) = energies.as_chunks::<4>();
    let point_rows = rows(contents, "examples.point_offsets", heads.len(), sites.len())?;
    check_points(&sites, energies)?;
    let mut site_nodes = site_nodes(contents, heads, bodies, &sites, &point_rows)?.into_iter();
    let point = |row: usize| DegreeCurvePoint {
        sites: sites[row],
        energy_max: energies[row][0],
        energy_max_worst: energies[row][1],
        energy_max_again: energies[row][2],
        estimate: energies[row][3],
    };
    let given = |value: f64| (value != DEFAULT).then_some(value);
    let contact = |&[x, y, z, i, j, k, duration_s, radius_m]: &[f64; 8]| ImpactContact {
        point_m: [x, y, z].into(),
        impulse_ns: [i, j, k].into(),
        duration_s: given(duration_s),
        radius_m: given(radius_m),
        partner: None,
    };
    let examples: Vec<TrainingExample> = heads
        .iter()
        .enumerate()
        .map(|(index, head)| TrainingExample {
            impact: u64::from(head[0]),
            body: head[1] as usize,
            contacts: contacts[contact_rows[index].clone()].iter().map(contact).collect(),
            energy_j: scalars[3 * index],
            first_moment: scalars[3 * index + 1],
            evenness: scalars[3 * index + 2],
            points: point_rows[index].clone().map(point).collect(),
            site_nodes: site_nodes.next().unwrap_or_default(),
        })
        .collect();
    let bare =
        |example: &TrainingExample| example.samples(0).any(|sample| !sample.descriptor.iter().all(|x| x.is_finite()));
    match examples.iter().position(bare) {
        Some(index) => Err(DatabaseError::NonFinite { tensor: "examples.energies".into(), index }),
        None => Ok(examples),
    }
}

/// The model learned from `examples`; `None` if the file has none.
pub(super) fn learned(
    contents: &ContainerContents,
    examples: &[TrainingExample],
) -> Result<Option<LearnedModel>, DatabaseError> {
    if !contents.metadata.contains_key(QUALITY_KEY) {
        return Ok(None);
    }
    let quality: LearnedErrors = contents.json(QUALITY_KEY)?;
    stored_values::quality(&quality)?;
    let network = network(contents)?.with_reach_of(&samples(examples));
    Ok(Some(LearnedModel { network, quality }))
}

/// Rows of each example: at least one each, consecutive, covering all.
fn rows(
    contents: &ContainerContents,
    tensor: &'static str,
    count: usize,
    total: usize,
) -> Result<Vec<std::ops::Range<usize>>, DatabaseError> {
    let offsets = contents.u32(tensor, Some(count + 1), FLAT, total as u64 + 1)?;
    if offsets.first() != Some(&0) || offsets.last() != Some(&(total as u32)) {
        return Err(DatabaseError::Shape {
            tensor: tensor.to_owned(),
            found: "offsets that do not span the rows".to_owned(),
            wanted: format!("0 ..= {total}"),
        });
    }
    match offsets.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(index) => Err(DatabaseError::OutOfRange {
            tensor: tensor.to_owned(),
            index,
            value: u64::from(offsets[index]),
            limit: u64::from(offsets[index + 1]),
        }),
        None => Ok(offsets.windows(2).map(|pair| pair[0] as usize..pair[1] as usize).collect()),
    }
}

/// The sites of each example, as nodes of its body.
fn site_nodes(
    contents: &ContainerContents,
    heads: &[[u32; 2]],
    bodies: &[usize],
    sites: &[u32],
    rows: &[std::ops::Range<usize>],
) -> Result<Vec<Vec<u32>>, DatabaseError> {
    let length = |rows: &std::ops::Range<usize>| -> usize {
        sites[rows.clone()].iter().filter(|sites| **sites > 1).map(|sites| *sites as usize).sum()
    };
    let tensor = "examples.site_nodes";
    let nodes = contents.u32(tensor, Some(rows.iter().map(length).sum()), FLAT, u64::from(u32::MAX))?;
    let mut rest = nodes.as_slice();
    let mut taken = Vec::with_capacity(rows.len());
    for (head, rows) in heads.iter().zip(rows) {
        let (own, others) = rest.split_at(length(rows));
        let limit = bodies[head[1] as usize] as u64;
        if let Some(place) = own.iter().position(|node| u64::from(*node) >= limit) {
            let index = nodes.len() - rest.len() + place;
            return Err(DatabaseError::OutOfRange {
                tensor: tensor.into(),
                index,
                value: u64::from(own[place]),
                limit,
            });
        }
        taken.push(own.to_vec());
        rest = others;
    }
    Ok(taken)
}

/// Checks that values are positive, because their logarithms are taken.
fn positive(tensor: &'static str, values: &[f64]) -> Result<(), DatabaseError> {
    match values.iter().position(|value| *value <= 0.0) {
        Some(index) => Err(DatabaseError::NotPositive { tensor: tensor.to_owned(), index, value: values[index] }),
        None => Ok(()),
    }
}

/// Checks the points: positive numbers of sites and energies, and estimates of 0 or above (0 if the point labels no γ).
fn check_points(sites: &[u32], energies: &[[f64; 4]]) -> Result<(), DatabaseError> {
    if let Some(index) = sites.iter().position(|sites| *sites == 0) {
        return Err(DatabaseError::NotPositive { tensor: "examples.sites".into(), index, value: 0.0 });
    }
    match energies
        .iter()
        .position(|[best, worst, again, estimate]| *best <= 0.0 || worst < best || *again < 0.0 || *estimate < 0.0)
    {
        Some(index) => {
            Err(DatabaseError::NotPositive { tensor: "examples.energies".into(), index, value: energies[index][0] })
        }
        None => Ok(()),
    }
}

fn network(contents: &ContainerContents) -> Result<PoseNetwork, DatabaseError> {
    let mean = contents.f64("network.mean", None, FLAT)?;
    let columns = mean.len();
    let wrong = |tensor: &str, found: usize, wanted: String| DatabaseError::Shape {
        tensor: tensor.to_owned(),
        found: found.to_string(),
        wanted,
    };
    if columns != DESCRIPTOR_LENGTH {
        return Err(wrong("network.mean", columns, DESCRIPTOR_LENGTH.to_string()));
    }
    let spread = contents.f64("network.spread", Some(columns), FLAT)?;
    positive("network.spread", &spread)?;
    let centers = contents.f64("network.centers", None, columns)?;
    let count = centers.len() / columns;
    if count > NETWORK_MAX {
        return Err(DatabaseError::TooLarge { what: "centers of a network", found: count, cap: NETWORK_MAX });
    }
    let weights = contents.f64("network.weights", Some(1 + columns + count), FLAT)?;
    let scales = contents.f64("network.scales", Some(2), FLAT)?;
    positive("network.scales", &scales)?;
    Ok(PoseNetwork::new(mean, spread, centers, weights, [scales[0], scales[1]]))
}
