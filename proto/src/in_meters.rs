//! Rows of a host's convention in the default one: meters, glTF's axes and winding.

use crate::convention::Convention;

/// A row that depends on the convention of its result.
pub(crate) trait InMeters {
    /// The row in the default convention, where `from` is its own.
    #[must_use]
    fn in_meters(&self, from: &Convention) -> Self;
}

/// Conversion of a section whose rows do not depend on the convention: no copy.
pub(crate) fn same<T>(_: &[T], _: &Convention) -> Option<Vec<T>> {
    None
}

/// Conversion of a section row by row.
pub(crate) fn each<T>(row: impl Fn(&T, &Convention) -> T) -> impl Fn(&[T], &Convention) -> Option<Vec<T>> {
    move |rows, from| Some(rows.iter().map(|given| row(given, from)).collect())
}

/// An offset in the default convention.
pub(crate) fn offset(given: &[f32; 3], from: &Convention) -> [f32; 3] {
    from.our_vector_f32(*given)
}

/// A direction in the default convention.
pub(crate) fn direction(given: &[f32; 3], from: &Convention) -> [f32; 3] {
    from.our_direction(*given)
}

/// Conversion of the corners of triangles: counter-clockwise. Every part of them that a table names is of whole triangles, one after
/// another.
pub(crate) fn triangles(corners: &[u32], from: &Convention) -> Option<Vec<u32>> {
    from.is_clockwise().then(|| {
        let mut corners = corners.to_vec();
        corners.as_chunks_mut::<3>().0.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
        corners
    })
}
