//! Memory of prepared objects, counted by the reserved capacity of their arrays.

/// Bytes that `array` has reserved, whether in use or not.
pub(crate) fn held<T>(array: &Vec<T>) -> usize {
    array.capacity() * size_of::<T>()
}
