//! Nearest known names, invisible characters, and errors in TOML texts.

/// Largest number of characters that an error quotes from a file.
const QUOTED_MAX: usize = 200;

/// Smallest length of a name that counts as a prefix of others.
const PREFIX_MIN: usize = 3;

/// `text` if it is short, else its beginning and its length in bytes.
pub fn brief(text: &str) -> String {
    match text.char_indices().nth(QUOTED_MAX) {
        Some((end, _)) => format!("{}… ({} bytes)", &text[..end], text.len()),
        None => text.to_owned(),
    }
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

/// A measured number as a message shows it: with four decimals, or in exponent form if it is very small or large.
pub fn rounded(value: f64) -> String {
    let is_long = value != 0.0 && !(1e-4..=1e9).contains(&value.abs());
    if is_long { format!("{value:.3e}") } else { format!("{value:.4}") }
}

/// Decimal texts of lengths or coordinates, m, separated by commas: micrometers, or finer where all are below 0.1.
pub fn fixed(values: &[f64]) -> String {
    let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let more = if largest > 0.0 && largest < 0.1 { (-largest.log10()).ceil() as usize } else { 0 };
    let texts = values.iter().map(|value| format!("{value:.*}", (6 + more).min(30)));
    texts.collect::<Vec<_>>().join(",")
}

/// True for characters without a visible sign, which names of objects must not contain.
///
/// These are control characters, line and paragraph separators, marks of the writing direction, and other invisible
/// format characters. `shatter-proto` has the same table; a test of `shatter-engine` compares them.
///
/// Source: general category Cf of the Unicode Character Database 16.0, without the characters that have a glyph.
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

/// The name in `all` nearest to `name`, the first of several; `None` if none is similar.
///
/// Names of which one is a prefix of the other are nearest. Others are ordered by edit distance (F. J. Damerau 1964, V.
/// I. Levenshtein 1966), which must be at most one more than a third of the longer
/// name, and at most half of it, as in `shatter-proto`.
pub fn nearest<'a>(name: &str, all: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // The cost of the distance is quadratic in the length.
    let name = brief(name);
    let begins = |one: &str, other: &str| one.len() >= PREFIX_MIN && other.starts_with(one);
    let length = name.chars().count();
    let distance = |known: &str| match begins(&name, known) || begins(known, &name) {
        true => 0,
        false => strsim::damerau_levenshtein(&name, known),
    };
    let limit = |longer: usize| (1 + longer / 3).min(longer / 2);
    let similar = |known: &&str| distance(known) <= limit(known.chars().count().max(length));
    all.into_iter().filter(similar).min_by_key(|known| distance(known))
}

/// One-line description of an error in the TOML `text`: position, cause in plain words, and the nearest known key to an unknown one.
///
/// Quotes no more than the offending value. `ranges` as in [`table_error`].
pub fn toml_error(text: &str, error: &toml::de::Error, ranges: &[(&str, &str)]) -> String {
    let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
    let line = before.rsplit('\n').next().unwrap_or_default();
    let place = format!("line {}, column {}", before.matches('\n').count() + 1, line.chars().count() + 1);
    let found_and_wanted = match error.message() {
        TOO_LARGE => {
            Some((brief(error.span().and_then(|span| text.get(span)).unwrap_or_default()), NUMBERS.to_owned()))
        }
        message => mismatch(message),
    };
    match found_and_wanted {
        Some((found, wanted)) => {
            let key = key_before(line);
            let range = key.and_then(|key| range_of(&path_in(before, key), ranges)).map(str::to_owned);
            let key = key.map_or("the value".to_owned(), |key| format!("`{}`", brief(key)));
            format!("{place}: {key} is {found}; it must be {}", range.unwrap_or(wanted))
        }
        None => format!("{place}: {}", cause(error)),
    }
}

/// Message of the parser for a whole number that TOML cannot hold, although 64 bits can.
const TOO_LARGE: &str = "u64 value was too large";

