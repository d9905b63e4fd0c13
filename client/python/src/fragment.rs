//! Fragments.

use crate::array::{column, rows};
use crate::result::{Held, unknown};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use shatter_client::{OuterAttributes, SkinVertex};
use std::sync::Arc;

/// One fragment: a closed mesh, and the data of a rigid body.
#[pyclass(frozen, module = "shatter")]
pub struct Fragment {
    held: Arc<Held>,
    id: u32,
}

impl Fragment {
    pub fn new(held: Arc<Held>, id: u32) -> Self {
        Self { held, id }
    }

    fn with<T>(&self, look: impl FnOnce(shatter_client::Fragment<'_>) -> T) -> PyResult<T> {
        self.held.with(|result| result.fragment(self.id).map(look)).ok_or_else(|| unknown(self.id))
    }

    /// Rows of a section; ``None`` if the result does not have it.
    fn rows<'py, T: numpy::Element, const N: usize>(
        &self,
        py: Python<'py>,
        values: impl Fn(shatter_client::Fragment<'_>) -> &[[T; N]],
    ) -> PyResult<Option<Bound<'py, PyArray2<T>>>> {
        let array = rows(py, &self.held, |result| result.fragment(self.id).map(&values))?;
        Ok(Some(array).filter(|array| !numpy::PyUntypedArrayMethods::is_empty(array)))
    }
}

/// Indices of vertices, one row per triangle.
fn triangles(indices: &[u32]) -> &[[u32; 3]] {
    indices.as_chunks().0
}

/// Normals and texture coordinates, one row per vertex.
fn outer_attributes(rows: &[OuterAttributes]) -> &[[f32; 5]] {
    bytemuck::cast_slice(rows)
}

/// Positions, normals and texture coordinates, one row per vertex.
fn skin_vertices(rows: &[SkinVertex]) -> &[[f32; 8]] {
    bytemuck::cast_slice(rows)
}

#[pymethods]
impl Fragment {
    #[getter]
    fn id(&self) -> u32 {
        self.id
    }

    #[getter]
    fn body(&self) -> PyResult<u32> {
        self.with(|own| own.body())
    }

    #[getter]
    fn volume_m3(&self) -> PyResult<f64> {
        self.with(|own| own.volume_m3())
    }

    #[getter]
    fn mass_kg(&self) -> PyResult<f64> {
        self.with(|own| own.mass_kg())
    }

