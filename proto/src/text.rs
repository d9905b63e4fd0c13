//! Texts: short ones in fixed bytes with a length, and any text escaped for showing.

use std::fmt::Write;

/// Most characters of a text from a file or a name that a message quotes.
pub const QUOTED_MAX: usize = 200;

/// Most characters of a message.
pub const MESSAGE_MAX: usize = 4000;

/// A message as a terminal or a log may show it: every character that moves the cursor, starts an escape sequence or changes the
/// direction of writing is escaped, and at most [`MESSAGE_MAX`] characters are left.
pub fn message(text: &str) -> String {
    shown(text, MESSAGE_MAX)
}

/// As [`message`], for a text from a file or a name: at most [`QUOTED_MAX`] characters are left.
pub fn quoted(text: &str) -> String {
    shown(text, QUOTED_MAX)
}

/// As [`message`], of any length.
pub fn escaped(text: &str) -> String {
    shown(text, usize::MAX)
}

/// A number of things of this name, such as "1 object" and "2 objects".
pub fn counted(number: u64, name: &str) -> String {
    if number == 1 { format!("1 {name}") } else { format!("{number} {name}s") }
}

/// A number as a message shows it: in exponent form if it is below 1e-4 or above 1e9, and not 0.
pub fn number(value: f64) -> String {
    let is_long = value != 0.0 && !(1e-4..=1e9).contains(&value.abs());
    if is_long { format!("{value:e}") } else { value.to_string() }
}

/// Decimal texts of lengths or coordinates, separated by commas: six decimals, or more where all values are below 0.1.
pub fn fixed(values: &[f64]) -> String {
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let more = if largest > 0.0 && largest < 0.1 { (-largest.log10()).ceil() as usize } else { 0 };
    let texts = values.iter().map(|value| format!("{value:.*}", (6 + more).min(30)));
    texts.collect::<Vec<_>>().join(",")
}

fn shown(text: &str, most: usize) -> String {
    let mut shown = String::with_capacity(text.len().min(most.saturating_mul(4)));
    let mut count = 0;
    for character in text.chars() {
        let before = shown.len();
        if is_invisible(character) {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
        count += shown[before..].chars().count();
        if count > most {
            shown.truncate(before);
            // Writing to a string cannot fail.
            let _ = write!(shown, "… ({} bytes)", text.len());
            break;
        }
    }
    shown
}

/// Control characters, line and paragraph separators, marks that change the direction of writing, and other format characters
/// without a sign: names may not hold them, messages escape them. `shatter-fracture` does not know this crate and has the same table; a
/// test of `shatter-engine` compares them.
///
/// Source: general category Cf of the Unicode Character Database 16.0, without the signs that are drawn.
pub fn is_invisible(character: char) -> bool {
    let format = matches!(
        character,
        '\u{ad}'
            | '\u{61c}'
            | '\u{180e}'
            | '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}'
            | '\u{fff9}'..='\u{fffb}'
            | '\u{1bca0}'..='\u{1bca3}'
            | '\u{1d173}'..='\u{1d17a}'
            | '\u{e0000}'..='\u{e007f}'
    );
    character.is_control() || format
}

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
    fn shown_texts_hold_no_control_character_and_no_megabytes() {
        assert_eq!(message("Vase Nr. 3: größer"), "Vase Nr. 3: größer");
        assert_eq!(quoted("a\u{1b}[31mb\nc\u{202e}d\u{9b}"), "a\\u{1b}[31mb\\nc\\u{202e}d\\u{9b}");
        assert_eq!(quoted("a\u{2066}\u{200f}\u{200b}\u{ad}b"), "a\\u{2066}\\u{200f}\\u{200b}\\u{ad}b");
        let long = quoted(&"ü".repeat(5_000_000));
        assert!(long.starts_with(&"ü".repeat(QUOTED_MAX)) && long.ends_with("… (10000000 bytes)"), "{long}");
        let escaped = quoted(&"\n".repeat(150));
        assert!(escaped.chars().count() < QUOTED_MAX + 20 && escaped.ends_with("bytes)"), "{escaped}");
        assert_eq!(message(&message("\u{7}")), message("\u{7}"));
    }

    #[test]
    fn very_small_and_very_large_numbers_have_an_exponent() {
        for (value, wanted) in [
            (0.0, "0"),
            (7.5, "7.5"),
            (-0.0001, "-0.0001"),
            (1e9, "1000000000"),
            (5e-324, "5e-324"),
            (-1e308, "-1e308"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), wanted);
        }
    }

    #[test]
    fn long_texts_are_cut_between_characters() {
        let mut bytes = [1u8; 5];
        let length = put(&mut bytes, "aßßß");
        assert_eq!(get(&bytes, length), Some("aßß"));
        let length = put(&mut bytes, "ßßß");
        assert_eq!((length, get(&bytes, length), bytes[4]), (4, Some("ßß"), 0));
    }

    #[test]
    fn lengths_beyond_the_buffer_are_rejected() {
        assert_eq!(get(&[b'a'; 4], 5), None);
        assert_eq!(get(&[0xff; 4], 2), None);
        assert_eq!(show(&[b'a'; 4], 9), "aaaa");
    }
}
