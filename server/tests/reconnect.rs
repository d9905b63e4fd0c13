//! Living clients that a daemon treats as dead: their calls use a new connection, and their requests under way are lost.

mod support;

use bytemuck::Zeroable;
use shatter_client::{Client, Contact, Error, ErrorKind, Impact, Object};
use shatter_proto::control::{self, ControlRequest, ObjectRow, ReplyRow};
use shatter_proto::error::ErrorWire;
use shatter_proto::result::AlignedBlock;
use shatter_server::ipc::{ActiveControlRequest, DaemonPorts, PoolSize, RuntimeDirectory};
use std::path::PathBuf;
use std::time::Duration;
use support::{Child, TestDirectory, play, role, timeout};

/// Runs the process of another role for the tests below; does nothing by itself.
#[test]
fn play_a_role() {
    play(|other| panic!("no such role: {other}"));
}

fn connect(here: &TestDirectory) -> Client {
    Client::connect_at(&here.place, timeout()).unwrap()
}

fn impact() -> Impact {
    Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])])
}

/// Releases the locks by which others see that nodes of this process live: a process loses its locks of a file when it closes any of its
/// descriptors (POSIX).
fn simulate_dead_connection(nodes: &[PathBuf]) {
    nodes.iter().filter(|path| path.is_file()).for_each(|path| drop(std::fs::File::open(path).unwrap()));
}

/// Starts a daemon, and a living client that looks dead: the next daemon removes everything that the client is connected to.
fn evicted_client(here: &TestDirectory) -> (Child, Client, Object) {
    let others = here.nodes();
    let first = Child::start(&mut role(here, "daemon", "[times]\ncleanup_ms = 60000"));
    let daemons = here.nodes();
    let service = connect(here);
    let vase = service.object("vase", timeout()).unwrap();
    let own: Vec<PathBuf> = here.nodes().into_iter().filter(|node| !daemons.contains(node)).collect();
    assert!(own.iter().any(|node| node.is_file()) && others.len() < daemons.len());
    simulate_dead_connection(&own);
    assert_eq!(first.terminate().code(), Some(0));
    (Child::start(&mut role(here, "daemon", "")), service, vase)
}

#[test]
fn a_call_that_reached_no_daemon_is_made_again_over_a_new_connection() {
    let calls: [fn(&Client, &Object); 4] = [
        |_, vase| _ = vase.strike(&impact()).unwrap().wait(timeout()).unwrap(),
        |service, _| assert_eq!(service.objects(timeout()).unwrap().len(), 1),
        |service, _| assert_eq!(service.status(timeout()).unwrap().objects_ready, 1),
        |service, _| assert_eq!(service.release(7, timeout()).unwrap_err().kind, ErrorKind::UnknownHandle),
    ];
    for call in calls {
        let here = TestDirectory::new("cleared");
        here.database("vase", "tetra");
        let (daemon, service, vase) = evicted_client(&here);
        call(&service, &vase);
        drop((service, vase));
        assert_eq!(daemon.terminate().code(), Some(0));
    }
}

fn reply<R: ReplyRow>(request: &ActiveControlRequest, rows: &[R]) {
    let mut payload = vec![AlignedBlock::zeroed(); control::blocks::<R>(rows.len()).max(1)];
    let header = control::write(&mut payload, rows, rows.len(), false);
    let mut reply = request.loan_slice_uninit(payload.len()).unwrap().write_from_slice(&payload);
    *reply.user_header_mut() = header;
    reply.send().unwrap();
}

/// Serves one object until `over`. Closes every request without a result, and reports `failure` as the error. Returns the listeners of the
/// requests.
fn reject_all_requests(ports: &DaemonPorts, failure: &Error, over: impl Fn() -> bool) -> Vec<[u8; 16]> {
    let mut vase = ObjectRow { state: control::ObjectState::Ready as u32, ..ObjectRow::zeroed() };
    vase.set_name("vase");
    let mut listeners = Vec::new();
    while !over() {
        while let Some(strike) = ports.next_impact_request() {
            listeners.push(strike.payload().listener);
        }
        while let Some(request) = ports.next_control_request() {
            match request.payload().validate().unwrap() {
                ControlRequest::List(_) => reply(&request, &[vase]),
                ControlRequest::RequestError(_) => reply(&request, &[ErrorWire::from(failure)]),
                other => panic!("{other:?}"),
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    listeners
}

/// Errors of two requests of one client that a daemon closes with this error, and whether both came over one connection.
fn struck_twice(failure: ErrorKind) -> ([ErrorKind; 2], bool) {
    let here = TestDirectory::new("forgot");
    let directory = RuntimeDirectory::take(&here.place).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let inside = runtime.enter();
    let (ports, _wake_socket, _waker) =
        DaemonPorts::open(directory.instance(), PoolSize { clients: 4, buckets: 4, blocks: 64 }).unwrap();
    drop(inside);
    directory.announce().unwrap();
    let failure = Error::new(failure, "strike", "says the daemon");
    std::thread::scope(|scope| {
        let client = scope.spawn(|| {
            let vase = connect(&here).object("vase", timeout()).unwrap();
            [(); 2].map(|()| vase.strike(&impact()).unwrap().wait(timeout()).err().unwrap().kind)
        });
        let listeners = reject_all_requests(&ports, &failure, || client.is_finished());
        assert_eq!(listeners.len(), 2);
        (client.join().unwrap(), listeners[0] == listeners[1])
    })
}

#[test]
fn an_evicted_request_is_lost_and_the_client_reconnects() {
    assert_eq!(struck_twice(ErrorKind::Canceled), ([ErrorKind::Lost; 2], false));
    assert_eq!(struck_twice(ErrorKind::Failed), ([ErrorKind::Failed; 2], true), "other errors are passed on unchanged");
}
