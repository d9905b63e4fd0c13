//! XML document of a MuJoCo model.

use super::shapes::{Shape, Solid};
use super::{fragment_name, tensor_z_up, z_up};
use crate::{FragmentView, ObjectView, PrincipalInertia, principal};
use quick_xml::Writer;
use shatter_proto::result::Bond;
use std::fmt::Display;
use std::io;

type Xml = Writer<Vec<u8>>;

/// Colors of the `.glb` file, in sRGB.
const OUTER_RGBA: &str = "0.63 0.66 0.69 1";
const CRACK_RGBA: &str = "0.9 0.82 0.71 1";

/// Step of 2 ms, MuJoCo's default; fast fragments are stable with it and implicit damping.
const OPTION: [(&str, &str); 3] = [("timestep", "0.002"), ("integrator", "implicitfast"), ("gravity", "0 0 -9.81")];

/// Smallest inertia in the model, kg·m²: MuJoCo refuses inertias below 1e-15, so smaller ones are raised to this.
const INERTIA_MIN: &str = "1e-14";

/// Stiffness of bonds, the largest that the time step allows: a time constant of two and a half steps, critically damped.
const WELD: [(&str, &str); 2] = [("solref", "0.005 1"), ("solimp", "0.95 0.99 0.001")];

/// Writes the model as XML.
pub(super) fn xml(object: &ObjectView<'_>, shapes: &[Shape], meshes: &str) -> io::Result<String> {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    let root = writer.create_element("mujoco").with_attribute(("model", object.name));
    root.write_inner_content(|xml| {
        let compiler = [("angle", "radian"), ("meshdir", meshes), ("inertiafromgeom", "false")];
        empty(xml, "compiler", compiler.into_iter().chain([("boundinertia", INERTIA_MIN)]))?;
        empty(xml, "option", OPTION)?;
        defaults(xml)?;
        assets(xml, shapes)?;
        world(xml, object, shapes)?;
        bonds(xml, object)
    })?;
    let mut bytes = writer.into_inner();
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(io::Error::other)
}

fn empty<'a>(xml: &mut Xml, name: &str, attributes: impl IntoIterator<Item = (&'a str, &'a str)>) -> io::Result<()> {
    xml.create_element(name).with_attributes(attributes).write_empty()?;
    Ok(())
}

fn group(xml: &mut Xml, name: &str, content: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
    xml.create_element(name).write_inner_content(content)?;
    Ok(())
}

/// Joins numbers with spaces, each in a form that reads back exactly.
fn list<N: Display>(numbers: impl IntoIterator<Item = N>) -> String {
    numbers.into_iter().map(|number| number.to_string()).collect::<Vec<_>>().join(" ")
}

/// Writes the default classes: visible geometry is in group 2 and does not collide; colliding geometry is in group 3, which viewers hide.
fn defaults(xml: &mut Xml) -> io::Result<()> {
    let class = |xml: &mut Xml, name: &str, content: &[(&str, &str)]| {
        let class = xml.create_element("default").with_attribute(("class", name));
        class.write_inner_content(|xml| empty(xml, "geom", content.iter().copied()))?;
        Ok::<(), io::Error>(())
    };
    group(xml, "default", |xml| {
        empty(xml, "equality", WELD)?;
        for name in ["outer", "crack"] {
            let seen = [("type", "mesh"), ("contype", "0"), ("conaffinity", "0"), ("group", "2"), ("material", name)];
            class(xml, name, &seen)?;
        }
        class(xml, "solid", &[("group", "3")])
    })
}

fn assets(xml: &mut Xml, shapes: &[Shape]) -> io::Result<()> {
    group(xml, "asset", |xml| {
        for (name, rgba) in [("outer", OUTER_RGBA), ("crack", CRACK_RGBA)] {
            empty(xml, "material", [("name", name), ("rgba", rgba), ("specular", "0.1")])?;
        }
        for file in shapes.iter().flat_map(|shape| &shape.files).map(|(file, _)| file.as_str()) {
            let name = file.trim_end_matches(".obj");
            // Each body has its own inertia; the parts of a surface enclose no volume to derive it from.
            empty(xml, "mesh", [("name", name), ("file", file), ("inertia", "shell")])?;
        }
        Ok(())
    })
}

