//! Parsing of arguments, and the messages of usage errors.

use super::lab::CALLED_AS;
use super::{mistakes, whole_number_wanted};
use clap::error::{self, ContextKind, ContextValue};
use clap::{Command, CommandFactory, FromArgMatches};
use shatter_proto::text::quoted;
use std::any::TypeId;
use std::ffi::OsString;

/// Parses the arguments of this process as `C`.
///
/// # Errors
/// A usage error that names the nearest option or the reason why a number is refused; or the help that was requested.
pub fn arguments<C: CommandFactory + FromArgMatches>() -> Result<C, clap::Error> {
    parsed(std::env::args_os().collect())
}

/// The command line of `C`, under the name of the program that passed its arguments on, if there is one.
fn command<C: CommandFactory>() -> Command {
    let command = C::command();
    match std::env::var(CALLED_AS).as_deref() {
        Ok("shatter") => command.name("shatter").bin_name("shatter"),
        Ok("shatterd") => command.name("shatterd").bin_name("shatterd"),
        _ => command,
    }
}

fn parsed<C: CommandFactory + FromArgMatches>(words: Vec<OsString>) -> Result<C, clap::Error> {
    let mut command = takes_negative_numbers(command::<C>());
    // Build it completely, so that messages can name every command with its program.
    command.build();
    let matches = command.try_get_matches_from_mut(&words).map_err(|error| cut(explained(error, &command, &words)))?;
    C::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// Treats a negative number after an option as its value: it is refused for its value, not as an unknown option.
fn takes_negative_numbers(command: Command) -> Command {
    let with_value = |arg: clap::Arg| {
        let plain = arg.is_positional() || !arg.get_action().takes_values() || arg.is_allow_hyphen_values_set();
        if plain { arg } else { arg.allow_negative_numbers(true) }
    };
    command.mut_args(with_value).mut_subcommands(takes_negative_numbers)
}

/// `error` with the words of the command line as a message may show them.
fn cut(mut error: clap::Error) -> clap::Error {
    for kind in [ContextKind::InvalidArg, ContextKind::InvalidValue, ContextKind::InvalidSubcommand] {
        if let Some(shown) = text(&error, kind).map(quoted) {
            error.insert(kind, ContextValue::String(shown));
        }
    }
    error
}

/// `error` with the reason that the parser omits, or with a suggestion.
fn explained(mut error: clap::Error, command: &Command, words: &[OsString]) -> clap::Error {
    let tip = match error.kind() {
        error::ErrorKind::UnknownArgument => unknown(&mut error, command, words),
        error::ErrorKind::InvalidSubcommand => not_a_command(&mut error, command, words),
        error::ErrorKind::MissingRequiredArgument => match error.get(ContextKind::InvalidArg) {
            Some(ContextValue::Strings(names)) => mistakes::missing(names).map(str::to_owned),
            _ => None,
        },
        error::ErrorKind::ValueValidation => return reworded(error, command, used(command, words)),
        _ => None,
    };
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Options whose value is a list.
const LISTS: [&str; 2] = ["--enable", "--disable"];

/// Suggestion for an argument that the command does not have.
fn unknown(error: &mut clap::Error, command: &Command, words: &[OsString]) -> Option<String> {
    let word = text(error, ContextKind::InvalidArg)?.to_owned();
    // The parser's own suggestion is the most similar option, however little it resembles the word.
    error.remove(ContextKind::Suggested);
    error.remove(ContextKind::SuggestedArg);
    let own = used(command, words);
    if word.parse::<f64>().is_ok() {
        return Some("a vector is one word: numbers with commas and without spaces, for example 0.1,0,-0.2".to_owned());
    }
    if !word.starts_with('-') {
        if words.iter().any(|given| LISTS.iter().any(|list| given == list)) {
            return Some(
                "a list is one word: names with commas and without spaces, for example bonds,hulls".to_owned(),
            );
        }
        return Some(match own.get_positionals().count() {
            0 => format!("`{}` takes only options, which begin with --", path(own)),
            _ => format!("`{}` takes no further word; see the usage below", path(own)),
        });
    }
    let flag = word.trim_start_matches('-').split('=').next().unwrap_or_default();
    let known: Vec<&str> = options(own);
    if let Some(tip) = before_command(command, own, &word) {
        return Some(tip);
    }
    if own.has_subcommands() && !own.get_subcommands().all(|sub| sub.get_name() != flag) {
        return Some(mistakes::command(own.get_name(), flag));
    }
    match mistakes::option(flag, &known) {
        Some(likely) => {
            error.insert(ContextKind::SuggestedArg, ContextValue::String(format!("--{likely}")));
            None
        }
        None => {
            let all: Vec<String> = known.iter().map(|name| format!("--{name}")).collect();
            let owner = mistakes::owner(flag, &known);
            let owner = owner.map_or(String::new(), |owner| format!("`--{flag}` is an option of `{owner}`; "));
            Some(format!("{owner}the options of `{}` are {}", path(own), all.join(", ")))
        }
    }
}

/// Suggestion for an option of a command that stands before the command.
fn before_command(command: &Command, own: &Command, word: &str) -> Option<String> {
    let flag = word.split('=').next().unwrap_or_default();
    let has = |own: &Command| options(own).iter().any(|known| flag.strip_prefix("--") == Some(*known));
    let is_found = if own.has_subcommands() { own.get_subcommands().any(has) } else { has(own) };
    let called = if own.has_subcommands() { format!("{} COMMAND", path(command)) } else { path(own).to_owned() };
    is_found.then(|| format!("put `{flag}` after the command: `{called} {flag}`"))
}

/// Suggestion for a word that is not a command.
fn not_a_command(error: &mut clap::Error, command: &Command, words: &[OsString]) -> Option<String> {
    let word = text(error, ContextKind::InvalidSubcommand)?.to_owned();
    error.remove(ContextKind::SuggestedSubcommand);
    error.remove(ContextKind::Suggested);
    let own = used(command, words);
    if own.get_name() == command.get_name() {
        return Some(mistakes::command(command.get_name(), &word));
    }
    let all: Vec<&str> = own
        .get_subcommands()
        .filter(|sub| !sub.is_hide_set())
        .map(Command::get_name)
        .filter(|name| *name != "help")
        .collect();
    Some(format!("the commands of `{}` are {}", path(own), all.join(", ")))
}

/// Explains a number that an option of the command `own` refuses.
fn reworded(error: clap::Error, command: &Command, own: &Command) -> clap::Error {
    let part = |kind| text(&error, kind).unwrap_or_default();
    let why = match source(&error) {
        why if is_whole(&why) => match limits(&why, own, part(ContextKind::InvalidArg)) {
            Some([low, high]) => whole_number_wanted(&low, &high),
            None => "must be a whole number".to_owned(),
        },
        why if why.contains("invalid float literal") && part(ContextKind::InvalidValue).contains(',') => {
            "must be one number, not a vector".to_owned()
        }
        why if why.contains("invalid float literal") && in_meters(part(ContextKind::InvalidArg)) => {
            "must be a number of meters, without a unit".to_owned()
        }
        why if why.contains("invalid float literal") => "must be a number, without a unit".to_owned(),
        _ => return error,
    };
    let (word, value) = (part(ContextKind::InvalidArg), quoted(part(ContextKind::InvalidValue)));
    let message = format!("invalid value '{value}' for '{word}': {why}\n");
    clap::Error::raw(error::ErrorKind::ValueValidation, message).with_cmd(command)
}

/// Smallest and largest number that the option `word` accepts: those of the parser's message `why`, or of its type.
fn limits(why: &str, own: &Command, word: &str) -> Option<[String; 2]> {
    if let Some((low, high)) = why.split_once(" is not in ").and_then(|(_, range)| range.split_once("..=")) {
        return Some([low.to_owned(), high.to_owned()]);
    }
    let name = word.strip_prefix("--")?.split([' ', '=']).next();
    let own = own.get_arguments().find(|arg| arg.get_long() == name)?.get_value_parser().type_id();
    let types = [
        (TypeId::of::<u16>(), u16::MAX.into()),
        (TypeId::of::<u32>(), u32::MAX.into()),
        (TypeId::of::<usize>(), usize::MAX as u64),
        (TypeId::of::<u64>(), u64::MAX),
    ];
    let (_, high) = types.into_iter().find(|(id, _)| own == *id)?;
    Some(["0".to_owned(), high.to_string()])
}

/// True if the option, with the name of its value, takes a length.
fn in_meters(option: &str) -> bool {
    option.ends_with("<M>") || option.contains("-m <")
}

fn text(error: &clap::Error, kind: ContextKind) -> Option<&str> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text),
        _ => None,
    }
}

