//! Extensions that a glTF file requires.

use super::{LIST, NODE, check, glb, gltf_buffer, gltf_text, read_bytes};
use shatter_fracture::surface::SurfaceError;

#[test]
fn gltf_with_an_unknown_required_extension_is_refused() {
    let required = |names: &str| {
        let text = gltf_text(NODE, 4, &LIST, "");
        text.replacen('{', &format!(r#"{{"extensionsUsed":[{names}],"extensionsRequired":[{names}],"#), 1)
    };
    let refused = required(r#""KHR_materials_unlit","EXT_unknown_shape""#);
    let wanted = "the glTF file requires the extension EXT_unknown_shape, which Shatter does not read; export the mesh without it";
    for (name, bytes) in [("a.glb", glb(&refused, gltf_buffer(&LIST))), ("a.gltf", refused.clone().into_bytes())] {
        let error = read_bytes(name, &bytes).unwrap_err();
        assert!(
            matches!(&error, SurfaceError::RequiredExtension { extension } if extension == "EXT_unknown_shape"),
            "{error}"
        );
        assert_eq!(error.to_string(), wanted, "{name}");
    }
    // Extensions of materials do not change the shape.
    check("a.glb", &glb(&required(r#""KHR_materials_unlit""#), gltf_buffer(&LIST)));
}
