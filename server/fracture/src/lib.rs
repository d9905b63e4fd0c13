//! Brittle fracture as a plain library: a surface mesh and an impact become closed fragment meshes, in milliseconds.
//!
//! An object is **baked** once ([`BakeRequest`] makes a [`PreparedObject`]). Baking repairs the mesh, fills it with two lattices
//! of tetrahedra, factors the stiffness, and computes coordinates in which distances inside the object are straight.
//!
//! The object is then **struck** as often as needed ([`FractureRequest`] makes a [`FractureOutcome`]). It stays whole, or breaks
//! into fragments with masses and inertias.
//!
//! ```
//! use shatter_fracture::nalgebra::{Point3, Vector3};
//! use shatter_fracture::{BakeRequest, FractureRequest, Material, Preset, surface::shapes};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = shapes::cuboid([0.3, 0.1, 0.15]); // m; `surface::read` reads OBJ, PLY, STL, glTF and other files
//! let material = Material::named("ceramic")?; // or `Material { young_pa: 70e9, .. }`
//! let request = BakeRequest { quality: Preset::Draft, ..BakeRequest::new("brick", "ceramic", material) };
//! let brick = request.bake(mesh)?;
//!
//! let (point_m, impulse_ns) = (Point3::new(0.05, 0.05, 0.0), Vector3::new(0.0, -20.0, 0.0));
//! let outcome = brick.strike(&FractureRequest::at(point_m, impulse_ns))?;
//! let meshes = outcome.meshes().ok_or("the brick stays whole")?;
//! for fragment in meshes.emitted()?.fragments() {
//!     let (mass_kg, center_m) = (fragment.row.mass_kg, fragment.row.center_m);
//!     println!("{mass_kg:.3} kg at {center_m:.3?} m, {} triangles", fragment.indices.len() / 3);
//! }
//! # assert!(meshes.fragments.len() > 1);
//! # Ok(())
//! # }
//! ```
//!
//! These methods allocate their memory and cannot be canceled. [`database::bake`] and [`pipeline::strike`] do the same with a
//! [`CancelToken`](cancel_token::CancelToken) and an observer of stages; requests can then share one
//! [`Workspace`](pipeline::Workspace). [`FractureMeshes::emit`](pipeline::FractureMeshes::emit) writes into the caller's memory.
//! [`database::save`] and [`database::load`] write and read prepared objects.
//!
//! # Method
//!
//! S. C. Schvartzman and M. A. Otaduy, *Fracture Animation Based on High-Dimensional Voronoi Diagrams*, Symposium on Interactive 3D
//! Graphics and Games, 2014. The impact deforms the object once, linearly and quasi-statically. The object breaks if the first
//! moment of the strain energy, E_1, exceeds a threshold γ. The *fracture degree* is the smallest number of cells of which none
//! exceeds γ. The cells are those of a centroidal Voronoi diagram, weighted by the energy. The diagram uses coordinates of R^m in
//! which distances inside the object are straight (the *lift*). The cells are cut out of the lattice as closed meshes. Comments in
//! the modules cite all other sources.
//!
//! # Modules, in the order in which data flows
//!
//! | module | content |
//! |---|---|
//! | [`surface`] | reads and repairs a mesh; distinguishes inside from outside; generates shapes |
//! | [`lattice`] | fills it with tetrahedra at two levels: few for the displacement, more for the cracks |
//! | [`conforming`] | fills a closed mesh with tetrahedra whose boundary is the mesh itself |
//! | [`cutting`] | joins those tetrahedra to the lattice, so that fragments end on the input surface |
//! | [`lift`] | coordinates in which distances inside the object are straight |
//! | [`database`] | bakes, saves and loads prepared objects |
//! | [`scene`] | materials, effects, anchors |
//! | [`elasticity`] | contacts become a displacement and a strain energy |
//! | [`strength`] | where a body is closest to breaking by strength and energy |
//! | [`degree`] | the threshold and the fracture degree |
//! | [`centroidal`] | the diagram: sites, and the cell of each node |
//! | [`tessellation`] | cells become closed triangle meshes |
//! | [`fragment`] | volumes, centers and inertias |
//! | [`hull`], [`skin`] | convex proxies for collisions; the triangles of the input, cut as the object is |
//! | [`pipeline`] | runs all of them in order, and learns from sampled impacts |
//!
//! Several of them use [`sparse`], [`random`] and [`cancel_token`]. Tests and studies use [`reference`](mod@reference), problems
//! with known solutions, and [`accuracy`], definitions of errors.
//!
//! # Units and coordinates
//!
//! Physical quantities are in SI units, and their names end with the unit (`mass_kg`; `impulse_ns` is N·s). Coordinates are those
//! of the mesh: right-handed, +Y up, triangles counter-clockwise seen from outside. Inside the modules, lengths are *local*: the
//! bounding box of the object has a diagonal of 1 and its center is the origin ([`surface::LocalFrame`]). Only [`scene`],
//! [`pipeline`] and [`fragment`] use physical units.
//!
//! # Determinism
//!
//! The same mesh and bake request make the same bytes, for any number of threads. So do the same object and fracture request.
//! Sums have a fixed order, random numbers depend only on a seed and an index, and the crate has no clock and no global state.
//! Only a request with a [`TimeBudget`](pipeline::TimeBudget) differs; its outcome contains the number of iterations that repeats
//! it.

pub mod accuracy;
pub mod cancel_token;
pub mod centroidal;
pub mod conforming;
pub mod cutting;
pub mod database;
pub mod degree;
mod dense;
pub mod elasticity;
mod error_text;
pub mod fragment;
pub mod hull;
pub mod lattice;
pub mod lift;
mod memory;
mod needle;
pub mod pipeline;
pub mod random;
pub mod reference;
pub mod scene;
mod simd;
pub mod skin;
pub mod sparse;
pub mod strength;
pub mod surface;
pub mod tessellation;
mod triangle;

/// The code of the README, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use database::BakeRequest;
pub use nalgebra;
pub use pipeline::{FractureOutcome, FractureRequest, PreparedObject, Preset};
pub use scene::Material;