/// True if the parser expected a whole number of a range.
fn is_whole(why: &str) -> bool {
    ["invalid digit", " is not in ", "too large to fit", "too small to fit"].iter().any(|part| why.contains(part))
}

/// Message of the parser of the value.
fn source(error: &clap::Error) -> String {
    std::error::Error::source(error).map(ToString::to_string).unwrap_or_default()
}

/// The command that `words` name.
fn used<'a>(command: &'a Command, words: &[OsString]) -> &'a Command {
    let called = words.iter().skip(1).filter(|word| **word != "help");
    called.fold(command, |own, word| own.find_subcommand(word).unwrap_or(own))
}

/// Name of a command, with its program.
fn path(command: &Command) -> &str {
    command.get_bin_name().unwrap_or(command.get_name())
}

/// Long names of the options of a command.
fn options(own: &Command) -> Vec<&str> {
    own.get_arguments().filter(|arg| !arg.is_hide_set()).filter_map(clap::Arg::get_long).collect()
}

/// Complete text of a usage error of this process: the error, then usage and help of the command in question.
pub fn usage_text<C: CommandFactory>(error: &clap::Error) -> String {
    text_of(error, command::<C>(), &std::env::args_os().collect::<Vec<_>>())
}

fn text_of(error: &clap::Error, mut command: Command, words: &[OsString]) -> String {
    let text = error.to_string();
    if error.kind() == error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return text;
    }
    // A message of a command itself has no usage of its own.
    let end = end(&text).unwrap_or(text.len());
    command.build();
    let own = used(&command, words);
    // That of the error also names options which have a default or were set by the environment.
    let usage = own.clone().render_usage();
    format!("{}\n\n{usage}\n\nFor more information, try '{} --help'.\n", text[..end].trim_end(), path(own))
}

