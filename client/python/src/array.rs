//! Arrays over shared memory.

use crate::result::Held;
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{Element, PyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;

/// Owner of an array over shared memory: it keeps the result alive.
#[pyclass(frozen, module = "shatter")]
struct Lease {
    _held: Arc<Held>,
}

/// Values of the result that `values` selects; empty for `None`. Python is not called while the result is locked.
fn slice<T>(held: &Arc<Held>, values: impl FnOnce(&shatter_client::FractureResult) -> Option<&[T]>) -> &[T] {
    let (first, count) = held.with(|result| {
        let values = values(result).unwrap_or(&[]);
        (values.as_ptr(), values.len())
    });
    // SAFETY: the values lie in the result's shared memory, which stays in its place, unchanged, while the result exists. `held` owns the
    // result, and is borrowed as long as the slice.
    unsafe { std::slice::from_raw_parts(first, count) }
}

/// Values one after another, without a copy and read-only; `values` selects them from the result.
pub fn column<'py, T: Element>(
    py: Python<'py>,
    held: &Arc<Held>,
    values: impl FnOnce(&shatter_client::FractureResult) -> Option<&[T]>,
) -> PyResult<Bound<'py, PyArray1<T>>> {
    let lease = Bound::new(py, Lease { _held: held.clone() })?;
    let view = ArrayView1::from(slice(held, values));
    // SAFETY: the values lie in the result's shared memory, which neither moves nor ends before the result is dropped. The lease is the
    // array's base and shares ownership of the result. Nothing writes there; the array is made read-only.
    let array = unsafe { PyArray1::borrow_from_array(&view, lease.into_any()) };
    Ok(read_only(array))
}

/// The same with `N` values per row.
pub fn rows<'py, T: Element, const N: usize>(
    py: Python<'py>,
    held: &Arc<Held>,
    values: impl FnOnce(&shatter_client::FractureResult) -> Option<&[[T; N]]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let lease = Bound::new(py, Lease { _held: held.clone() })?;
    let view = ArrayView2::from(slice(held, values));
    // SAFETY: as in `column`.
    let array = unsafe { PyArray2::borrow_from_array(&view, lease.into_any()) };
    Ok(read_only(array))
}

fn read_only<'py, T: Element, D: numpy::ndarray::Dimension>(
    array: Bound<'py, PyArray<T, D>>,
) -> Bound<'py, PyArray<T, D>> {
    if let Ok(array) = array.try_readwrite() {
        array.make_nonwriteable();
    }
    array
}