/// The numbers that TOML can hold.
const NUMBERS: &str =
    "a whole number from -9223372036854775808 to 9223372036854775807, or one with a decimal point or an exponent";

/// The key of a value that begins after `line`: it stands before the equals sign, in an inline table after a brace or a comma.
fn key_before(line: &str) -> Option<&str> {
    let key = line.rsplit_once('=').and_then(|(left, _)| left.rsplit(['{', ',']).next()).map(str::trim);
    key.filter(|key| !key.is_empty())
}

/// `key` with the path of the table whose header is the last in the text `before`.
fn path_in(before: &str, key: &str) -> String {
    let mut headers = before.lines().rev().map(str::trim);
    let header = headers.find(|line| line.starts_with('[')).map_or("", |line| line.trim_matches(['[', ']']));
    if header.is_empty() { key.to_owned() } else { format!("{header}.{key}") }
}

/// The possible values of the key at `path`, whose last parts are a key of `ranges`.
fn range_of<'a>(path: &str, ranges: &[(&str, &'a str)]) -> Option<&'a str> {
    let is_end = |own: &str| path.strip_suffix(own).is_some_and(|left| left.is_empty() || left.ends_with('.'));
    ranges.iter().find(|(own, _)| is_end(own)).map(|(_, range)| *range)
}

/// Offending key and one-line description of an error in the values of a TOML table that was parsed before.
///
/// `table` is the path of the table, empty for the whole file; `ranges` hold the possible values of keys, in words. Other values
/// are described by their types.
pub fn table_error(table: &str, error: &toml::de::Error, ranges: &[(&str, &str)]) -> (String, String) {
    // Without a text, the error prints its key on a separate line.
    let shown = error.to_string();
    let key = shown.lines().find_map(|line| line.strip_prefix("in `")?.strip_suffix('`')).unwrap_or_default();
    let path = match (table, key) {
        (table, "") => table.to_owned(),
        ("", key) => brief(key),
        (table, key) => format!("{table}.{}", brief(key)),
    };
    let range = ranges.iter().find(|(own, _)| *own == key).map(|(_, range)| (*range).to_owned());
    let message = match mismatch(error.message()) {
        Some((found, wanted)) => format!("`{path}` is {found}; it must be {}", range.unwrap_or(wanted)),
        None => format!("`{path}`: {}", cause(error)),
    };
    (path, message)
}

/// The parser's cause of an error in one line, with the nearest known key to an unknown one.
fn cause(error: &toml::de::Error) -> String {
    let message = error.message();
    let mut names = message.split('`').skip(1).step_by(2);
    let hint = match names.next() {
        Some(unknown) if message.starts_with("unknown field") => nearest(unknown, names),
        _ => None,
    };
    let hint = hint.map_or_else(String::new, |nearest| format!("; the nearest is `{nearest}`"));
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let line = line.replace("unknown field", "unknown key").replace("missing field", "missing key");
    format!("{}{hint}", brief(line.trim_end_matches(", expected nothing")))
}

/// The value that was found and the values that are possible, in plain words; `None` for errors of another kind.
fn mismatch(message: &str) -> Option<(String, String)> {
    let (found, wanted) = message.rsplit_once(", expected ")?;
    let beginnings = ["invalid value: ", "invalid type: ", "unknown variant "];
    let found = match (beginnings.iter().find_map(|beginning| found.strip_prefix(beginning)), found) {
        (Some("sequence"), _) => "a list".to_owned(),
        (Some("map"), _) => "a table".to_owned(),
        (Some(text), _) if text.starts_with("string ") => brief(text.trim_start_matches("string ")),
        (Some(text), _) => text.split('`').nth(1).unwrap_or(text).to_owned(),
        (None, found) => format!("a list of {} values", found.strip_prefix("invalid length ")?),
    };
    // The parser writes all digits of a number such as 1e300.
    let long = found.parse::<f64>().ok().filter(|_| found.contains('.'));
    Some((long.map_or_else(|| brief(&found), number), possible(wanted)))
}

