//! Tickets as futures, for any executor: the same polls, and a thread that listens while a task waits.

use crate::connection::{Connection, no_thread};
use crate::{Deadline, FractureResult, Poll, Ticket};
use shatter_proto::Error;
use shatter_transport::workarounds::lost_wakeups::TICK;
use std::future::{Future, IntoFuture};
use std::pin::Pin;
use std::sync::{Arc, Weak};
use std::task::{Context, Waker};

/// The result of a request, awaited. Dropping it cancels the request.
#[must_use = "dropping a future cancels its request"]
pub struct ResultFuture(Ticket);

impl IntoFuture for Ticket {
    type Output = Result<FractureResult, Error>;
    type IntoFuture = ResultFuture;

    fn into_future(self) -> ResultFuture {
        ResultFuture(self)
    }
}

impl Future for ResultFuture {
    type Output = Result<FractureResult, Error>;

    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> std::task::Poll<Self::Output> {
        let ticket = &mut self.get_mut().0;
        let mut is_registered = false;
        // Polled again once registered: a result that came in between has woken no task.
        loop {
            match ticket.poll() {
                Ok(Poll::Ready(result)) => return std::task::Poll::Ready(Ok(result)),
                Ok(Poll::Pending) if is_registered => return std::task::Poll::Pending,
                Ok(Poll::Pending) => register(ticket.connection(), context.waker())?,
                Err(error) => return std::task::Poll::Ready(Err(error)),
            }
            is_registered = true;
        }
    }
}

/// Has `waker` woken once something may have come, or a turn has passed.
fn register(connection: &Arc<Connection>, waker: &Waker) -> Result<(), Error> {
    connection.waiters().add(waker, || {
        let weak = Arc::downgrade(connection);
        let thread = std::thread::Builder::new().name("shatter-listen".to_owned());
        thread.spawn(move || listen(&weak)).map(drop).map_err(|error| no_thread(&error))
    })
}

/// Listens until no task waits, or the connection is gone. Wakes all tasks after each tick, since a notification may be lost.
fn listen(connection: &Weak<Connection>) {
    while let Some(connection) = connection.upgrade() {
        connection.wait(Deadline::after(TICK));
        if !connection.waiters().wake_all() {
            return;
        }
    }
}
