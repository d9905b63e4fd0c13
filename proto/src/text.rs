//! Short texts in fixed bytes: the bytes, and how many of them count.

/// Writes `text` into `bytes`, cut at a character boundary if it is too long, the rest zeroed; returns the length.
pub(crate) fn put(bytes: &mut [u8], text: &str) -> u32 {
    let mut length = text.len().min(bytes.len());
    while !text.is_char_boundary(length) {
        length -= 1;
    }
    bytes.fill(0);
    bytes[..length].copy_from_slice(&text.as_bytes()[..length]);
    length as u32
}

/// Reads a text back; `None` if the length exceeds the room or the bytes are not UTF-8.
pub(crate) fn get(bytes: &[u8], length: u32) -> Option<&str> {
    std::str::from_utf8(bytes.get(..length as usize)?).ok()
}

/// Like [`get`], for texts that are only shown: whatever cannot be read becomes a replacement character.
pub(crate) fn show(bytes: &[u8], length: u32) -> String {
    String::from_utf8_lossy(&bytes[..(length as usize).min(bytes.len())]).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut_between_characters() {
        let mut bytes = [1u8; 5];
        let length = put(&mut bytes, "aßßß");
        assert_eq!(get(&bytes, length), Some("aßß"));
        let length = put(&mut bytes, "ßßß");
        assert_eq!((length, get(&bytes, length), bytes[4]), (4, Some("ßß"), 0));
    }

    #[test]
    fn lengths_beyond_the_room_are_refused() {
        assert_eq!(get(&[b'a'; 4], 5), None);
        assert_eq!(get(&[0xff; 4], 2), None);
        assert_eq!(show(&[b'a'; 4], 9), "aaaa");
    }
}
