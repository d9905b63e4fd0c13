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

/// The name in `all` nearest to `name`; the first of several.
///
/// Names of which one is a prefix of the other are nearest. Others are ordered by edit distance (F. J. Damerau 1964, V.
/// I. Levenshtein 1966).
pub fn nearest<'a>(name: &str, all: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // The cost of the distance is quadratic in the length.
    let name = brief(name);
    let begins = |one: &str, other: &str| one.len() >= PREFIX_MIN && other.starts_with(one);
    let distance =
        |known: &str| (!(begins(&name, known) || begins(known, &name)), strsim::damerau_levenshtein(&name, known));
    all.into_iter().min_by_key(|known| distance(known))
}

/// One-line description of an error in the TOML `text`: position, cause, and the nearest known key to an unknown one.
///
/// Does not quote the text. For a table parsed before, pass an empty text; the key then replaces the position.
pub fn toml_error(text: &str, error: &toml::de::Error) -> String {
    let place = error.span().and_then(|span| text.get(..span.start)).map_or_else(String::new, |before| {
        let column = before.rsplit('\n').next().map_or(0, |line| line.chars().count()) + 1;
        format!("line {}, column {column}: ", before.matches('\n').count() + 1)
    });
    // Without a text, the error still has the key and prints it on a separate line.
    let shown = error.to_string();
    let key = shown.lines().filter(|_| place.is_empty()).find_map(|line| line.strip_prefix("in `")?.strip_suffix('`'));
    let key = key.map_or_else(String::new, |key| format!(" (key `{}`)", brief(key)));
    let message = error.message();
    let mut names = message.split('`').skip(1).step_by(2);
    let hint = match names.next() {
        Some(unknown) if message.starts_with("unknown field") => nearest(unknown, names),
        _ => None,
    };
    let hint = hint.map_or_else(String::new, |nearest| format!("; the nearest is `{nearest}`"));
    format!("{place}{}{key}{hint}", brief(&message.split_whitespace().collect::<Vec<_>>().join(" ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_suggestion_may_extend_the_given_prefix() {
        let keys = ["fragment_size_m", "gamma_j_m2", "gravity_m_s2", "lift"];
        assert_eq!(nearest("gravity", keys), Some("gravity_m_s2"));
        assert_eq!(nearest("fragment_size", keys), Some("fragment_size_m"));
        assert_eq!(nearest("gama_j_m2", keys), Some("gamma_j_m2"));
        assert_eq!(nearest("lif", keys), Some("lift"));
        assert_eq!(nearest("x", []), None);
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
            let message = toml_error(&text, &error);
            assert!(message.starts_with("line ") && message.len() < 600 && !message.contains('\n'), "{message}");
        }
        let text = "gravity = 9.81\n";
        let message = toml_error(text, &toml::from_str::<Own>(text).unwrap_err());
        assert!(
            message.starts_with("line 1, column 1: ") && message.ends_with("the nearest is `gravity_m_s2`"),
            "{message}"
        );
    }
}
