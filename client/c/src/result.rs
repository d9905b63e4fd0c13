//! Results: fragments borrowed straight from shared memory.

use crate::Code;
use crate::error::ErrorRecord;
use crate::ffi_boundary::{Failure, bytes, end, ffi_boundary, given, wrong};
use crate::result_rows::{Bond, Counter, Debris, Fragment, Hash, Hull, Run, Skin, Summary, start};
use shatter_client::ErrorKind;
use shatter_proto::text::counted;
use shatter_proto::view::ResultView;
use std::ffi::{OsStr, c_char};
use std::mem::MaybeUninit;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

/// The result of a request. It holds one bucket of the daemon's pool until it is freed: free it once the fragments are copied. One thread
/// may use it at a time; any number of threads may read through its pointers.
pub struct FractureResult(pub(crate) shatter_client::FractureResult);

/// Parts of a result that a file can contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Content {
    /// The fragments.
    Fragments = 0,
    /// The hulls of the fragments.
    Hulls = 1,
    /// The visible surfaces of the fragments: skins and crack faces.
    Skins = 2,
}

/// Finds a fragment by its id.
fn fragment(result: Option<&FractureResult>, id: u32) -> Result<shatter_client::Fragment<'_>, Failure> {
    let result = &given("result", result)?.0;
    let unknown = || {
        let fragments = counted(result.fragments().len() as u64, "fragment");
        let message = format!("fragment {id} does not exist; the result has {fragments}");
        shatter_client::Error::new(ErrorKind::UnknownFragment, id.to_string(), message)
    };
    Ok(result.fragment(id).ok_or_else(unknown)?)
}

/// Summary of the result.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_summary(
    result: Option<&FractureResult>,
    summary: Option<&mut MaybeUninit<Summary>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let (result, place) = (given("result", result)?, given("summary", summary)?);
        place.write((&result.0).into());
        Ok(())
    })
}

/// Fragment `id`, below `ShatterSummary.fragment_count`. Only its facts are copied.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_fragment(
    result: Option<&FractureResult>,
    id: u32,
    fragment: Option<&mut MaybeUninit<Fragment>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let place = given("fragment", fragment)?;
        place.write((&self::fragment(result, id)?).into());
        Ok(())
    })
}

/// Run `number` of fragment `id`, below `ShatterFragment.run_count`.
///
/// Codes: `unknown_fragment`; `SHATTER_CODE_ARGUMENT` if it has no such run.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_run(
    result: Option<&FractureResult>,
    id: u32,
    number: usize,
    run: Option<&mut MaybeUninit<Run>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let place = given("run", run)?;
        let found = fragment(result, id)?.runs().nth(number);
        place
            .write(found.ok_or_else(|| wrong("number", format!("run {number} does not exist; see run_count")))?.into());
        Ok(())
    })
}

/// Hull of fragment `id`; all zero if it has none.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_hull(
    result: Option<&FractureResult>,
    id: u32,
    hull: Option<&mut MaybeUninit<Hull>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let place = given("hull", hull)?;
        place.write(fragment(result, id)?.hull().into());
        Ok(())
    })
}

/// Skin of fragment `id`; all zero if it has none.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_skin(
    result: Option<&FractureResult>,
    id: u32,
    skin: Option<&mut MaybeUninit<Skin>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let place = given("skin", skin)?;
        place.write(fragment(result, id)?.skin().into());
        Ok(())
    })
}

/// True if the surface of fragment `id` is closed and oriented.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_is_closed(
    result: Option<&FractureResult>,
    id: u32,
    closed: Option<&mut MaybeUninit<bool>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let place = given("closed", closed)?;
        place.write(fragment(result, id)?.is_closed());
        Ok(())
    })
}

/// Lends rows: writes their address and their number; NULL and 0 on failure.
fn lend<'a, T: 'a, U>(
    result: Option<&'a FractureResult>,
    rows: Option<&mut MaybeUninit<*const U>>,
    count: Option<&mut MaybeUninit<usize>>,
    find: impl FnOnce(ResultView<'a>) -> &'a [T],
) -> Result<(), Failure> {
    let (rows, count) = (given("rows", rows)?, given("count", count)?);
    rows.write(std::ptr::null());
    count.write(0);
    let found = find(given("result", result)?.0.raw_view());
    rows.write(start(found));
    count.write(found.len());
    Ok(())
}

/// Contact areas between fragments, and of fragments with the world. `rows` points to `count` of them in shared memory, valid until
/// `shatter_result_free`. Empty unless `bonds` is on.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_bonds(
    result: Option<&FractureResult>,
    rows: Option<&mut MaybeUninit<*const Bond>>,
    count: Option<&mut MaybeUninit<usize>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || lend(result, rows, count, |view| view.bonds))
}

/// Points on cracks from which dust and chips come. `rows` as in `shatter_result_bonds`. Empty unless `debris` is on.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_debris(
    result: Option<&FractureResult>,
    rows: Option<&mut MaybeUninit<*const Debris>>,
    count: Option<&mut MaybeUninit<usize>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || lend(result, rows, count, |view| view.debris))
}

/// Cost of each stage. `rows` as in `shatter_result_bonds`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_stages(
    result: Option<&FractureResult>,
    rows: Option<&mut MaybeUninit<*const Counter>>,
    count: Option<&mut MaybeUninit<usize>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || lend(result, rows, count, |view| view.stages))
}

/// Cost of each effect. `rows` as in `shatter_result_bonds`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_effects(
    result: Option<&FractureResult>,
    rows: Option<&mut MaybeUninit<*const Counter>>,
    count: Option<&mut MaybeUninit<usize>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || lend(result, rows, count, |view| view.effects))
}

/// Content hash of the result, as `shatter impact --json` prints it (`output_hash`).
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_hash(
    result: Option<&FractureResult>,
    hash: Option<&mut MaybeUninit<Hash>>,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let (result, place) = (given("result", result)?, given("hash", hash)?);
        place.write((&result.0).into());
        Ok(())
    })
}

/// Writes a `.glb` file, whole or not at all; `content` is a `ShatterContent`. The folder must exist.
///
/// Codes: `output` (also if there is nothing to write), `bad_result`.
///
/// # Safety
/// `path` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_result_write_glb(
    result: Option<&FractureResult>,
    content: u32,
    path: *const c_char,
    length: usize,
    error: Option<&mut MaybeUninit<ErrorRecord>>,
) -> Code {
    ffi_boundary(error, || {
        let result = &given("result", result)?.0;
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let path = Path::new(OsStr::from_bytes(unsafe { bytes("path", path, length) }?));
        let write = match content {
            number if number == Content::Fragments as u32 => shatter_client::FractureResult::write_glb,
            number if number == Content::Hulls as u32 => shatter_client::FractureResult::write_hulls_glb,
            number if number == Content::Skins as u32 => shatter_client::FractureResult::write_skins_glb,
            number => return Err(wrong("content", format!("content {number}: must be 0 to 2"))),
        };
        write(result, path)?;
        Ok(())
    })
}

/// Frees a result and returns its bucket to the daemon; NULL is allowed. Its pointers are invalid afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_result_free(result: Option<Box<FractureResult>>) {
    end(result);
}