/// The values of a type that the parser names, in plain words.
fn possible(wanted: &str) -> String {
    let whole =
        |low: &dyn std::fmt::Display, high: &dyn std::fmt::Display| format!("a whole number from {low} to {high}");
    match wanted {
        "u16" => whole(&u16::MIN, &u16::MAX),
        "u32" => whole(&u32::MIN, &u32::MAX),
        "i32" => whole(&i32::MIN, &i32::MAX),
        "u64" | "usize" => "a whole number, 0 or more".to_owned(),
        // An integer that no type of TOML holds.
        "i64" => whole(&i64::MIN, &i64::MAX),
        "any valid TOML value" => NUMBERS.to_owned(),
        "f64" => "a number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        "path string" => "a path in quotes".to_owned(),
        "string or table" => "a string".to_owned(),
        _ if wanted == "a map" || wanted.starts_with("struct ") => "a table".to_owned(),
        _ => match wanted.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} numbers"),
            None => wanted.to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_lengths_keep_their_digits() {
        assert_eq!(fixed(&[0.1, -0.25, 0.0]), "0.100000,-0.250000,0.000000");
        assert_eq!(fixed(&[4.25e-6, 0.0]), "0.000004250000,0.000000000000");
        assert_eq!(fixed(&[0.0]), "0.000000");
    }

    #[test]
    fn a_suggestion_may_extend_the_given_prefix() {
        let keys = ["fragment_size_m", "gamma_j_m2", "gravity_m_s2", "lift"];
        assert_eq!(nearest("gravity", keys), Some("gravity_m_s2"));
        assert_eq!(nearest("fragment_size", keys), Some("fragment_size_m"));
        assert_eq!(nearest("gama_j_m2", keys), Some("gamma_j_m2"));
        assert_eq!(nearest("lif", keys), Some("lift"));
        assert_eq!(nearest("x", []), None);
        assert_eq!(nearest("dog", ["mug", "vase"]), None, "one common letter of three is no typing error");
        assert_eq!(nearest("oak", ["glass", "ice", "stone"]), None, "no other name is like it");
    }

    #[test]
    fn values_of_the_wrong_type_or_range_are_described_in_plain_words() {
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code, reason = "only their types count")]
        struct Own {
            port: Option<u16>,
            nice: Option<i32>,
            count: Option<usize>,
            size: Option<f64>,
            name: Option<String>,
            on: Option<bool>,
            names: Option<Vec<String>>,
            center: Option<[f64; 3]>,
            inner: Option<Inner>,
            format: Option<Format>,
        }
        #[derive(Debug, serde::Deserialize)]
        #[expect(dead_code, reason = "only its name counts")]
        struct Inner {
            ratio: f64,
        }
        #[derive(Debug, serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        enum Format {
            Text,
            Json,
        }
        let ranges = [("count", "a whole number from 1 to 8")];
        for (text, own, wanted) in [
            (
                "port = 80000",
                "`t.port` is 80000; it must be a whole number from 0 to 65535",
                "`port` is 80000; it must",
            ),
            (
                "nice = 2.5",
                "`t.nice` is 2.5; it must be a whole number from -2147483648 to 2147483647",
                "`nice` is 2.5",
            ),
            (
                "count = -1",
                "`t.count` is -1; it must be a whole number from 1 to 8",
                "must be a whole number, 0 or more",
            ),
            ("count = 1e300", "`t.count` is 1e300; it must be a whole number from 1 to 8", "`count` is 1e300; it must"),
            ("name = 1e-300", "`t.name` is 1e-300; it must be a string", "`name` is 1e-300; it must"),
            ("size = \"large, expected\"", "`t.size` is \"large, expected\"; it must be a number", "`size` is \"large"),
            ("name = 3", "`t.name` is 3; it must be a string", "`name` is 3; it must be a string"),
            ("on = 1", "`t.on` is 1; it must be true or false", "`on` is 1"),
            ("names = \"a\"", "`t.names` is \"a\"; it must be a list", "`names` is \"a\""),
            (
                "center = [1, 2]",
                "`t.center` is a list of 2 values; it must be a list of 3 numbers",
                "is a list of 2 values",
            ),
            ("inner = 3", "`t.inner` is 3; it must be a table", "`inner` is 3"),
            ("inner = { ratio = true }", "`t.inner.ratio` is true; it must be a number", "`ratio` is true; it must be"),
            ("inner = {}", "`t.inner`: missing key `ratio`", "missing key `ratio`"),
            ("format = \"xml\"", "`t.format` is xml; it must be `text` or `json`", "`format` is xml"),
        ] {
            let table: toml::Table = text.parse().unwrap();
            let error = toml::Value::Table(table).try_into::<Own>().unwrap_err();
            let (key, message) = table_error("t", &error, &ranges);
            assert!(message == own && message.contains(&format!("`{key}`")), "{text}: {key}: {message}");
            let message = toml_error(text, &toml::from_str::<Own>(text).unwrap_err(), &[]);
            assert!(message.starts_with("line 1, column ") && message.contains(wanted), "{text}: {message}");
        }
        let message = toml_error("count = 08", &"count = 08".parse::<toml::Table>().unwrap_err(), &[]);
        assert!(!message.contains("nothing"), "{message}");
    }

    #[test]
    fn numbers_that_toml_cannot_hold_are_named_with_their_key_and_range() {
        let ranges = [("count", "a whole number from 1 to 8"), ("b.size", "a number from 1 to 2")];
        let message = |text: &str| toml_error(text, &text.parse::<toml::Table>().unwrap_err(), &ranges);
        for number in ["9223372036854775808", "18446744073709551615", "99999999999999999999"] {
            for (text, wanted) in [
                (
                    format!("[a]\ncount = {number}"),
                    format!("line 2, column 9: `count` is {number}; it must be a whole number from 1 to 8"),
                ),
                (
                    format!("a = {{ count = {number} }}"),
                    format!("line 1, column 15: `count` is {number}; it must be a whole number from 1 to 8"),
                ),
                (
                    format!("[a]\n\n[b]\nsize = {number}"),
                    format!("line 4, column 8: `size` is {number}; it must be a number from 1 to 2"),
                ),
                (
                    format!("[a]\nsize = {number}"),
                    format!("line 2, column 8: `size` is {number}; it must be {NUMBERS}"),
                ),
                (
                    format!("account = {number}"),
                    format!("line 1, column 11: `account` is {number}; it must be {NUMBERS}"),
                ),
            ] {
                assert_eq!(message(&text), wanted);
            }
        }
    }

    #[test]
    fn errors_of_toml_name_their_place_and_do_not_quote_the_line() {
        #[derive(Debug, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Own {
            #[expect(dead_code, reason = "only its name counts")]
            gravity_m_s2: f64,
        }
        let long = "x".repeat(5_000_000);
        for text in [format!("a = 1\nb = {long} y\n"), format!("{long} = 1"), format!("gravity_m_s2 = \"{long}\"")] {
            let error = toml::from_str::<Own>(&text).unwrap_err();
            let message = toml_error(&text, &error, &[]);
            assert!(message.starts_with("line ") && message.len() < 600 && !message.contains('\n'), "{message}");
        }
        let text = "gravity = 9.81\n";
        let message = toml_error(text, &toml::from_str::<Own>(text).unwrap_err(), &[]);
        assert!(
            message.starts_with("line 1, column 1: ") && message.ends_with("the nearest is `gravity_m_s2`"),
            "{message}"
        );
    }
}
