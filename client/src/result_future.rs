//! Strikes as futures, for any executor: the same polls, told by a thread that listens while somebody waits.

use crate::connection::Connection;
use crate::{Deadline, FractureResult, Poll, Ticket};
use shatter_proto::Error;
use shatter_transport::workarounds::lost_wakeups::TICK;
use std::future::{Future, IntoFuture};
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::task::{Context, Waker};

/// Those who wait on one connection.
#[derive(Default)]
pub(crate) struct Waiters(Mutex<Waiter>);

#[derive(Default)]
struct Waiter {
    wakers: Vec<Waker>,
    /// Whether a thread listens for them.
    attended: bool,
}

/// The answer to a strike, awaited. Dropping it cancels the strike.
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
        let mut registered = false;
        // Looked again once registered: what came in between has woken nobody.
        loop {
            match ticket.poll() {
                Ok(Poll::Ready(broken)) => return std::task::Poll::Ready(Ok(broken)),
                Ok(Poll::Pending) if registered => return std::task::Poll::Pending,
                Ok(Poll::Pending) => wake(ticket.link(), context.waker())?,
                Err(refusal) => return std::task::Poll::Ready(Err(refusal)),
            }
            registered = true;
        }
    }
}

/// Has `waker` woken once something may have come, or a turn has passed.
fn wake(link: &Arc<Connection>, waker: &Waker) -> Result<(), Error> {
    let mut waiting = link.audience().0.lock().unwrap_or_else(PoisonError::into_inner);
    if !waiting.wakers.iter().any(|other| other.will_wake(waker)) {
        waiting.wakers.push(waker.clone());
    }
    if !waiting.attended {
        let weak = Arc::downgrade(link);
        let thread = std::thread::Builder::new().name("shatter-listen".to_owned());
        thread.spawn(move || listen(&weak)).map_err(|error| crate::connection::no_thread(&error))?;
        waiting.attended = true;
    }
    Ok(())
}

/// Listens until nobody waits, or the connection is gone; wakes everybody after each tick, since a wake-up may be lost.
fn listen(link: &Weak<Connection>) {
    while let Some(link) = link.upgrade() {
        link.wait(Deadline::after(TICK));
        let mut waiting = link.audience().0.lock().unwrap_or_else(PoisonError::into_inner);
        if waiting.wakers.is_empty() {
            waiting.attended = false;
            return;
        }
        let wakers = std::mem::take(&mut waiting.wakers);
        drop(waiting);
        wakers.into_iter().for_each(Waker::wake);
    }
}
