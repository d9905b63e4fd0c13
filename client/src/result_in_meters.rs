//! Results in meters, glTF's axes and winding, whatever their convention: the contents of files.

use crate::FractureResult;
use crate::fragment::{Fragment, fragments};
use shatter_proto::view::{ResultView, SectionsInMeters};

/// A result in glTF's convention ([`Convention::GLTF`](shatter_proto::convention::Convention::GLTF)). A result in that convention is
/// borrowed, any other is copied once.
#[must_use]
pub struct ResultInMeters<'a> {
    given: ResultView<'a>,
    copied: Option<Box<SectionsInMeters>>,
}

impl FractureResult {
    /// The result in meters, along the axes of the mesh file, counter-clockwise.
    pub fn metric(&self) -> ResultInMeters<'_> {
        let (given, convention) = (self.raw_view(), self.convention());
        let copied = (!convention.is_default()).then(|| Box::new(given.in_meters(&convention)));
        ResultInMeters { given, copied }
    }
}

impl ResultInMeters<'_> {
    /// The rows of memory, as [`FractureResult::raw_view`].
    #[doc(hidden)]
    pub fn raw_view(&self) -> ResultView<'_> {
        self.copied.as_ref().map_or(self.given, |copied| copied.view(&self.given))
    }

    /// The fragments, in the order of their ids.
    pub fn fragments(&self) -> impl ExactSizeIterator<Item = Fragment<'_>> {
        fragments(self.raw_view())
    }
}
