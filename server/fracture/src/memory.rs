//! How much memory a prepared object holds: its arrays, by what they have reserved.

/// Bytes that `array` has reserved, whatever part of them is in use.
pub(crate) fn held<T>(array: &Vec<T>) -> usize {
    array.capacity() * size_of::<T>()
}
