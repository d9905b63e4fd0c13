//! Mutations without coverage, for every test run.

use shatter_fracture::random::RandomStream;

/// Words that do harm if they are trusted: zeros, ones, signs, infinities, not-a-numbers, lengths, large counts.
const WORDS: [u64; 12] = [
    0,
    1,
    u64::MAX,
    1 << 63,
    0x7ff0_0000_0000_0000,
    0xfff0_0000_0000_0000,
    0x7ff8_0000_0000_0001,
    0x3ff0_0000_0000_0000,
    64,
    0x0000_0040_0000_0040,
    0x7fff_ffff_7fff_ffff,
    0x7fef_ffff_ffff_ffff,
];

/// Pieces of text with a meaning in some format.
const TEXTS: [&str; 16] = [
    "\n",
    "-",
    "nan",
    "inf",
    "1e308",
    "1e-320",
    "-0",
    "18446744073709551615",
    "-1",
    "[[",
    "\"\"",
    "\u{feff}",
    "\0",
    " ",
    "=",
    "/",
];

/// `input` with one to four changes, which `number` determines; parts of `other` may be inserted.
pub fn mutated(input: &[u8], other: &[u8], number: u64) -> Vec<u8> {
    let mut stream = RandomStream::new(22, number);
    let mut below = move |end: usize| if end == 0 { 0 } else { (stream.bits() % end as u64) as usize };
    let mut bytes = input.to_vec();
    for _ in 0..=below(4) {
        let at = below(bytes.len());
        let end = (at + 1 + below(24)).min(bytes.len());
        match below(7) {
            0 if at < end => bytes[at] ^= 1 << below(8),
            1 if at < end => bytes[at] = below(256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => bytes.splice(at..at, bytes[at..end].to_vec()).for_each(drop),
            4 => bytes.splice(at..end, TEXTS[below(TEXTS.len())].bytes()).for_each(drop),
            5 => {
                let first = below(other.len());
                let last = (first + below(64)).min(other.len());
                bytes.splice(at..end, other[first..last].iter().copied()).for_each(drop);
            }
            _ => {
                let word = WORDS[below(WORDS.len())].to_le_bytes();
                let width = 8.min(bytes.len() - at);
                bytes[at..at + width].copy_from_slice(&word[..width]);
            }
        }
    }
    bytes
}
