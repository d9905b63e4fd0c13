//! Types that may lie in shared memory.

use crate::control::{ControlReplyHeader, ControlRequestWire};
use crate::error::ErrorWire;
use crate::request::{ContactWire, RequestWire};
use crate::result::{AlignedBlock, ResultHeader};
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// Lets values of a type lie in shared memory, under a name that both sides compare.
macro_rules! zero_copy {
    ($($type:ty: $name:literal,)*) => {$(
        // SAFETY: the type is `repr(C)` and plain old data (`Pod`, checked by its derive): of fixed size, without pointers, and as valid
        // in another process as in this one.
        unsafe impl ZeroCopySend for $type {
            unsafe fn type_name() -> &'static str {
                let _: fn(&$type) = plain;
                $name
            }
        }
    )*};
}

/// Compiles for plain old data alone.
fn plain<T: bytemuck::Pod>(_: &T) {}

zero_copy! {
    AlignedBlock: "shatter.Block.v1",
    ResultHeader: "shatter.ResultHeader.v1",
    ControlRequestWire: "shatter.Control.v1",
    ControlReplyHeader: "shatter.ControlHeader.v1",
    ErrorWire: "shatter.ServiceError.v1",
    ContactWire: "shatter.Contact.v1",
    RequestWire: "shatter.Strike.v1",
}
