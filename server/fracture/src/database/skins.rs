//! Conversion of the input's surface and attributes to tensors, and back.
//!
//! Checksums ensure that a file is unchanged. The checks here ensure that its values can be used.

use super::container::{ContainerContents, FLAT, Tensors};
use super::{DatabaseError, stored_values};
use crate::cutting::OuterCorners;
use crate::lattice::LatticePoint;
use crate::pipeline::{PreparedBody, PreparedObject};
use crate::skin::{BoundaryAttributes, PointAttributeLists, Skin, SkinPoint};
use crate::surface::NO_MATERIAL;

/// Limit that allows any 32-bit number.
const ANY: u64 = 1 << 32;

/// Adds the tensors of the skin and of the attributes on the bodies' lattices, if the object has them.
pub(super) fn put(tensors: &mut Tensors, prepared: &PreparedObject) {
    if let Some(skin) = &prepared.skin {
        put_skin(tensors, skin);
    }
    for (index, body) in prepared.bodies.iter().enumerate() {
        let Some(BoundaryAttributes { points, materials }) = &body.outer else { continue };
        let name = |part: &str| format!("body{index}.outer.{part}");
        put_points(tensors, &name, points);
        if !materials.is_empty() {
            tensors.u32(name("materials"), &[materials.len()], materials);
        }
    }
}

/// Adds the tensors of the attributes at the corners of a cutting mesh, whose tensors begin with `mesh`.
pub(super) fn put_corners(tensors: &mut Tensors, mesh: &str, outer: &OuterCorners) {
    let OuterCorners { points, corners, materials } = outer;
    let name = |part: &str| format!("{mesh}.outer.{part}");
    put_points(tensors, &name, points);
    tensors.u32(name("corners"), &[corners.len(), 3], corners.as_flattened());
    if !materials.is_empty() {
        tensors.u32(name("materials"), &[materials.len()], materials);
    }
}

/// Names of the tensors of both sets of texture coordinates.
const UVS: [&str; 2] = ["uvs", "uvs2"];

/// Adds the tensors of the attributes of points. `name` returns the name of a tensor.
fn put_points(tensors: &mut Tensors, name: &dyn Fn(&str) -> String, points: &PointAttributeLists) {
    let PointAttributeLists { normals, uvs, colors } = points;
    tensors.f32(name("normals"), &[normals.len(), 3], normals.as_flattened());
    for (part, uvs) in UVS.into_iter().zip(uvs).filter(|(_, uvs)| !uvs.is_empty()) {
        tensors.f32(name(part), &[uvs.len(), 2], uvs.as_flattened());
    }
    if !colors.is_empty() {
        tensors.u8(name("colors"), &[colors.len(), 4], colors.as_flattened());
    }
}

/// The attributes of `rows` points.
fn points(
    contents: &ContainerContents,
    name: &dyn Fn(&str) -> String,
    rows: usize,
) -> Result<PointAttributeLists, DatabaseError> {
    let mut points =
        PointAttributeLists { normals: vectors::<3>(contents, &name("normals"), rows)?, ..Default::default() };
    stored_values::normals(&name("normals"), &points.normals)?;
    for (part, uvs) in UVS.into_iter().zip(&mut points.uvs).filter(|(part, _)| contents.holds(&name(part))) {
        *uvs = vectors::<2>(contents, &name(part), rows)?;
        stored_values::uvs(&name(part), uvs)?;
    }
    if contents.holds(&name("colors")) {
        points.colors = contents.u8(&name("colors"), rows, 4)?.as_chunks::<4>().0.to_vec();
    }
    Ok(points)
}

/// The attributes at the corners of a cutting mesh with this number of boundary faces; `None` if the file has none.
pub(super) fn corners(
    contents: &ContainerContents,
    mesh: &str,
    faces: usize,
    names: usize,
) -> Result<Option<OuterCorners>, DatabaseError> {
    let name = |part: &str| format!("{mesh}.outer.{part}");
    if !contents.holds(&name("normals")) {
        return Ok(None);
    }
    let points = points(contents, &name, contents.rows(&name("normals")))?;
    let corners = contents.u32(&name("corners"), Some(faces), 3, points.len() as u64)?;
    let materials = materials(contents, &name("materials"), faces, names)?;
    Ok(Some(OuterCorners { points, corners: corners.as_chunks::<3>().0.to_vec(), materials }))
}

fn put_skin(tensors: &mut Tensors, skin: &Skin) {
    let Skin { points, spots, vertices, attributes, triangles, materials } = skin;
    let name = |part: &str| format!("skin.{part}");
    let coordinates: Vec<f64> = points.iter().flat_map(|point| [point.x, point.y, point.z]).collect();
    tensors.f64(name("points"), &[points.len(), 3], &coordinates);
    let spot: Vec<u32> = spots.iter().flat_map(|spot| [spot.body, spot.place.tet]).collect();
    tensors.u32(name("spots"), &[spots.len(), 2], &spot);
    let weights: Vec<f64> = spots.iter().flat_map(|spot| spot.place.barycentric).collect();
    tensors.f64(name("weights"), &[spots.len(), 4], &weights);
    tensors.u32(name("vertices"), &[vertices.len()], vertices);
    put_points(tensors, &name, attributes);
    tensors.u32(name("triangles"), &[triangles.len(), 3], triangles.as_flattened());
    if !materials.is_empty() {
        tensors.u32(name("materials"), &[materials.len()], materials);
    }
}

