use super::*;
use shatter_client::ErrorKind;
use std::ptr;

fn failed(failure: Failure) -> (Code, String) {
    let mut error = MaybeUninit::zeroed();
    let code = ffi_boundary(Some(&mut error), || Err(failure));
    // SAFETY: `ffi_boundary` always writes it.
    let error = unsafe { error.assume_init() };
    assert_eq!(error.code, code);
    let shown = |text: &[c_char]| text.iter().map(|byte| *byte as u8 as char).take_while(|c| *c != '\0').collect();
    (code, shown(&error.at))
}

#[test]
fn success_resets_the_error() {
    let mut error = MaybeUninit::uninit();
    assert_eq!(ffi_boundary(Some(&mut error), || Ok(())), Code::Ok);
    // SAFETY: `ffi_boundary` always writes it.
    assert_eq!(unsafe { error.assume_init() }, ErrorRecord::none());
}

#[test]
fn failures_map_to_error_codes() {
    let refused = shatter_client::Error::new(ErrorKind::Late, "ticket", "late");
    assert_eq!(failed(refused.into()), (Code::Late, "ticket".to_owned()));
    assert_eq!(failed(wrong("name", "null")), (Code::Argument, "name".to_owned()));
    assert_eq!(ffi_boundary(None, || given("object", None::<()>)), Code::Argument);
}

#[test]
fn panics_become_an_error_code() {
    let mut error = MaybeUninit::uninit();
    assert_eq!(ffi_boundary(Some(&mut error), || panic!("fell over {}", 7)), Code::Panicked);
    // SAFETY: `ffi_boundary` always writes it.
    let error = unsafe { error.assume_init() };
    assert_eq!(error.message, crate::error::text("fell over 7"));
    assert_eq!((error.fault, error.retry), (Fault::Service, false));
    assert_eq!(ffi_boundary(None, || panic!("plain")), Code::Panicked);
    assert_eq!(ffi_boundary(None, || std::panic::panic_any(3)), Code::Panicked);
    struct Falls;
    impl Drop for Falls {
        fn drop(&mut self) {
            panic!("while it is dropped");
        }
    }
    end(Some(Box::new(Falls)));
    end::<Falls>(None);
}

#[test]
fn texts_end_at_a_length_or_a_zero_byte() {
    let vase = c"vase".as_ptr();
    // SAFETY: the lengths are those of literals.
    let read = |data, length| unsafe { text("name", data, length) };
    assert_eq!(read(vase, 4).unwrap(), "vase");
    assert_eq!(read(vase, usize::MAX).unwrap(), "vase");
    assert_eq!(read(vase, 0).unwrap(), "");
    assert!(read(ptr::null(), 0).is_err() && read(ptr::null(), usize::MAX).is_err());
    assert!(read(vase, TEXT_MAX + 1).is_err());
    assert!(read(b"\xff".as_ptr().cast(), 1).is_err());
    // SAFETY: the length is that of the literal.
    assert_eq!(unsafe { bytes("path", b"\xff".as_ptr().cast(), 1) }.unwrap(), b"\xff");
}

#[test]
fn invalid_arrays_are_rejected() {
    let numbers = [1.0f64, 2.0, 3.0];
    let aside = numbers.as_ptr().cast::<u8>().wrapping_add(1).cast::<f64>();
    // SAFETY: only elements of `numbers` are read.
    let read = |data, count| unsafe { elements::<f64>("contacts", data, count) };
    assert_eq!(read(numbers.as_ptr(), 2).unwrap(), [1.0, 2.0]);
    assert!(read(ptr::null(), 0).unwrap().is_empty());
    assert!(read(ptr::null(), 1).is_err() && read(aside, 1).is_err());
    assert!(read(numbers.as_ptr(), usize::MAX).is_err());
    let mut places = [0u64; 2];
    // SAFETY: only elements of `places` are lent.
    unsafe {
        assert_eq!(uninit_elements("facts", places.as_mut_ptr(), 2).unwrap().len(), 2);
        assert!(uninit_elements("facts", ptr::null_mut::<u64>(), 0).unwrap().is_empty());
        assert!(uninit_elements("facts", ptr::null_mut::<u64>(), 1).is_err());
    }
}

/// The thread guarantees in the preamble of the header, checked by the compiler.
#[test]
fn connections_are_sync_tickets_and_results_are_send() {
    fn sent<T: Send>() {}
    fn shared<T: Send + Sync>() {}
    shared::<crate::Service>();
    shared::<crate::Object>();
    sent::<crate::Ticket>();
    sent::<crate::FractureResult>();
}