/// End of the message of an error; `None` for a text without usage.
fn end(text: &str) -> Option<usize> {
    ["\nUsage:", "\nFor more information"].iter().filter_map(|end| text.find(end)).min()
}

/// Message of a usage error in one line, without the usage that follows it.
pub fn usage_message(error: &clap::Error) -> String {
    let text = error.to_string();
    let lines = text[..end(&text).unwrap_or(text.len())].lines().map(str::trim).filter(|line| !line.is_empty());
    lines.collect::<Vec<_>>().join(" ").replace(" tip: ", "; tip: ").trim_start_matches("error: ").to_owned()
}

#[cfg(test)]
mod tests {
    use super::super::whole_number;
    use super::*;
    use clap::Parser;

    /// Arguments of a program.
    #[derive(Parser, Debug)]
    #[command(name = "program")]
    struct Program {
        #[arg(long, global = true, default_value = "default")]
        service: String,
        #[command(subcommand)]
        command: Sub,
    }

    #[derive(clap::Subcommand, Debug)]
    enum Sub {
        /// Strikes.
        Impact {
            #[arg(long)]
            out: Option<String>,
            #[arg(long, default_value_t = 0)]
            seed: u64,
            #[arg(long)]
            clients: Option<u32>,
            #[arg(long)]
            radius_m: Option<f64>,
            #[arg(long, value_parser = whole_number::<u32>(1..=8))]
            examples: Option<u32>,
            #[arg(long)]
            point: Option<String>,
        },
    }

