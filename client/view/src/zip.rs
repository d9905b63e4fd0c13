//! Files in one archive, without compression (APPNOTE 6.3.10, PKWARE).

/// One file of an archive.
struct Entry {
    name: String,
    checksum: u32,
    length: u32,
    offset: u32,
}

/// An archive under construction.
#[derive(Default)]
pub(crate) struct ZipArchive {
    bytes: Vec<u8>,
    entries: Vec<Entry>,
}

/// Flag for names in UTF-8.
const UTF8: u16 = 1 << 11;

/// Date of all files, 1980-01-01: equal files make equal archives.
const DATE: u16 = 0x21;

impl ZipArchive {
    /// Adds a file. False, and nothing is added, beyond 4 GiB.
    pub fn add(&mut self, name: &str, contents: &[u8]) -> bool {
        let (Ok(length), Ok(offset)) = (u32::try_from(contents.len()), u32::try_from(self.bytes.len())) else {
            return false;
        };
        let entry = Entry { name: name.to_owned(), checksum: checksum(contents), length, offset };
        self.bytes.extend(0x0403_4b50_u32.to_le_bytes());
        self.bytes.extend(20_u16.to_le_bytes());
        self.bytes.extend(entry.fields());
        self.bytes.extend(0_u16.to_le_bytes());
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(contents);
        self.entries.push(entry);
        true
    }

    /// The archive.
    pub fn finish(mut self) -> Vec<u8> {
        let first = self.bytes.len() as u32;
        for entry in &self.entries {
            self.bytes.extend(0x0201_4b50_u32.to_le_bytes());
            self.bytes.extend([20_u16, 20].map(u16::to_le_bytes).as_flattened());
            self.bytes.extend(entry.fields());
            // No extra field, comment, disk, attributes.
            self.bytes.extend([0; 12]);
            self.bytes.extend(entry.offset.to_le_bytes());
            self.bytes.extend(entry.name.as_bytes());
        }
        let length = self.bytes.len() as u32 - first;
        let count = self.entries.len() as u16;
        self.bytes.extend(0x0605_4b50_u32.to_le_bytes());
        self.bytes.extend([0, 0, count, count].map(u16::to_le_bytes).as_flattened());
        self.bytes.extend([length, first].map(u32::to_le_bytes).as_flattened());
        self.bytes.extend([0; 2]);
        self.bytes
    }
}

impl Entry {
    /// Fields that both headers of a file share: flags to the length of the name.
    fn fields(&self) -> Vec<u8> {
        let mut fields = [UTF8, 0, 0, DATE].map(u16::to_le_bytes).as_flattened().to_vec();
        fields.extend([self.checksum, self.length, self.length].map(u32::to_le_bytes).as_flattened());
        fields.extend((self.name.len() as u16).to_le_bytes());
        fields
    }
}

/// CRC-32 of ISO 3309.
fn checksum(bytes: &[u8]) -> u32 {
    let table: [u32; 256] = std::array::from_fn(|byte| {
        (0..8).fold(byte as u32, |value, _| if value & 1 == 1 { (value >> 1) ^ 0xedb8_8320 } else { value >> 1 })
    });
    !bytes.iter().fold(u32::MAX, |value, byte| (value >> 8) ^ table[((value ^ u32::from(*byte)) & 0xff) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn an_archive_ends_with_its_directory() {
        let mut archive = ZipArchive::default();
        assert!(archive.add("a.txt", b"abc") && archive.add("b/c.txt", b""));
        let bytes = archive.finish();
        let end = &bytes[bytes.len() - 22..];
        assert_eq!((&end[..4], end[10]), (&b"PK\x05\x06"[..], 2));
        let first = u32::from_le_bytes(end[16..20].try_into().unwrap()) as usize;
        assert_eq!(&bytes[first..first + 4], b"PK\x01\x02");
    }
}
