use super::*;

#[test]
fn obj_looks_are_read_by_corner() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\nusemtl red brick\n\
        f 1/1/1 2/2/1 3/3/1 4/4/1\nusemtl moss\nf 1/-4/-1 3/-2/-1 \\\n 4/-1/-1\nusemtl red brick\nf 1/1/1 2/2/1 4/4/1\n";
    let attributes = read_bytes("a.obj", text.as_bytes()).unwrap().attributes;
    assert_eq!(
        (attributes.materials, attributes.names),
        (vec![0, 0, 1, 0], vec!["red brick".to_owned(), "moss".to_owned()])
    );
    assert_eq!(attributes.normals, [[[0.0, 0.0, 1.0]; 3]; 4]);
    let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mesh = read_bytes("a.obj", text.as_bytes()).unwrap();
    for (triangle, uvs) in mesh.triangles.iter().zip(&attributes.uvs) {
        assert_eq!(*uvs, triangle.map(|vertex| corner[vertex as usize]));
    }
    for (from, to) in [("vn 0 0 2", "vn 0 0 0"), ("3/-2/-1", "3/-2/-9"), ("3/-2/-1", "3/-2")] {
        let attributes = read_bytes("a.obj", text.replace(from, to).as_bytes()).unwrap().attributes;
        assert!(attributes.normals.is_empty() && attributes.uvs.len() == 4, "{to}");
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), text).unwrap();
    let attributes = read(&folder.path().join("a.obj"), LengthUnit::Cm, UpAxis::Z).unwrap().attributes;
    assert_eq!(attributes.normals[0][0], [0.0, 1.0, 0.0]);
}

#[test]
fn ply_looks_are_read_by_vertex() {
    let rows = |extra: [&str; 3]| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0 {}\n1 0 0 {}\n0 1 0 {}\n3 0 1 2\n",
            extra[0], extra[1], extra[2]
        )
    };
    let good = read_bytes("a.ply", rows(["0 0 1 0 0", "0 0 1 1 0", "0 0 1 0 .5"]).as_bytes()).unwrap().attributes;
    assert_eq!((good.normals, good.uvs), (vec![[[0.0, 0.0, 1.0]; 3]], vec![[[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]]));
    let damaged = read_bytes("a.ply", rows(["0 0 1 0 0", "what 0 1 1 0", "0 0 1 0 1"]).as_bytes()).unwrap().attributes;
    assert!(damaged.normals.is_empty() && damaged.uvs.len() == 1);
}
