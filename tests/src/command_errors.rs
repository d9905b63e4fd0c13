//! Errors that only the commands of `shatterd` have: of meshes, materials, bakes, databases and shares.

use crate::pages;
use crate::sources::root;
use std::collections::BTreeSet;

/// Kind, cause and remedy. A new kind needs a line here.
pub const COMMAND_ERRORS: [(&str, &str, &str); 55] = [
    ("all_degenerate", "Every triangle of the mesh has no area.", "Export a mesh with an inside."),
    ("calibration", "The bake failed inside the engine.", "Report it with the mesh."),
    ("corrupt_database", "A file is damaged or cut off, or is no database.", "Bake the object again."),
    (
        "cracks_miss",
        "No existing crack reaches the object.",
        "Move the cracks into the object, or export both with one unit and up axis.",
    ),
    (
        "cracks_take_all",
        "The existing cracks leave nothing of the object.",
        "Use a finer `--crack-spacing`, or fewer cracks.",
    ),
    (
        "cracks_too_small",
        "Every existing crack is smaller than the lattice resolves.",
        "Use a finer `--crack-spacing`, or larger cracks.",
    ),
    ("database_file", "A database cannot be read or written.", "Check the path, its permissions and the free space."),
    (
        "database_format",
        "The file is no database of this version.",
        "Name a file that `shatterd bake` of this version wrote.",
    ),
    ("database_share", "The file is one share of a bake.", "Join all shares with `shatterd merge`."),
    ("demo", "The demonstration failed.", "Follow the message. If it names no reason outside the program, report it."),
    (
        "elasticity",
        "The elastic body cannot be solved.",
        "Thicken the joint that the message names, or bake the parts as separate objects; else repair the mesh.",
    ),
    (
        "empty_mesh",
        "The file contains no vertices or no triangles.",
        "Export the mesh again, as triangles or polygons.",
    ),
    ("extent_out_of_range", "The mesh, or a vertex, is too large or too small.", "Check `--unit`."),
    ("far_vertex", "A few vertices are very far from all others.", "Remove the vertices that the message names."),
    ("grid_too_large", "The spacing needs too large a grid.", "Use a coarser spacing."),
    ("interrupted", "A signal ended the command.", "Run it again; `bake --resume` continues with finished examples."),
    ("kept_share", "An earlier, unfinished bake of this object is kept.", "Pass `--resume` or `--restart`."),
    ("lattice", "The lattice failed inside the engine.", "Report it with the mesh."),
    (
        "malformed_file",
        "The file breaks the rules of its format.",
        "Correct the place that the message names, or export again.",
    ),
    ("material_number", "A number of a material is out of its range.", "Correct the key that the message names."),
    ("material_table", "The table of materials is no valid TOML.", "Correct the place that the message names."),
    ("no_examples", "The database has no examples.", "Bake it with `--examples`."),
    (
        "no_shape",
        "No object of the scene has a shape, so that there is nothing to bake.",
        "Add the key `shape`, or bake a mesh by `shatterd bake MESH`.",
    ),
    ("no_share", "There is no share to join.", "Name the files of the shares."),
    (
        "non_finite_vertex",
        "A coordinate is not a finite number.",
        "Correct the vertex that the message names, counted from 0.",
    ),
    ("not_positive", "A number must be above zero.", "Correct the option or key that the message names."),
    ("nothing_inside", "The mesh is flat or has no inside.", "Close the mesh, or give it a thickness."),
    ("other_bits", "Shares of one bake differ.", "Bake all shares with the same program."),
    (
        "other_mesh",
        "The mesh is not the one that the database was baked from.",
        "Name the original mesh, or bake anew.",
    ),
    ("other_work", "A share belongs to another bake.", "Join only shares of one bake."),
    ("out_of_range", "A number is outside its range.", "Use a number of the range in the message."),
    ("page", "The page of `inspect --out` cannot be written.", "Report it with the database."),
    (
        "required_extension",
        "A glTF file requires an extension that Shatter does not read.",
        "Export the mesh without it.",
    ),
    (
        "severed_parts",
        "The preset would separate parts of the object.",
        "Use the preset or the spacing that the message names, or thicken the joint.",
    ),
    ("shard", "`--shard`, or the job's variables, do not name a share.", "Use I/N with I from 0 to N − 1."),
    ("share_missing", "A share is missing.", "Bake the share that the message names."),
    ("share_twice", "A share was given twice.", "Name each share once."),
    ("spacing_order", "The crack lattice is coarser than the elastic lattice.", "Use a smaller `--crack-spacing`."),
    ("spacing_out_of_range", "A spacing is outside its range.", "Use a spacing of the range in the message."),
    ("too_large", "The file is larger than this version reads.", "Reduce the mesh."),
    ("too_many_examples", "More examples than the limit.", "Use fewer `--examples`."),
    ("too_many_nodes", "The lattice would have too many nodes.", "Use a coarser spacing."),
    ("too_small", "The object is smaller than a few cells.", "Use a finer spacing."),
    (
        "study",
        "An object cannot be studied, for example because it stays whole; with the fault `service`, the study failed.",
        "Name another object; report a fault of the service.",
    ),
    (
        "too_thin",
        "A quarter of the walls or more are thinner than the lattice can keep.",
        "Use the spacing that the message names; if no spacing is fine enough, make the walls thicker, or bake the object in smaller parts.",
    ),
    ("unfinished_share", "A share has no result yet.", "Finish its bake with `--resume`."),
    (
        "unknown_format",
        "The format of the file is not known.",
        "Use OBJ, PLY, STL, glTF or GLB; for tetrahedral meshes Gmsh, VTK or Medit.",
    ),
    ("unknown_material", "The table has no such material.", "Use a name of the message, or `--materials`."),
    ("unknown_mesh", "No mesh of the study has this name.", "Name one that the study lists."),
    ("unreadable_file", "The file cannot be read.", "Check the path and its permissions."),
    ("usage", "The command line is not valid.", "See the message, or `--help`."),
    (
        "vertex_out_of_bounds",
        "A face names a vertex that does not exist. For OBJ, the kind is `malformed_file`.",
        "Export the mesh again.",
    ),
    ("whole_database", "The database is whole, not a share.", "Name shares to `merge`."),
    ("zero_extent", "All vertices are one point.", "Export the mesh again."),
    ("closed", "The reader of stdout closed it.", "None is needed."),
];

