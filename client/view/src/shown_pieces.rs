//! The pieces that the page shows, of several results, as one object.

use shatter_client::FractureResult;
use shatter_client::export::{FragmentView, HullView, ObjectView};
use shatter_proto::result::Bond;

/// A result, and those of its fragments that are shown.
pub(crate) struct ShownPieces {
    pub result: FractureResult,
    pub ids: Vec<u32>,
}

/// Parts of an object under construction.
#[derive(Clone, Default)]
struct Parts<'a> {
    fragments: Vec<FragmentView<'a>>,
    hulls: Vec<Option<HullView<'a>>>,
    bonds: Vec<Bond>,
}

/// Calls `read` with the shown pieces of all results as one object `name`, numbered in their order. Bonds are those within a result.
pub(crate) fn with_object<R>(name: &str, shown: &[ShownPieces], read: &mut dyn FnMut(&ObjectView<'_>) -> R) -> R {
    gather(name, shown, Parts::default(), read)
}

/// Adds the pieces of the first result, whose meshes are borrowed, then those of the others.
fn gather<R>(name: &str, shown: &[ShownPieces], parts: Parts<'_>, read: &mut dyn FnMut(&ObjectView<'_>) -> R) -> R {
    let Some((first, others)) = shown.split_first() else {
        let Parts { fragments, hulls, bonds } = &parts;
        return read(&ObjectView { name, fragments, hulls, bonds });
    };
    first.result.with_object(|object| gather(name, others, parts.and(object, &first.ids), read))
}

impl<'a> Parts<'a> {
    /// These parts and the pieces `ids` of `object`.
    fn and<'b>(&self, object: &ObjectView<'b>, ids: &[u32]) -> Parts<'b>
    where
        'a: 'b,
    {
        let mut parts: Parts<'b> = self.clone();
        let first = parts.fragments.len() as u32;
        let number = |id: u32| ids.iter().position(|own| *own == id).map(|place| first + place as u32);
        let found = ids.iter().filter_map(|id| object.fragments.iter().position(|fragment| fragment.id == *id));
        for place in found {
            let fragment = object.fragments[place];
            parts.fragments.push(FragmentView { id: parts.fragments.len() as u32, ..fragment });
            if !object.hulls.is_empty() {
                parts.hulls.push(object.hulls[place]);
            }
        }
        let renumbered = object.bonds.iter().filter_map(|bond| {
            let neighbor = match bond.neighbor {
                None => None,
                Some(neighbor) => Some(number(neighbor)?),
            };
            let mut bond = *bond;
            (bond.fragment, bond.neighbor) = (number(bond.fragment)?, neighbor);
            Some(bond)
        });
        parts.bonds.extend(renumbered);
        parts
    }
}
