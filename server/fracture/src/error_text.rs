//! Errors as sentences: `main` prints the error that it returns by `Debug`.

use crate::database::{BakeError, DatabaseError};
use crate::pipeline::FractureError;
use crate::scene::MaterialError;
use crate::surface::SurfaceError;
use std::fmt;

/// Implements `Debug` by the message of the error.
macro_rules! debug_is_message {
    ($($error:ty),*) => {
        $(impl fmt::Debug for $error {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(self, formatter)
            }
        })*
    };
}

debug_is_message!(BakeError, DatabaseError, FractureError, MaterialError, SurfaceError);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_print_as_sentences() {
        let error = FractureError::ContactCount(0);
        assert_eq!(format!("{error:?}"), "the request has 0 contacts; pass 1 to 8");
        let unknown = |count| FractureError::UnknownFragment { fragment: 7, count }.to_string();
        assert_eq!(unknown(1), "fragment 7 does not exist; the result has 1 fragment, counted from 0");
        assert_eq!(unknown(2), "fragment 7 does not exist; the result has 2 fragments, counted from 0");
        let absent = |vertices| SurfaceError::VertexOutOfBounds { face: 3, index: 9, vertices }.to_string();
        assert_eq!(absent(1), "face 3 refers to vertex 9, but the mesh has 1 vertex");
        assert_eq!(absent(8), "face 3 refers to vertex 9, but the mesh has 8 vertices");
        let wrapped = BakeError::Surface(SurfaceError::NothingInside);
        assert_eq!(format!("{wrapped:?}"), wrapped.to_string());
    }
}
