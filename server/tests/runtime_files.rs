//! Protection of the entry point for clients, against another user of the machine and against damage by this user.

mod support;

use shatter_client::{Client, Contact, Deadline, Impact};
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt, symlink};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use support::{Child, InProcess, TestDirectory, eventually, play, role, timeout};

/// Id of a user without rights.
const OTHER: u32 = 65_534;

/// Runs the process of another role for the tests below; does nothing by itself.
#[test]
fn play_a_role() {
    play(|other| panic!("no such role: {other}"));
}

/// The segment that every client opens first.
fn segment(here: &TestDirectory) -> PathBuf {
    let found = here.shared_memory().into_iter().find(|path| path.to_string_lossy().ends_with(".global_mgmt"));
    found.expect("the segment of the transport")
}

/// True if a new client gets a result.
fn served(here: &TestDirectory) -> bool {
    let strike = || {
        let vase = Client::connect_at(&here.place, Deadline::ms(300))?.object("vase", timeout())?;
        vase.strike(&Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])]))?.wait(timeout())
    };
    strike().is_ok()
}

/// Success of `command` as another user; `None`, with a note, if this process may not change its user.
fn as_other(command: &mut Command) -> Option<bool> {
    if !rustix::process::geteuid().is_root() {
        println!("skipped: only root can act as another user");
        return None;
    }
    Some(command.uid(OTHER).gid(OTHER).status().unwrap().success())
}

fn shell(line: &str, path: &Path) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", line, "sh"]).arg(path).stderr(std::process::Stdio::null());
    command
}

fn place() -> TestDirectory {
    let here = TestDirectory::new("entrance");
    here.database("vase", "tetra");
    here
}

#[test]
fn another_user_can_neither_list_nor_create_segments() {
    let here = place();
    let daemon = Child::start(&mut role(&here, "daemon", "[times]\ncleanup_ms = 10"));
    let folder = here.instance().folder;
    assert_eq!(folder.symlink_metadata().unwrap().mode() & 0o777, 0o700);
    assert_eq!(here.transports(), [folder.as_path()], "what all users can name");
    let tries =
        ["ls \"$1\"", ": > \"$1\"/s_1_2.connection", "mv \"$1\" \"$1\"x", "dd if=/dev/zero of=\"$2\" bs=16 count=1"];
    for line in tries {
        if let Some(done) = as_other(shell(line, &folder).arg(segment(&here))) {
            assert!(!done, "another user did: {line}");
        }
    }
    assert!(served(&here));
    assert_eq!(daemon.terminate().code(), Some(0));
    assert_eq!(here.transports(), Vec::<PathBuf>::new());
}

/// The names of one daemon do not reveal those of the next; names that another user reserves beforehand stop no daemon.
#[test]
fn names_taken_by_another_user_stop_no_daemon() {
    let here = place();
    let first = Child::start(&mut role(&here, "daemon", ""));
    let taken = here.instance().folder;
    assert_eq!(first.terminate().code(), Some(0));
    let _ = as_other(&mut shell("mkdir \"$1\"", &taken));
    let second = Child::start(&mut role(&here, "daemon", ""));
    assert!(served(&here));
    assert_ne!(here.instance().folder, taken);
    assert_eq!(second.terminate().code(), Some(0));
    let _ = std::fs::remove_dir(taken);
    assert_eq!(here.transports(), Vec::<PathBuf>::new());
}

/// Damage to a file that only this user, or root, can do.
const DAMAGES: [fn(&Path); 3] = [
    |path| std::fs::write(path, [0; 16]).unwrap(),
    |path| std::fs::remove_file(path).unwrap(),
    |path| std::fs::remove_file(path).and_then(|()| std::fs::create_dir(path)).unwrap(),
];

/// Sends a supervisor's request; returns status line and body.
fn readyz(port: u16) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    stream.write_all(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    text
}

#[test]
fn damaged_entry_files_are_reported_by_readyz_and_restored() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    // Only requests of the supervisor check the folders, not the daemon by itself.
    let settings = format!("[operations]\nport = {port}\n[times]\ncleanup_ms = 60000");
    let daemon = InProcess::start(place(), &settings);
    assert!(readyz(port).contains(" 200 "));
    for (damager, damage) in DAMAGES.into_iter().enumerate() {
        let path = segment(&daemon.here);
        damage(&path);
        let reply = readyz(port);
        assert!(reply.contains(" 503 ") && reply.contains(path.to_str().unwrap()), "{damager}: {reply}");
        let reply = readyz(port);
        assert!(reply.contains(" 200 ") && reply.contains("restored"), "{damager}: {reply}");
        assert!(served(&daemon.here), "{damager}");
    }
    let folder = daemon.here.instance().folder;
    let set = |mode| std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(mode)).unwrap();
    set(0o755);
    let reply = readyz(port);
    assert!(reply.contains(" 503 ") && reply.contains(folder.to_str().unwrap()), "{reply}");
    set(0o700);
    assert!(readyz(port).contains(" 200 "));
}

#[test]
fn damaged_entry_files_are_restored_periodically() {
    let daemon = InProcess::start(place(), "[times]\ncleanup_ms = 20");
    for damage in DAMAGES {
        let path = segment(&daemon.here);
        damage(&path);
        let right = || path.metadata().is_ok_and(|data| data.is_file() && data.len() > 0);
        eventually(
            || "the segment is restored",
            || right() && std::fs::read(&path).is_ok_and(|bytes| bytes[..8] != [0; 8]),
        );
        assert!(served(&daemon.here));
    }
}