/// The skin of an object with these bodies, number of material names and crack spacing; `None` if the file has none.
pub(super) fn skin(
    contents: &ContainerContents,
    bodies: &[PreparedBody],
    names: usize,
    spacing: f64,
) -> Result<Option<Skin>, DatabaseError> {
    if !contents.holds("skin.points") {
        return Ok(None);
    }
    let coordinates = contents.f64("skin.points", None, 3)?;
    let (places, _) = coordinates.as_chunks::<3>();
    stored_values::points("skin.points", places, spacing)?;
    let spots = spots(contents, bodies, places.len())?;
    let vertices = contents.u32("skin.vertices", None, FLAT, places.len() as u64)?;
    let attributes = points(contents, &|part| format!("skin.{part}"), vertices.len())?;
    let indices = contents.u32("skin.triangles", None, 3, vertices.len() as u64)?;
    let triangles = indices.as_chunks::<3>().0.to_vec();
    let materials = materials(contents, "skin.materials", triangles.len(), names)?;
    let points = places.iter().map(|place| (*place).into()).collect();
    Ok(Some(Skin { points, spots, vertices, attributes, triangles, materials }))
}

fn spots(
    contents: &ContainerContents,
    bodies: &[PreparedBody],
    points: usize,
) -> Result<Vec<SkinPoint>, DatabaseError> {
    let pairs = contents.u32("skin.spots", Some(points), 2, ANY)?;
    let weights = contents.f64("skin.weights", Some(points), 4)?;
    stored_values::weights("skin.weights", weights.as_chunks::<4>().0)?;
    let spot = |(index, (&[body, tet], &barycentric)): (usize, (&[u32; 2], &[f64; 4]))| {
        let limit = bodies.get(body as usize).map_or(0, |body| body.crack.tets.len()) as u64;
        match u64::from(tet) < limit {
            true => Ok(SkinPoint { body, place: LatticePoint { tet, barycentric } }),
            false => {
                let value = u64::from(tet);
                Err(DatabaseError::OutOfRange { tensor: "skin.spots".to_owned(), index: 2 * index + 1, value, limit })
            }
        }
    };
    let pairs = pairs.as_chunks::<2>().0.iter().zip(weights.as_chunks::<4>().0);
    let mut spots = pairs.enumerate().map(spot).collect::<Result<Vec<_>, _>>()?;
    // A collection that may fail reserves as it grows.
    spots.shrink_to_fit();
    Ok(spots)
}

/// The attributes of the input on the boundary of body `index`; `None` if the file has none.
pub(super) fn outer(
    contents: &ContainerContents,
    index: usize,
    body: &PreparedBody,
    names: usize,
) -> Result<Option<BoundaryAttributes>, DatabaseError> {
    let name = |part: &str| format!("body{index}.outer.{part}");
    if !contents.holds(&name("normals")) {
        return Ok(None);
    }
    let points = points(contents, &name, body.topology.boundary_nodes.len())?;
    let materials = materials(contents, &name("materials"), body.topology.boundary.len(), names)?;
    Ok(Some(BoundaryAttributes { points, materials }))
}

fn materials(contents: &ContainerContents, name: &str, rows: usize, names: usize) -> Result<Vec<u32>, DatabaseError> {
    if !contents.holds(name) {
        return Ok(Vec::new());
    }
    let materials = contents.u32(name, Some(rows), FLAT, ANY)?;
    stored_values::materials(name, &materials, names, NO_MATERIAL)?;
    Ok(materials)
}

fn vectors<const N: usize>(
    contents: &ContainerContents,
    name: &str,
    rows: usize,
) -> Result<Vec<[f32; N]>, DatabaseError> {
    let (columns, values) = contents.f32(name, rows)?;
    match columns == N {
        true => Ok(values.as_chunks::<N>().0.to_vec()),
        false => Err(DatabaseError::Shape {
            tensor: name.to_owned(),
            found: format!("F32 [{rows}, {columns}]"),
            wanted: format!("F32 [{rows}, {N}]"),
        }),
    }
}

#[cfg(test)]
mod tests {
    use crate::database::{self, BakeRequest, Tables};
    use crate::scene::Material;
    use crate::surface::shapes;

    #[test]
    fn a_loaded_skin_reserves_no_more_than_it_uses() {
        let tables = Tables { skin: true, attributes: true, ..Tables::NONE };
        let request = BakeRequest { tables, ..BakeRequest::new("block", "glass", Material::named("glass").unwrap()) };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("block.shatter");
        database::save(&request.bake(shapes::cuboid([0.3; 3])).unwrap(), &path).unwrap();
        let skin = database::load(&path).unwrap().skin.unwrap();
        assert_eq!(skin.bytes(), skin.as_ref().clone().bytes());
    }
}
