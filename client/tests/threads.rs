//! Which types are `Send` and `Sync`, checked by the compiler.

use shatter_client::{Client, Error, FractureResult, Fragment, Object, Ticket};

fn sent<T: Send>() {}
fn shared<T: Send + Sync>() {}

#[test]
fn connections_are_shared_and_tickets_move_between_threads() {
    shared::<Client>();
    shared::<Object>();
    shared::<Error>();
    sent::<Ticket>();
    sent::<FractureResult>();
    shared::<Fragment<'static>>();
}