fn world(xml: &mut Xml, object: &ObjectView<'_>, shapes: &[Shape]) -> io::Result<()> {
    let (low, high) = extent(object.fragments);
    let size = [0, 1, 2].map(|k| high[k] - low[k]).into_iter().fold(0.0, f64::max);
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    group(xml, "worldbody", |xml| {
        let lamp = list([middle[0] + size, middle[1] - size, high[2] + 2.0 * size]);
        empty(xml, "light", [("name", "lamp"), ("pos", &lamp), ("dir", "-1 1 -2")])?;
        let (place, sides) = (list([middle[0], middle[1], low[2]]), list([10.0 * size, 10.0 * size, size]));
        let floor = [("name", "floor"), ("type", "plane"), ("pos", &place), ("size", &sides)];
        empty(xml, "geom", floor.into_iter().chain([("rgba", "0.35 0.37 0.4 1")]))?;
        object.fragments.iter().zip(shapes).try_for_each(|(fragment, shape)| {
            body(xml, &fragment_name(fragment.id, object.fragments.len()), fragment, shape)
        })
    })
}

fn body(xml: &mut Xml, name: &str, fragment: &FragmentView<'_>, shape: &Shape) -> io::Result<()> {
    let place = list(z_up(fragment.center_m));
    let element = xml.create_element("body").with_attributes([("name", name), ("pos", place.as_str())]);
    element.write_inner_content(|xml| {
        empty(xml, "freejoint", [("name", name)])?;
        let PrincipalInertia { moments_kg_m2, quaternion } = principal(tensor_z_up(fragment.inertia_kg_m2));
        let (mass, moments, turn) = (fragment.mass_kg.to_string(), list(moments_kg_m2), list(quaternion));
        let inertial = [("pos", "0 0 0"), ("quat", turn.as_str()), ("mass", &mass), ("diaginertia", &moments)];
        empty(xml, "inertial", inertial)?;
        for (class, mesh) in &shape.seen {
            empty(xml, "geom", [("name", mesh.as_str()), ("class", class), ("mesh", mesh)])?;
        }
        let solid = [("name", name), ("class", "solid")].into_iter();
        match &shape.solid {
            Solid::Mesh(mesh) => empty(xml, "geom", solid.chain([("type", "mesh"), ("mesh", mesh)])),
            Solid::Box(center, halves) => {
                let (place, sides) = (list(*center), list(*halves));
                empty(xml, "geom", solid.chain([("type", "box"), ("pos", &place), ("size", &sides)]))
            }
        }
    })?;
    Ok(())
}

/// Lowest and highest coordinates of all fragments, m.
fn extent(fragments: &[FragmentView<'_>]) -> ([f64; 3], [f64; 3]) {
    let start = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let points = fragments.iter().flat_map(|fragment| {
        let center = fragment.center_m;
        fragment.positions.iter().map(move |own| z_up([0, 1, 2].map(|k| center[k] + f64::from(own[k]))))
    });
    points.fold(start, |(low, high), point| {
        ([0, 1, 2].map(|k| low[k].min(point[k])), [0, 1, 2].map(|k| high[k].max(point[k])))
    })
}

/// Writes welds between fragments that share a bond, which do not collide, and welds to the world.
fn bonds(xml: &mut Xml, object: &ObjectView<'_>) -> io::Result<()> {
    if object.bonds.is_empty() {
        return Ok(());
    }
    let name = |id: u32| fragment_name(id, object.fragments.len());
    let number = |id: u32| name(id).trim_start_matches("fragment_").to_owned();
    let pairs = || object.bonds.iter().filter_map(|bond| Some([bond.fragment, bond.neighbor?]));
    if pairs().next().is_some() {
        group(xml, "contact", |xml| {
            pairs().try_for_each(|pair| {
                let [one, two] = pair.map(name);
                empty(xml, "exclude", [("body1", one.as_str()), ("body2", &two)])
            })
        })?;
    }
    group(xml, "equality", |xml| object.bonds.iter().try_for_each(|bond| weld(xml, object, bond, name, number)))?;
    let areas = list(object.bonds.iter().map(|bond| bond.area_m2));
    group(xml, "custom", |xml| empty(xml, "numeric", [("name", "bond_area_m2"), ("data", &areas)]))
}

/// Writes a weld. Its anchor, in the frame of the second body or of the world, is the point where MuJoCo measures residuals.
fn weld(
    xml: &mut Xml,
    object: &ObjectView<'_>,
    bond: &Bond,
    name: impl Fn(u32) -> String,
    number: impl Fn(u32) -> String,
) -> io::Result<()> {
    let (first, one) = (bond.fragment, name(bond.fragment));
    let Some(second) = bond.neighbor else {
        let (own, anchor) = (format!("bond_{}_world", number(first)), list(z_up(bond.centroid_m)));
        return empty(xml, "weld", [("name", own.as_str()), ("body1", &one), ("anchor", &anchor)]);
    };
    let center = object.fragments[second as usize].center_m;
    let anchor = list(z_up([0, 1, 2].map(|k| bond.centroid_m[k] - center[k])));
    let (own, two) = (format!("bond_{}_{}", number(first), number(second)), name(second));
    empty(xml, "weld", [("name", own.as_str()), ("body1", &one), ("body2", &two), ("anchor", &anchor)])
}
