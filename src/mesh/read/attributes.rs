//! Attributes of an XML tag.

use quick_xml::XmlVersion;
use quick_xml::events::BytesStart;

use crate::mesh::error::Fault;

/// The attribute whose local name is `name`, unescaped.
pub(super) fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<Option<String>, Fault> {
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| Fault::Xml { reason: error.to_string() })?;
        if attribute.key.local_name().as_ref() == name {
            let value = attribute.normalized_value(XmlVersion::default());
            let value = value.map_err(|error| Fault::Xml { reason: error.to_string() })?;
            return match value.chars().find(|c| !is_xml(*c)) {
                Some(c) => Err(Fault::Xml { reason: format!("character {} is not allowed in XML", u32::from(c)) }),
                None => Ok(Some(value.into_owned())),
            };
        }
    }
    Ok(None)
}

/// Whether XML 1.0 has the character (production 2), written out or by its number.
fn is_xml(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..)
}
