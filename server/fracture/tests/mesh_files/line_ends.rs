//! Line ends of Unix, Windows and old Macs in OBJ files.

use super::*;

#[test]
fn obj_lines_end_as_on_any_system() {
    let [unix, mac, dos] = ["\n", "\r", "\r\n"].map(|end| {
        let lines = ["# it", "v 0 0 0", "v 1 \\", "0 0", "v 0 1 0", "vt 0 1", "f 1/1 2/1 3/1"]
            .map(|line| line.to_owned() + end);
        read_bytes("a.obj", lines.concat().as_bytes()).unwrap()
    });
    assert_eq!((unix.triangles.len(), unix.attributes.uvs.len()), (1, 1));
    assert!(mac == unix && dos == unix);
    check_malformed("a.obj", b"v 0 0 0\rv 1 0\r", "line 2");
}
