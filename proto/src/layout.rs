//! From counts to offsets: the position of every section of a result before a byte of it is written.

use crate::PROTOCOL_VERSION;
use crate::result::{AlignedBlock, BLOCK_BYTES, RESULT_MAGIC, ResultHeader, SectionKind, SectionWire};
use bytemuck::Zeroable;

pub use crate::sections::{SectionCounts, SectionsMut};

/// Number of sections of a result.
pub const SECTIONS: usize = SectionKind::ALL.len();

/// Bytes of the section table.
pub const TABLE_BYTES: usize = SECTIONS * size_of::<SectionWire>();

/// Offsets and lengths of all sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    table: [SectionWire; SECTIONS],
    used_bytes: u64,
}

impl Layout {
    /// Lays out a result; `None` for counts beyond 2³² elements per section, which the tables cannot address.
    pub fn new(counts: &SectionCounts) -> Option<Self> {
        let mut table = [SectionWire::zeroed(); SECTIONS];
        let mut end = TABLE_BYTES as u64;
        for (entry, kind) in table.iter_mut().zip(SectionKind::ALL) {
            let elements = u32::try_from(counts.elements(kind)).ok()?;
            let element_bytes = kind.element_bytes() as u32;
            let offset = end.next_multiple_of(BLOCK_BYTES as u64);
            let length = u64::from(elements) * u64::from(element_bytes);
            *entry = SectionWire { kind: kind as u32, element_bytes, offset, length };
            end = offset + length;
        }
        Some(Self { table, used_bytes: end })
    }

    /// Bytes of the sections that every result has.
    pub fn base_bytes(&self) -> u64 {
        let base = SectionKind::ALL.into_iter().zip(&self.table).filter(|(kind, _)| kind.effect().is_none());
        base.map(|(_, entry)| entry.length).sum()
    }

    /// Bytes that count.
    pub fn used_bytes(&self) -> u64 {
        self.used_bytes
    }

    /// Blocks to lend.
    pub fn blocks(&self) -> usize {
        self.used_bytes.div_ceil(BLOCK_BYTES as u64) as usize
    }

    /// The header of the result of request `sequence`.
    pub fn header(&self, sequence: u64) -> ResultHeader {
        ResultHeader {
            magic: RESULT_MAGIC,
            version: PROTOCOL_VERSION,
            status: 1,
            sections: SECTIONS as u32,
            used_bytes: self.used_bytes,
            sequence,
            reserved: [0; 4],
        }
    }

    /// Writes the section table, zeroes the padding between sections, and hands out the sections, whose contents are
    /// still whatever was there. `None` if `payload` is shorter than [`Self::blocks`].
    pub fn split<'a>(&self, payload: &'a mut [AlignedBlock]) -> Option<SectionsMut<'a>> {
        let bytes: &'a mut [u8] = bytemuck::cast_slice_mut(payload.get_mut(..self.blocks())?);
        let (table, mut rest) = bytes.split_at_mut_checked(TABLE_BYTES)?;
        table.copy_from_slice(bytemuck::bytes_of(&self.table));
        let mut at = TABLE_BYTES as u64;
        let mut parts = self.table.iter().map(|entry| {
            let (padding, tail) = std::mem::take(&mut rest).split_at_mut_checked((entry.offset - at) as usize)?;
            padding.fill(0);
            let (section, tail) = tail.split_at_mut_checked(entry.length as usize)?;
            (rest, at) = (tail, entry.offset + entry.length);
            Some(section)
        });
        // Every section begins at a multiple of 64 bytes, so the casts cannot fail on alignment.
        let sections = SectionsMut::of(|| parts.next().flatten())?;
        rest.fill(0);
        Some(sections)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_result_without_fragments_is_small() {
        let layout = Layout::new(&SectionCounts::default()).unwrap();
        assert_eq!((layout.used_bytes(), layout.blocks()), (1728, 27));
    }

    #[test]
    fn counts_beyond_the_tables_are_refused() {
        assert_eq!(Layout::new(&SectionCounts { vertices: 1 << 32, ..SectionCounts::default() }), None);
    }

    #[test]
    fn a_short_payload_is_refused() {
        let layout = Layout::new(&SectionCounts::default()).unwrap();
        let mut payload = vec![AlignedBlock::zeroed(); layout.blocks() - 1];
        assert!(layout.split(&mut payload).is_none());
    }

    proptest! {
        #[test]
        fn sections_are_aligned_disjoint_and_as_long_as_asked(
            (fragments, runs, merges, vertices, indices) in (0usize..9, 0usize..9, 0usize..99, 0usize..99, 0usize..99),
            (velocities, normals, uvs, bonds, debris) in (0usize..9, 0usize..99, 0usize..99, 0usize..9, 0usize..9),
            (hulls, hull_vertices, hull_indices) in (0usize..9, 0usize..99, 0usize..99),
            (outer_attributes, materials, skins) in (0usize..99, 0usize..99, 0usize..9),
            (skin_vertices, skin_indices, skin_materials) in (0usize..99, 0usize..99, 0usize..99),
            (outer_uvs2, outer_colors, skin_uvs2, skin_colors) in (0usize..99, 0usize..99, 0usize..99, 0usize..99),
        ) {
            let extra = SectionCounts { hulls, hull_vertices, hull_indices, outer_attributes, materials, skins, ..SectionCounts::default() };
            let extra = SectionCounts { skin_vertices, skin_indices, skin_materials, ..extra };
            let extra = SectionCounts { outer_uvs2, outer_colors, skin_uvs2, skin_colors, ..extra };
            let extra = SectionCounts { velocities, normals, uvs, bonds, debris, ..extra };
            let counts = SectionCounts { fragments, runs, merges, vertices, indices, ..extra };
            let layout = Layout::new(&counts).unwrap();
            let mut payload = vec![AlignedBlock { bytes: [0xaa; 64] }; layout.blocks()];
            let base = payload.as_ptr() as usize;
            let sections = layout.split(&mut payload).unwrap();
            prop_assert_eq!(sections.positions.len(), vertices);
            prop_assert_eq!((sections.merges.len(), sections.indices.len()), (merges, indices));
            prop_assert_eq!((sections.fragments.len(), sections.runs.len()), (fragments, runs));
            prop_assert_eq!((sections.positions.as_ptr() as usize - base) % 64, 0);
            for pair in layout.table.windows(2) {
                prop_assert!(pair[0].offset + pair[0].length <= pair[1].offset && pair[1].offset % 64 == 0);
            }
            // Padding and tail are zeroed, sections are left alone.
            let sum: u64 = layout.table.iter().map(|entry| entry.length).sum();
            let bytes: &[u8] = bytemuck::cast_slice(&payload);
            let touched = bytes[TABLE_BYTES..].iter().filter(|byte| **byte == 0xaa).count();
            prop_assert_eq!(touched as u64, sum);
        }
    }
}