/// Kinds in the source of the commands that no error kind of the service has.
pub fn kinds_in_source(service: &BTreeSet<&str>) -> BTreeSet<String> {
    let mut kinds = BTreeSet::from(["closed".to_owned()]);
    let folders = ["server/src/commands", "server/lab/src/commands"];
    let entries = folders.iter().flat_map(|folder| {
        let names = std::fs::read_dir(root().join(folder)).unwrap();
        names.map(move |entry| (folder, entry.unwrap().file_name().into_string().unwrap()))
    });
    for (folder, name) in entries.filter(|(_, name)| name.ends_with(".rs")) {
        let text = pages::text(&format!("{folder}/{name}"));
        let shipped = text.split("#[cfg(test)]").next().unwrap();
        let marks: &[&str] = match name.as_str() {
            "command_error.rs" => {
                &["refused(", "ours(", "=> (", "=> ", "{\n                (", ");\n                ("]
            }
            _ => &["refused(", "ours("],
        };
        for rest in marks.iter().flat_map(|mark| shipped.split(mark).skip(1)) {
            let kind = rest.trim_start().strip_prefix('"').and_then(|rest| rest.split('"').next());
            let is_kind = |kind: &&str| !kind.is_empty() && kind.chars().all(|c| c.is_ascii_lowercase() || c == '_');
            kinds.extend(kind.filter(is_kind).filter(|kind| !service.contains(kind)).map(str::to_owned));
        }
    }
    kinds
}
