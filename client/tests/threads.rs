//! What may cross threads, checked by the compiler.

use shatter_client::{Broken, Fragment, Object, Refusal, Shatter, Ticket};

fn sent<T: Send>() {}
fn shared<T: Send + Sync>() {}

#[test]
fn connections_are_shared_tickets_and_answers_are_handed_over() {
    shared::<Shatter>();
    shared::<Object>();
    shared::<Refusal>();
    sent::<Ticket>();
    sent::<Broken>();
    shared::<Fragment<'static>>();
}
