//! An independent reader of XML models: elements and their attributes, in the order of the document.

use anyhow::{Context, Result, ensure};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// One element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Element {
    /// Name of the element.
    pub name: String,
    attributes: Vec<(String, String)>,
}

impl Element {
    fn new(start: &BytesStart<'_>) -> Result<Self> {
        let attributes = start.attributes().map(|attribute| {
            let attribute = attribute?;
            let key = String::from_utf8(attribute.key.as_ref().to_vec())?;
            Ok((key, attribute.unescape_value()?.into_owned()))
        });
        let name = String::from_utf8(start.name().as_ref().to_vec())?;
        Ok(Self { name, attributes: attributes.collect::<Result<_>>()? })
    }

    /// Value of an attribute.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == key).map(|(_, value)| value.as_str())
    }

    /// Value of an attribute with one number.
    #[track_caller]
    pub fn number(&self, key: &str) -> f64 {
        self.numbers::<1>(key)[0]
    }

    /// Values of an attribute with `N` numbers.
    #[track_caller]
    pub fn numbers<const N: usize>(&self, key: &str) -> [f64; N] {
        let text = self.get(key).unwrap_or_else(|| panic!("no {key} in {self:?}"));
        let numbers: Vec<f64> = text.split(' ').map(|number| number.parse().unwrap()).collect();
        numbers.try_into().unwrap_or_else(|_| panic!("{key} of {self:?}"))
    }
}

/// All elements of a well-formed document with one root. Refuses duplicate attributes.
pub fn elements(text: &str) -> Result<Vec<Element>> {
    let (mut reader, mut found, mut depth, mut roots) = (Reader::from_str(text), Vec::new(), 0_usize, 0);
    loop {
        match reader.read_event()? {
            Event::Start(start) => {
                roots += usize::from(depth == 0);
                depth += 1;
                found.push(Element::new(&start)?);
            }
            Event::Empty(start) => {
                roots += usize::from(depth == 0);
                found.push(Element::new(&start)?);
            }
            Event::End(_) => depth = depth.checked_sub(1).context("more ends than starts")?,
            Event::Eof => break,
            _ => {}
        }
    }
    ensure!(depth == 0 && roots == 1, "{roots} roots, {depth} elements are open");
    Ok(found)
}
