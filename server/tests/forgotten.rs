//! Living clients that a daemon treats as dead: their calls use a new connection, and their requests under way are lost.

mod support;

use bytemuck::Zeroable;
use shatter_client::{Client, Contact, Error, ErrorKind, Impact, Object};
use shatter_proto::control::{self, ControlRequest, ObjectRow, ReplyRow};
use shatter_proto::error::ErrorWire;
use shatter_proto::result::Block;
use shatter_server::ipc::{ActiveControlRequest, PoolSize, Ports, RuntimeDirectory};
use std::path::PathBuf;
use std::time::Duration;
use support::{Child, TestPlace, patience, play, role};

/// Runs the process of another role for the tests below; does nothing by itself.
#[test]
fn play_a_role() {
    play(|other| panic!("no such role: {other}"));
}

fn connect(here: &TestPlace) -> Client {
    Client::connect_at(&here.place, patience()).unwrap()
}

fn impact() -> Impact {
    Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])])
}

/// Releases the locks by which others see that nodes of this process live: a process loses its locks of a file when it closes any of its
/// descriptors (POSIX).
fn look_dead(nodes: &[PathBuf]) {
    nodes.iter().filter(|path| path.is_file()).for_each(|path| drop(std::fs::File::open(path).unwrap()));
}

/// Starts a daemon, and a living client that looks dead: the next daemon removes everything that the client is connected to.
fn cleared_away(here: &TestPlace) -> (Child, Client, Object) {
    let others = here.nodes();
    let first = Child::start(&mut role(here, "daemon", "[times]\ncleanup_ms = 60000"));
    let daemons = here.nodes();
    let service = connect(here);
    let vase = service.object("vase", patience()).unwrap();
    let own: Vec<PathBuf> = here.nodes().into_iter().filter(|node| !daemons.contains(node)).collect();
    assert!(own.iter().any(|node| node.is_file()) && others.len() < daemons.len());
    look_dead(&own);
    assert_eq!(first.terminate().code(), Some(0));
    (Child::start(&mut role(here, "daemon", "")), service, vase)
}

#[test]
fn a_call_that_reached_no_daemon_is_made_again_over_a_new_connection() {
    let calls: [fn(&Client, &Object); 4] = [
        |_, vase| _ = vase.strike(&impact()).unwrap().wait(patience()).unwrap(),
        |service, _| assert_eq!(service.objects(patience()).unwrap().len(), 1),
        |service, _| assert_eq!(service.status(patience()).unwrap().objects_ready, 1),
        |service, _| assert_eq!(service.release(7, patience()).unwrap_err().kind, ErrorKind::UnknownHandle),
    ];
    for call in calls {
        let here = TestPlace::new("cleared");
        here.database("vase", "tetra");
        let (daemon, service, vase) = cleared_away(&here);
        call(&service, &vase);
        drop((service, vase));
        assert_eq!(daemon.terminate().code(), Some(0));
    }
}

fn reply<R: ReplyRow>(question: &ActiveControlRequest, rows: &[R]) {
    let mut payload = vec![Block::zeroed(); control::blocks::<R>(rows.len()).max(1)];
    let header = control::write(&mut payload, rows, rows.len(), false);
    let mut reply = question.loan_slice_uninit(payload.len()).unwrap().write_from_slice(&payload);
    *reply.user_header_mut() = header;
    reply.send().unwrap();
}

/// Serves one object until `over`. Closes every request without a result, and reports `verdict` as the error. Returns the listeners of the
/// requests.
fn close_every_strike(ports: &Ports, verdict: &Error, over: impl Fn() -> bool) -> Vec<[u8; 16]> {
    let mut vase = ObjectRow { state: control::ObjectState::Ready as u32, ..ObjectRow::zeroed() };
    vase.set_name("vase");
    let mut listeners = Vec::new();
    while !over() {
        while let Some(strike) = ports.next_strike() {
            listeners.push(strike.payload().listener);
        }
        while let Some(question) = ports.next_question() {
            match question.payload().validate().unwrap() {
                ControlRequest::List(_) => reply(&question, &[vase]),
                ControlRequest::Verdict(_) => reply(&question, &[ErrorWire::from(verdict)]),
                other => panic!("{other:?}"),
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    listeners
}

/// Errors of two requests of one client that a daemon closes with this error, and whether both came over one connection.
fn struck_twice(verdict: ErrorKind) -> ([ErrorKind; 2], bool) {
    let here = TestPlace::new("forgot");
    let home = RuntimeDirectory::take(&here.place).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let inside = runtime.enter();
    let (ports, _bell, _waker) = Ports::open(home.instance(), PoolSize { clients: 4, buckets: 4, blocks: 64 }).unwrap();
    drop(inside);
    home.announce().unwrap();
    let verdict = Error::new(verdict, "strike", "says the daemon");
    std::thread::scope(|scope| {
        let client = scope.spawn(|| {
            let vase = connect(&here).object("vase", patience()).unwrap();
            [(); 2].map(|()| vase.strike(&impact()).unwrap().wait(patience()).err().unwrap().kind)
        });
        let listeners = close_every_strike(&ports, &verdict, || client.is_finished());
        assert_eq!(listeners.len(), 2);
        (client.join().unwrap(), listeners[0] == listeners[1])
    })
}

#[test]
fn a_strike_that_nobody_gave_up_is_lost_and_the_next_comes_over_a_new_connection() {
    assert_eq!(struck_twice(ErrorKind::Cancelled), ([ErrorKind::Lost; 2], false));
    assert_eq!(struck_twice(ErrorKind::Failed), ([ErrorKind::Failed; 2], true), "other errors are passed on unchanged");
}