    #[track_caller]
    fn check(words: &[&str], wanted: &str) {
        let words = ["program", "impact"].iter().chain(words).map(OsString::from).collect();
        let words: Vec<OsString> = words;
        let error = parsed::<Program>(words.clone()).unwrap_err();
        let message = usage_message(&error);
        let whole = text_of(&error, Program::command(), &words);
        assert!(
            whole.contains("\n\nUsage: program impact") && whole.ends_with("try 'program impact --help'.\n"),
            "{whole}"
        );
        assert!(message.contains(wanted) && error.exit_code() == 2, "{message}\n\n{error}");
        assert!(!message.contains('\n') && !message.contains("Usage"), "{message}");
    }

    #[test]
    fn usage_names_no_option_that_may_be_left_out() {
        let words: Vec<OsString> =
            ["program", "impact", "--service", "x", "--ouput"].iter().map(OsString::from).collect();
        let whole = text_of(&parsed::<Program>(words.clone()).unwrap_err(), Program::command(), &words);
        assert!(whole.contains("\n\nUsage: program impact [OPTIONS]\n"), "{whole}");
    }

    #[test]
    fn an_option_before_its_command_is_reported() {
        let usage_line = |words: &[&str]| {
            let words: Vec<OsString> = words.iter().map(OsString::from).collect();
            usage_message(&parsed::<Program>(words).unwrap_err())
        };
        let after = usage_line(&["program", "--seed", "3", "impact"]);
        assert!(after.contains("put `--seed` after the command: `program impact --seed`"), "{after}");
        let alone = usage_line(&["program", "--seed=3"]);
        assert!(alone.contains("put `--seed` after the command: `program COMMAND --seed`"), "{alone}");
    }

    #[test]
    fn usage_errors_cut_and_escape_the_words_of_the_command_line() {
        let long = "9".repeat(100_000) + "\u{1b}[31m";
        for words in [
            vec!["program", long.as_str()],
            vec!["program", "impact", long.as_str()],
            vec!["program", "impact", "--seed", long.as_str()],
            vec!["program", "impact", "--radius-m", long.as_str()],
            vec!["program", "impact", &format!("--{long}"), "x"],
        ] {
            let words: Vec<OsString> = words.iter().map(OsString::from).collect();
            let error = parsed::<Program>(words.clone()).unwrap_err();
            let text = text_of(&error, Program::command(), &words);
            assert!(text.len() < 1500 && !text.contains('\u{1b}') && text.contains("bytes)"), "{text}");
        }
    }

    #[test]
    fn usage_errors_suggest_a_correction() {
        check(&["--ouput", "x"], "a similar argument exists: '--out'");
        check(&["--ouput=x"], "a similar argument exists: '--out'");
        check(&["--sevice", "x"], "--service");
        for odd in ["-1", "18446744073709551616", "x", "2.5"] {
            check(&["--seed", odd], "'--seed <SEED>': must be a whole number, 0 to 18446744073709551615");
            check(&["--examples", odd], "'--examples <EXAMPLES>': must be a whole number, 1 to 8");
        }
        for odd in ["-2", "4294967296"] {
            check(&["--clients", odd], "'--clients <CLIENTS>': must be a whole number, 0 to 4294967295");
        }
        for odd in ["0", "9"] {
            check(&["--examples", odd], "'--examples <EXAMPLES>': must be a whole number, 1 to 8");
        }
        check(&["--radius-m", "5cm"], "must be a number of meters, without a unit");
        check(&["--point", "1", "2", "3"], "numbers with commas and without spaces");
        check(&["--seed"], "a value is required");
        check(&["--position", "1,2,3"], "a similar argument exists: '--point'");
        check(&["--radius-m", "1,0,0"], "must be one number, not a vector");
        check(&["--wrong"], "the options of `program impact` are --out, --seed, --clients, --radius-m, --examples");
        check(&["--material", "glass"], "`--material` is an option of `shatterd bake`; the options of");
        check(
            &["--impulse", "1,0,0"],
            "found; tip: `--impulse` is an option of `shatter impact`; the options of `program impact` are --out, --seed, --clients",
        );
        check(&["mug"], "`program impact` takes only options");
    }
}
