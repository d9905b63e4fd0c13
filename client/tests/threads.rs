//! Which types are `Send` and `Sync`, checked by the compiler.

use shatter_client::{Client, Error, FractureResult, Fragment, Object, Ticket};

fn sent<T: Send>() {}
fn shared<T: Send + Sync>() {}

#[test]
fn connections_are_shared_tickets_and_results_are_handed_over() {
    shared::<Client>();
    shared::<Object>();
    shared::<Error>();
    sent::<Ticket>();
    sent::<FractureResult>();
    shared::<Fragment<'static>>();
}
