//! Results: fragments borrowed straight from shared memory.

use crate::Code;
use crate::answer::{Bond, Counter, Debris, Fragment, Hash, Hull, Run, Skin, Summary, start};
use crate::border::{Failure, border, bytes, end, given, wrong};
use crate::refusal::Refusal;
use shatter_client::ErrorKind;
use shatter_proto::view::ResultView;
use std::ffi::{OsStr, c_char};
use std::mem::MaybeUninit;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

/// The result of a request. It holds one bucket of the daemon's pool until it is freed: free it once the fragments are copied. One thread
/// may use it at a time; any number of threads may read through its pointers.
pub struct Broken(pub(crate) shatter_client::FractureResult);

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
fn fragment(broken: Option<&Broken>, id: u32) -> Result<shatter_client::Fragment<'_>, Failure> {
    let broken = &given("broken", broken)?.0;
    let unknown = || {
        let message = format!("fragment {id} does not exist; the result has {} fragments", broken.fragments().len());
        shatter_client::Error::new(ErrorKind::UnknownFragment, id.to_string(), message)
    };
    Ok(broken.fragment(id).ok_or_else(unknown)?)
}

/// Summary of the result.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_summary(
    broken: Option<&Broken>,
    summary: Option<&mut MaybeUninit<Summary>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let (broken, place) = (given("broken", broken)?, given("summary", summary)?);
        place.write((&broken.0).into());
        Ok(())
    })
}

/// Fragment `id`, below `ShatterSummary.fragment_count`. Only its facts are copied.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_fragment(
    broken: Option<&Broken>,
    id: u32,
    fragment: Option<&mut MaybeUninit<Fragment>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let place = given("fragment", fragment)?;
        place.write((&self::fragment(broken, id)?).into());
        Ok(())
    })
}

/// Run `number` of fragment `id`, below `ShatterFragment.run_count`.
///
/// Codes: `unknown_fragment`; `SHATTER_CODE_ARGUMENT` if it has no such run.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_run(
    broken: Option<&Broken>,
    id: u32,
    number: usize,
    run: Option<&mut MaybeUninit<Run>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let place = given("run", run)?;
        let found = fragment(broken, id)?.runs().nth(number);
        place
            .write(found.ok_or_else(|| wrong("number", format!("run {number} does not exist; see run_count")))?.into());
        Ok(())
    })
}

/// Hull of fragment `id`; all zero if it has none.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_hull(
    broken: Option<&Broken>,
    id: u32,
    hull: Option<&mut MaybeUninit<Hull>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let place = given("hull", hull)?;
        place.write(fragment(broken, id)?.hull().into());
        Ok(())
    })
}

/// Skin of fragment `id`; all zero if it has none.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_skin(
    broken: Option<&Broken>,
    id: u32,
    skin: Option<&mut MaybeUninit<Skin>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let place = given("skin", skin)?;
        place.write(fragment(broken, id)?.skin().into());
        Ok(())
    })
}

/// True if the surface of fragment `id` is closed and oriented.
///
/// Codes: `unknown_fragment`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_is_closed(
    broken: Option<&Broken>,
    id: u32,
    closed: Option<&mut MaybeUninit<bool>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let place = given("closed", closed)?;
        place.write(fragment(broken, id)?.is_closed());
        Ok(())
    })
}

/// Lends rows: writes their address and their number; NULL and 0 on failure.
fn lend<'a, T: 'a, U>(
    broken: Option<&'a Broken>,
    rows: Option<&mut MaybeUninit<*const U>>,
    count: Option<&mut MaybeUninit<usize>>,
    find: impl FnOnce(ResultView<'a>) -> &'a [T],
) -> Result<(), Failure> {
    let (rows, count) = (given("rows", rows)?, given("count", count)?);
    rows.write(std::ptr::null());
    count.write(0);
    let found = find(given("broken", broken)?.0.raw_view());
    rows.write(start(found));
    count.write(found.len());
    Ok(())
}

/// Contact areas between fragments, and of fragments with the world. `rows` points to `count` of them in shared memory, valid until
/// `shatter_broken_free`. Empty unless `bonds` is on.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_bonds(
    broken: Option<&Broken>,
    rows: Option<&mut MaybeUninit<*const Bond>>,
    count: Option<&mut MaybeUninit<usize>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || lend(broken, rows, count, |view| view.bonds))
}

/// Points on cracks from which dust and chips come. `rows` as in `shatter_broken_bonds`. Empty unless `debris` is on.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_debris(
    broken: Option<&Broken>,
    rows: Option<&mut MaybeUninit<*const Debris>>,
    count: Option<&mut MaybeUninit<usize>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || lend(broken, rows, count, |view| view.debris))
}

/// Cost of each stage. `rows` as in `shatter_broken_bonds`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_stages(
    broken: Option<&Broken>,
    rows: Option<&mut MaybeUninit<*const Counter>>,
    count: Option<&mut MaybeUninit<usize>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || lend(broken, rows, count, |view| view.stages))
}

/// Cost of each effect. `rows` as in `shatter_broken_bonds`.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_effects(
    broken: Option<&Broken>,
    rows: Option<&mut MaybeUninit<*const Counter>>,
    count: Option<&mut MaybeUninit<usize>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || lend(broken, rows, count, |view| view.effects))
}

/// Content hash of the result, as `shatter impact --json` prints it (`output_hash`).
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_hash(
    broken: Option<&Broken>,
    hash: Option<&mut MaybeUninit<Hash>>,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let (broken, place) = (given("broken", broken)?, given("hash", hash)?);
        place.write((&broken.0).into());
        Ok(())
    })
}

/// Writes a `.glb` file, whole or not at all; `content` is a `ShatterContent`. The folder must exist.
///
/// Codes: `output` (also if there is nothing to write), `bad_answer`.
///
/// # Safety
/// `path` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shatter_broken_write_glb(
    broken: Option<&Broken>,
    content: u32,
    path: *const c_char,
    length: usize,
    refusal: Option<&mut MaybeUninit<Refusal>>,
) -> Code {
    border(refusal, || {
        let broken = &given("broken", broken)?.0;
        // SAFETY: the caller keeps the contract of this function, which is the same.
        let path = Path::new(OsStr::from_bytes(unsafe { bytes("path", path, length) }?));
        let write = match content {
            number if number == Content::Fragments as u32 => shatter_client::FractureResult::write_glb,
            number if number == Content::Hulls as u32 => shatter_client::FractureResult::write_hulls_glb,
            number if number == Content::Skins as u32 => shatter_client::FractureResult::write_skins_glb,
            number => return Err(wrong("content", format!("content {number}: must be 0 to 2"))),
        };
        write(broken, path)?;
        Ok(())
    })
}

/// Frees a result and returns its bucket to the daemon; NULL is allowed. Its pointers are invalid afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn shatter_broken_free(broken: Option<Box<Broken>>) {
    end(broken);
}
