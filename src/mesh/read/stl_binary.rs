//! Binary STL: 80 bytes of header, a count, 50 bytes a facet.

use crate::geom::Vec3;
use crate::mesh::error::{Fault, FilePlace, Located, coordinate};
use crate::mesh::soup::{MAX_FACETS, Soup};
use crate::mesh::weld::Welder;

/// Header and count.
const HEADER: usize = 84;
/// Normal, three corners, attribute.
const FACET: usize = 50;

/// The facet count in the header; `None` for a file too short to have one.
fn count(bytes: &[u8]) -> Option<u32> {
    let at = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes([at[0], at[1], at[2], at[3]]))
}

/// Whether the length is exactly what the count asks for: the only trustworthy mark of the format.
pub(super) fn has_exact_length(bytes: &[u8]) -> bool {
    count(bytes).is_some_and(|count| bytes.len() as u64 == needed(count))
}

fn needed(count: u32) -> u64 {
    HEADER as u64 + FACET as u64 * u64::from(count)
}

/// Facets that the count asks for, as far as there are bytes for them.
pub(super) fn told(bytes: &[u8]) -> usize {
    count(bytes).map_or(0, |count| (count as usize).min((bytes.len() - HEADER) / FACET))
}

/// Reads the corners, equal ones once; stored normals are ignored, since they only repeat what the winding says.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, Located> {
    let have = bytes.len() as u64;
    let facets = count(bytes).ok_or(Fault::Truncated { have, need: HEADER as u64, facets: 0 }.at(FilePlace::File))?;
    let need = needed(facets);
    // Before anything is allocated: a hostile count must not ask for 200 GB.
    if have < need {
        return Err(Fault::Truncated { have, need, facets: facets.into() }.at(FilePlace::Byte(have)));
    }
    if facets as usize > MAX_FACETS {
        return Err(Fault::TooManyFacets { limit: MAX_FACETS }.at(FilePlace::File));
    }
    let mut soup = Soup::nameless();
    if have > need {
        soup.warnings.push(format!("{} bytes after the last of {facets} facets were ignored", have - need));
    }
    // Every corner stands in each of its facets, some six: kept as they come they would be the most that reading needs.
    let mut welder = Welder::new();
    soup.facets.reserve(facets as usize);
    soup.labels.reserve(facets as usize);
    for (index, facet) in bytes[HEADER..].chunks_exact(FACET).take(facets as usize).enumerate() {
        let mut corners = [0; 3];
        for (number, corner) in corners.iter_mut().zip(facet[12..48].chunks_exact(12)) {
            let at = vertex(corner).map_err(|fault| fault.at(FilePlace::Facet(index as u64)))?;
            *number = welder.number(at);
        }
        soup.push(corners);
    }
    soup.vertices = welder.into_vertices();
    Ok(soup)
}

fn vertex(bytes: &[u8]) -> Result<Vec3, Fault> {
    let mut at = Vec3::zeros();
    for (axis, word) in bytes.chunks_exact(4).enumerate() {
        at[axis] = coordinate(f32::from_le_bytes([word[0], word[1], word[2], word[3]]).into())?;
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::{has_exact_length, read};
    use crate::mesh::error::{Fault, FilePlace};

    fn file(count: u32, facets: &[[f32; 9]]) -> Vec<u8> {
        let mut bytes = vec![0; 80];
        bytes.extend(count.to_le_bytes());
        for corners in facets {
            bytes.extend([0; 12]);
            corners.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const ONE: [f32; 9] = [0.0, 0.0, 0.0, 1.5, 0.0, 0.0, -0.0, 2.5, 0.0];

    #[test]
    fn reads_corners_and_makes_zeros_positive() {
        let soup = read(&file(1, &[ONE])).unwrap();
        assert_eq!(soup.facets, [[0, 1, 2]]);
        assert_eq!(soup.vertices[1].x, 1.5);
        assert_eq!(soup.vertices[2].y, 2.5);
        assert_eq!(soup.vertices[2].x.to_bits(), 0.0_f64.to_bits());
        assert!(soup.warnings.is_empty());
    }

    #[test]
    fn a_hostile_count_is_refused_before_it_allocates() {
        let bytes = file(4_000_000_000, &[ONE]);
        assert!(!has_exact_length(&bytes));
        let error = read(&bytes).unwrap_err();
        assert_eq!(error.fault, Fault::Truncated { have: 134, need: 200_000_000_084, facets: 4_000_000_000 });
        assert_eq!(error.place, FilePlace::Byte(134));
        let error = read(&file(1, &[ONE])[..133]).unwrap_err();
        assert_eq!(error.fault, Fault::Truncated { have: 133, need: 134, facets: 1 }, "one byte short");
        let error = read(&bytes[..83]).unwrap_err();
        assert_eq!(error.fault, Fault::Truncated { have: 83, need: 84, facets: 0 });
    }

    #[test]
    fn trailing_bytes_are_counted_in_a_warning() {
        let mut bytes = file(1, &[ONE]);
        bytes.extend([7; 3]);
        let warnings = read(&bytes).unwrap().warnings;
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        assert!(warning.starts_with("3 bytes ") && warning.contains("1 facets"), "{warning}");
    }

    #[test]
    fn names_the_facet_of_a_value_that_is_not_a_number() {
        let mut bad = ONE;
        bad[4] = f32::NAN;
        let error = read(&file(2, &[ONE, bad])).unwrap_err();
        assert_eq!(error.place, FilePlace::Facet(1));
        assert!(matches!(error.fault, Fault::NotFinite { value } if value.is_nan()));
        bad[4] = 2e7;
        assert_eq!(read(&file(1, &[bad])).unwrap_err().fault, Fault::TooLarge { value: 2e7 });
    }
}
