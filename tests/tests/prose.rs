//! Words and constructions that the prose of this project does not use: comments, documents and messages.
//!
//! The list holds figures of speech and sentence forms that readers had to read twice, each with the words to use instead.

use shatter_tests::prose::{Kind, Passage, passages, words};
use shatter_tests::sources::check;

/// Phrases and their replacements. A phrase matches whole words, in any case.
const BANNED: [(&str, &str); 41] = [
    ("a blow", "an impact"),
    ("answer", "a result, a response"),
    ("are had", "name the actor and the action"),
    ("are told", "name the actor and the action"),
    ("blow", "impact"),
    ("blows", "impacts"),
    ("buried", "removed"),
    ("bury", "remove"),
    ("crew", "worker pool"),
    ("for ever", "without end, or a bound"),
    ("gives back", "returns, releases"),
    ("given back", "returned, released"),
    ("is had", "name the actor and the action"),
    ("is told", "name the actor and the action"),
    ("mislaid", "evicted"),
    ("nobody", "no client, no thread"),
    ("nothing but", "only"),
    ("orphan", "a segment without an owner"),
    ("orphans", "segments without an owner"),
    ("reckon", "count, compute"),
    ("reckoned", "counted, computed"),
    ("refusal", "error"),
    ("refusals", "errors"),
    ("spoil", "damage"),
    ("spoiled", "damaged"),
    ("spoils", "damages"),
    ("spoilt", "damaged"),
    ("taken in", "accepted"),
    ("takes in", "accepts"),
    ("that is none", "name the defect"),
    ("that which", "name the thing"),
    ("the dead", "dead clients, dead daemons"),
    ("the house", "the test's folder"),
    ("those who", "name the actor"),
    ("what is asked", "the request"),
    ("what is off", "a disabled effect"),
    ("what is on", "an enabled effect"),
    ("what is said", "the text"),
    ("what is there", "name the thing"),
    ("what is wanted", "the request"),
    ("whoever", "name the actor"),
];

/// Words before `strike` that make it a noun.
const ARTICLES: [&str; 10] = ["a", "another", "each", "every", "first", "one", "per", "second", "the", "this"];

/// Words that no documentation of an item begins with: its first line is a noun phrase or a verb.
const BEGINNINGS: [&str; 5] = ["how", "what", "where", "who", "whose"];

/// Longest sentence of a document, in words, that is not counted as long.
const SENTENCE_WORDS: usize = 25;

/// The word or construction of a passage that is not used here, and its replacement.
fn finding(passage: &Passage) -> Option<(String, &'static str)> {
    let words = words(&passage.text);
    for (phrase, instead) in BANNED {
        let phrase: Vec<&str> = phrase.split(' ').collect();
        if words.windows(phrase.len()).any(|window| window == phrase) {
            return Some((phrase.join(" "), instead));
        }
    }
    let noun = words.windows(2).find(|pair| pair[1] == "strike" && ARTICLES.contains(&pair[0].as_str()));
    if let Some(pair) = noun {
        return Some((pair.join(" "), "request, impact; strike is a verb"));
    }
    let begins =
        passage.kind == Kind::FirstDocLine && words.first().is_some_and(|word| BEGINNINGS.contains(&word.as_str()));
    begins.then(|| (words[0].clone(), "begin with a noun phrase or a verb"))
}

#[test]
fn prose_uses_standard_words() {
    let found = passages().into_iter().filter_map(|passage| {
        finding(&passage).map(|(phrase, instead)| {
            format!("{}:{}: \"{phrase}\" (say: {instead}): {}", passage.file, passage.line, passage.text.trim())
        })
    });
    check("prose is plain: CONTRIBUTING.md", found.collect());
}

#[test]
fn figures_of_speech_are_found() {
    let passage = |kind, text: &str| Passage { file: String::new(), line: 1, kind, text: text.to_owned() };
    for text in ["Nobody waits.", "The strike ends.", "An answer, read.", "Gives back the rest"] {
        assert!(finding(&passage(Kind::Text, text)).is_some(), "{text}");
    }
    assert!(finding(&passage(Kind::FirstDocLine, "What an object costs.")).is_some());
    for text in
        ["Clients strike objects.", "The result of a request.", "Answering is not a noun.", "What an object costs."]
    {
        assert!(finding(&passage(Kind::Text, text)).is_none(), "{text}");
    }
}

/// Prints, and does not judge: a long sentence may be the clearest one.
#[test]
fn long_sentences_are_shown() {
    let mut long = 0;
    for passage in passages().into_iter().filter(|passage| passage.kind == Kind::Document) {
        for sentence in passage.text.split(['.', ':', ';', '|']).filter(|text| words(text).len() > SENTENCE_WORDS) {
            println!(
                "warning: {}:{}: {} words: {}",
                passage.file,
                passage.line,
                words(sentence).len(),
                sentence.trim()
            );
            long += 1;
        }
    }
    println!("{long} sentences of documents have more than {SENTENCE_WORDS} words");
}