/// A daemon with an operations port that checks its folders all the time.
fn watched(here: &TestDirectory) -> (Child, u16) {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let settings = format!("[operations]\nport = {port}\n[times]\ncleanup_ms = 20");
    (Child::start(&mut role(here, "daemon", &settings)), port)
}

/// If shared memory is emptied under a running daemon (a logout, a cleaner), another folder of the same name can appear.
#[test]
fn a_folder_in_the_place_of_the_daemons_is_neither_cleaned_up_nor_written_to() {
    let here = place();
    let (daemon, port) = watched(&here);
    let (folder, name) = (here.instance().folder, segment(&here).file_name().unwrap().to_owned());
    let home = here.databases().with_file_name("home");
    std::fs::create_dir_all(home.join("2024/summer")).unwrap();
    std::fs::write(home.join("precious"), "precious").unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    std::fs::DirBuilder::new().mode(0o700).create(&folder).unwrap();
    symlink(&home, folder.join("nodes")).unwrap();
    symlink(home.join("precious"), folder.join(&name).with_extension("new")).unwrap();
    symlink(home.join("precious"), folder.join(format!("{}.new", name.display()))).unwrap();
    // Longer than the time for which nodes may be unfinished.
    std::thread::sleep(Duration::from_secs(7));
    let reply = readyz(port);
    assert!(reply.contains(" 503 ") && reply.contains(folder.to_str().unwrap()), "{reply}");
    assert!(home.join("2024/summer").exists());
    assert_eq!(std::fs::read_to_string(home.join("precious")).unwrap(), "precious");
    daemon.terminate();
    assert!(folder.join("nodes").symlink_metadata().is_ok() && home.join("2024/summer").exists());
    std::fs::remove_dir_all(folder).unwrap();
}

/// State after a power cut: the list of earlier daemons exists, their folders are gone, and one of them belongs to another user now.
#[test]
fn a_folder_of_another_user_under_the_name_of_an_earlier_daemon_is_not_read() {
    let here = place();
    let first = Child::start(&mut role(&here, "daemon", ""));
    let folder = here.instance().folder;
    first.kill();
    std::fs::remove_dir_all(&folder).unwrap();
    let trap = "umask 0; mkdir -p \"$1/nodes/1\" && cd \"$1/nodes\" && : > s_1.node_monitor && \
        head -c 16 /dev/urandom > s_1.node_monitor_context && mkfifo s_1.node_monitor_owner_lock";
    if as_other(&mut shell(trap, &folder)).is_some() {
        let second = Child::start(&mut role(&here, "daemon", ""));
        assert!(served(&here) && folder.join("nodes/1").exists());
        assert_eq!(second.terminate().code(), Some(0));
    }
    let _ = std::fs::remove_dir_all(folder);
}

#[test]
fn a_daemon_that_no_client_can_find_says_so() {
    let here = place();
    let (daemon, port) = watched(&here);
    assert!(readyz(port).contains(" 200 "));
    std::fs::remove_file(here.place.hello()).unwrap();
    eventually(|| "the hello is written again", || here.place.hello().exists());
    assert!(readyz(port).contains(" 200 ") && served(&here));
    for taken in [here.place.lock(), here.instance().folder.join("services")] {
        let aside = taken.with_extension("aside");
        std::fs::rename(&taken, &aside).unwrap();
        let reply = readyz(port);
        assert!(reply.contains(" 503 ") && reply.contains(taken.to_str().unwrap()), "{reply}");
        std::fs::rename(&aside, &taken).unwrap();
        assert!(readyz(port).contains(" 200 "), "{}", taken.display());
    }
    let folder = &here.place.folder;
    std::fs::remove_dir_all(folder).unwrap();
    let reply = readyz(port);
    assert!(reply.contains(" 503 ") && reply.contains(folder.to_str().unwrap()), "{reply}");
    daemon.kill();
    for path in here.transports() {
        std::fs::remove_dir_all(path).unwrap();
    }
}

/// The next daemon removes the files of a killed one, however often, also while clients of the killed one live on.
#[test]
fn files_of_killed_daemons_are_removed() {
    let here = place();
    let service = {
        let first = Child::start(&mut role(&here, "daemon", "[times]\ncleanup_ms = 20"));
        let service = Client::connect_at(&here.place, timeout()).unwrap();
        first.kill();
        service
    };
    let early = here.instance();
    for _ in 0..3 {
        Child::start(&mut role(&here, "daemon", "")).kill();
    }
    let last = Child::start(&mut role(&here, "daemon", "[times]\ncleanup_ms = 20"));
    assert!(early.folder.exists(), "a client still holds it");
    assert_eq!(service.status(timeout()).unwrap().restarts, 4, "the connection goes to the daemon that serves now");
    eventually(|| format!("left: {}", early.folder.display()), || !early.folder.exists());
    eventually(|| "one instance is left", || here.transports().len() == 1);
    drop(service);
    assert_eq!(last.terminate().code(), Some(0));
    assert_eq!(here.transports(), Vec::<PathBuf>::new());
}