    /// (3,): center of mass.
    #[getter]
    fn center_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_slice(py, &self.with(|own| own.center_m())?))
    }

    /// (3, 3): inertia tensor about the center of mass.
    #[getter]
    fn inertia_kg_m2<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let [xx, yy, zz, xy, xz, yz] = self.with(|own| own.inertia_kg_m2())?;
        let tensor = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        Ok(PyArray2::from_owned_array(py, numpy::ndarray::arr2(&tensor)))
    }

    /// (3,): velocity in addition to the object's; None unless ``release`` is on.
    #[getter]
    fn linear_m_s<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let velocity = self.with(|own| own.velocity().map(|velocity| velocity.linear_m_s))?;
        Ok(velocity.map(|velocity| PyArray1::from_slice(py, &velocity)))
    }

    #[getter]
    fn angular_rad_s<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let velocity = self.with(|own| own.velocity().map(|velocity| velocity.angular_rad_s))?;
        Ok(velocity.map(|velocity| PyArray1::from_slice(py, &velocity)))
    }

    /// (vertices, 3): positions relative to the center of mass.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, &self.held, |result| result.fragment(self.id).map(|own| own.positions()))
    }

    /// (triangles, 3): rows of ``positions``, counter-clockwise from outside.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        rows(py, &self.held, |result| result.fragment(self.id).map(|own| triangles(own.indices())))
    }

    /// (pairs, 2): vertices that are the same point; with them every edge has exactly one opposite.
    #[getter]
    fn merges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        rows(py, &self.held, |result| result.fragment(self.id).map(|own| own.merges()))
    }

    /// (vertices, 3): normals, of length one; None unless ``normals`` is on.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        self.rows(py, |own| own.normals())
    }

    /// (vertices, 2): texture coordinates, m; None unless ``uv`` is on.
    #[getter]
    fn uvs<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        self.rows(py, |own| own.uvs())
    }

    /// (vertices, 5): normal and texture coordinates of the input, zero on cracks; None unless ``attributes`` is on.
    #[getter]
    fn outer_attributes<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        self.rows(py, |own| outer_attributes(own.outer_attributes()))
    }

    /// (vertices, 2): second texture coordinates of the input, zero on cracks; None unless ``attributes`` is on and it has them.
    #[getter]
    fn outer_uvs2<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        self.rows(py, |own| own.outer_uvs2())
    }

    /// (vertices, 4): colors of the input, RGBA, white on cracks; None unless ``attributes`` is on and it has any.
    #[getter]
    fn outer_colors<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<u8>>>> {
        self.rows(py, |own| own.outer_colors())
    }

    /// (triangles,): the input's materials, 2³²−1 on cracks; None unless ``attributes`` is on and the input has any.
    #[getter]
    fn materials<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<u32>>>> {
        let array = column(py, &self.held, |result| result.fragment(self.id).map(|own| own.materials()))?;
        Ok(Some(array).filter(|array| !numpy::PyUntypedArrayMethods::is_empty(array)))
    }

    #[getter]
    fn runs(&self) -> PyResult<Vec<Run>> {
        self.with(|own| {
            let run = |run: shatter_client::Run<'_>| Run {
                neighbor: run.neighbor,
                crack: run.is_crack,
                triangle_first: run.index_first / 3,
                triangle_count: run.indices.len() as u32 / 3,
                vertex_first: run.vertex_first,
                vertex_count: run.positions.len() as u32,
            };
            own.runs().map(run).collect()
        })
    }

    /// Convex proxy for collisions; None unless ``hulls`` is on.
    #[getter]
    fn hull(&self, py: Python<'_>) -> PyResult<Option<Hull>> {
        let Some((coverage, margin_m)) = self.with(|own| own.hull().map(|hull| (hull.coverage, hull.margin_m)))? else {
            return Ok(None);
        };
        Ok(Some(Hull {
            positions: rows(py, &self.held, |result| {
                result.fragment(self.id).and_then(|own| own.hull()).map(|hull| hull.positions)
            })?
            .unbind(),
            triangles: rows(py, &self.held, |result| {
                result.fragment(self.id).and_then(|own| own.hull()).map(|hull| triangles(hull.indices))
            })?
            .unbind(),
            coverage,
            margin_m,
        }))
    }

    /// The fragment's part of the input's own triangles; None unless ``skin`` is on.
    #[getter]
    fn skin(&self, py: Python<'_>) -> PyResult<Option<Skin>> {
        if !self.with(|own| own.skin().is_some_and(|skin| !skin.vertices.is_empty()))? {
            return Ok(None);
        }
        Ok(Some(Skin {
            vertices: rows(py, &self.held, |result| {
                result.fragment(self.id).and_then(|own| own.skin()).map(|skin| skin_vertices(skin.vertices))
            })?
            .unbind(),
            triangles: rows(py, &self.held, |result| {
                result.fragment(self.id).and_then(|own| own.skin()).map(|skin| triangles(skin.indices))
            })?
            .unbind(),
            materials: column(py, &self.held, |result| {
                result.fragment(self.id).and_then(|own| own.skin()).map(|skin| skin.materials)
            })?
            .unbind(),
            uvs2: self.rows(py, |own| own.skin().map_or(&[], |skin| skin.uvs2))?.map(Bound::unbind),
            colors: self.rows(py, |own| own.skin().map_or(&[], |skin| skin.colors))?.map(Bound::unbind),
        }))
    }

    fn is_closed(&self, py: Python<'_>) -> PyResult<bool> {
        py.detach(|| self.with(|own| own.is_closed()))
    }

    fn __repr__(&self) -> PyResult<String> {
        self.with(|own| {
            let (mass_kg, triangles) = (own.mass_kg(), own.indices().len() / 3);
            format!("Fragment(id={}, mass_kg={mass_kg:.4}, triangles={triangles})", self.id)
        })
    }
}

/// Triangles of one fragment that face one neighbor, the outside, or a fragment of an earlier result.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Run {
    neighbor: Option<u32>,
    crack: bool,
    triangle_first: u32,
    triangle_count: u32,
    vertex_first: u32,
    vertex_count: u32,
}

/// The convex proxy of a fragment.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Hull {
    positions: Py<PyArray2<f32>>,
    triangles: Py<PyArray2<u32>>,
    coverage: f64,
    margin_m: f64,
}

/// The input's own triangles that belong to a fragment.
#[pyclass(frozen, get_all, module = "shatter")]
pub struct Skin {
    vertices: Py<PyArray2<f32>>,
    triangles: Py<PyArray2<u32>>,
    materials: Py<PyArray1<u32>>,
    uvs2: Option<Py<PyArray2<f32>>>,
    colors: Option<Py<PyArray2<u8>>>,
}
