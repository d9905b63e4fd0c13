//! What `shatter` and `shatterd` share as programs: standard output, arguments and usage errors. No interface for hosts.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches};
use shatter_proto::name::{nearest, suggestion};
use shatter_proto::{Kind, Refusal};
use std::ffi::OsString;
use std::fmt::Arguments;
use std::io::{IsTerminal, Write};

/// Why a result did not reach standard output.
#[derive(Debug)]
pub enum StdoutError {
    /// The reader closed the pipe: the program ends quietly with [`exit::CLOSED`](shatter_proto::exit::CLOSED).
    Closed,
    /// It cannot be written.
    Failed(Refusal),
}

/// Writes to standard output and flushes it: the one place where both programs do.
///
/// # Errors
/// [`StdoutError`].
pub fn print(text: Arguments<'_>) -> Result<(), StdoutError> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_fmt(text).and_then(|()| stdout.flush()).map_err(|error| match error.kind() {
        std::io::ErrorKind::BrokenPipe => StdoutError::Closed,
        _ => StdoutError::Failed(Refusal::new(Kind::Output, "stdout", format!("cannot write to stdout: {error}"))),
    })
}

/// Prints the help or version that was asked for.
///
/// # Errors
/// [`StdoutError`].
pub fn print_help(help: &clap::Error) -> Result<(), StdoutError> {
    let text = help.render();
    if std::io::stdout().is_terminal() { print(format_args!("{}", text.ansi())) } else { print(format_args!("{text}")) }
}

/// The arguments of this process, as `C` understands them.
///
/// # Errors
/// A usage error that names the nearest option and says why a number is refused, or the help that was asked for.
pub fn arguments<C: CommandFactory + FromArgMatches>() -> Result<C, clap::Error> {
    parsed(std::env::args_os().collect())
}

fn parsed<C: CommandFactory + FromArgMatches>(words: Vec<OsString>) -> Result<C, clap::Error> {
    let mut command = takes_negative_numbers(C::command());
    let matches = command.try_get_matches_from_mut(&words).map_err(|error| explained(error, &command, &words))?;
    C::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
}

/// A negative number after an option is its value: it is refused by what it is, not as an unknown option.
fn takes_negative_numbers(command: clap::Command) -> clap::Command {
    let with_value = |arg: clap::Arg| {
        let plain = arg.is_positional() || !arg.get_action().takes_values() || arg.is_allow_hyphen_values_set();
        if plain { arg } else { arg.allow_negative_numbers(true) }
    };
    command.mut_args(with_value).mut_subcommands(takes_negative_numbers)
}

/// `error`, with the reason that the parser does not give.
fn explained(mut error: clap::Error, command: &clap::Command, words: &[OsString]) -> clap::Error {
    let Some(word) = text(&error, ContextKind::InvalidArg).map(str::to_owned) else { return error };
    match error.kind() {
        ErrorKind::UnknownArgument if word.parse::<f64>().is_ok() => {
            let tip = "vectors are one word: numbers with commas and without spaces, for example 0.1,0,-0.2";
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        }
        ErrorKind::UnknownArgument if text(&error, ContextKind::SuggestedArg).is_none() => {
            let flag = word.trim_start_matches('-').split('=').next().unwrap_or_default();
            let known: Vec<&str> = options(command, words);
            if let Some(likely) = nearest(flag, &known).first().filter(|_| word.starts_with("--")) {
                error.remove(ContextKind::Suggested);
                error.insert(ContextKind::SuggestedArg, ContextValue::String(format!("--{likely}")));
            }
        }
        ErrorKind::ValueValidation if negative(&error) && is_whole(&error) => {
            let value = text(&error, ContextKind::InvalidValue).unwrap_or_default();
            let message = format!("invalid value '{value}' for '{word}': must be a whole number, 0 or more\n");
            return clap::Error::raw(ErrorKind::ValueValidation, message).with_cmd(command);
        }
        ErrorKind::ValueValidation if source(&error).contains("invalid float literal") => {
            let value = text(&error, ContextKind::InvalidValue).unwrap_or_default();
            let message = format!("invalid value '{value}' for '{word}': must be a number, without a unit\n");
            return clap::Error::raw(ErrorKind::ValueValidation, message).with_cmd(command);
        }
        _ => {}
    }
    error
}

fn text(error: &clap::Error, kind: ContextKind) -> Option<&str> {
    match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text),
        _ => None,
    }
}

fn negative(error: &clap::Error) -> bool {
    text(error, ContextKind::InvalidValue).is_some_and(|value| value.starts_with('-') && value.parse::<f64>().is_ok())
}

/// Whether the value was to be a whole number without a sign.
fn is_whole(error: &clap::Error) -> bool {
    source(error).contains("invalid digit") || source(error).contains("is not in 0..")
}

/// What the parser of the value said.
fn source(error: &clap::Error) -> String {
    std::error::Error::source(error).map(ToString::to_string).unwrap_or_default()
}

/// Long names of the options of the command that `words` name.
fn options<'a>(command: &'a clap::Command, words: &[OsString]) -> Vec<&'a str> {
    let own = words.iter().fold(command, |own, word| own.find_subcommand(word).unwrap_or(own));
    own.get_arguments().chain(command.get_arguments()).filter_map(clap::Arg::get_long).collect()
}

/// What a usage error says in one line: without the usage that follows it.
pub fn usage_message(error: &clap::Error) -> String {
    let text = error.to_string();
    let end = ["\nUsage:", "\nFor more information"].iter().filter_map(|end| text.find(end)).min();
    let lines = text[..end.unwrap_or(text.len())].lines().map(str::trim).filter(|line| !line.is_empty());
    lines.collect::<Vec<_>>().join(" ").trim_start_matches("error: ").to_owned()
}

/// The one of `choices` that `name` names.
///
/// # Errors
/// The nearest names, and all of them.
pub fn choice<T: Copy>(name: &str, choices: &[(&str, T)]) -> Result<T, String> {
    let found = choices.iter().find(|(own, _)| *own == name).map(|(_, choice)| *choice);
    found.ok_or_else(|| {
        let names: Vec<&str> = choices.iter().map(|(own, _)| *own).collect();
        let all = names.iter().map(|own| format!("`{own}`")).collect::<Vec<_>>().join(", ");
        match nearest(name, &names).is_empty() {
            true => format!("must be one of {all}"),
            false => format!("{} Possible: {all}", suggestion(name, &names)),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    /// Arguments of a program.
    #[derive(Parser, Debug)]
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
            #[arg(long)]
            point: Option<String>,
        },
    }

    #[track_caller]
    fn check(words: &[&str], wanted: &str) {
        let words = ["program", "impact"].iter().chain(words).map(OsString::from).collect();
        let error = parsed::<Program>(words).unwrap_err();
        let message = usage_message(&error);
        assert!(message.contains(wanted) && error.exit_code() == 2, "{message}\n\n{error}");
        assert!(!message.contains('\n') && !message.contains("Usage"), "{message}");
    }

    #[test]
    fn usage_errors_say_what_to_do() {
        check(&["--ouput", "x"], "a similar argument exists: '--out'");
        check(&["--ouput=x"], "a similar argument exists: '--out'");
        check(&["--sevice", "x"], "--service");
        check(&["--seed", "-1"], "'--seed <SEED>': must be a whole number, 0 or more");
        check(&["--clients", "-2"], "'--clients <CLIENTS>': must be a whole number, 0 or more");
        check(&["--seed", "x"], "invalid digit");
        check(&["--radius-m", "5cm"], "must be a number, without a unit");
        check(&["--point", "1", "2", "3"], "numbers with commas and without spaces");
        check(&["--seed"], "a value is required");
    }

    #[test]
    fn choices_name_the_nearest() {
        let choices = [("draft", 1), ("game", 2), ("film", 3)];
        assert_eq!(choice("game", &choices), Ok(2));
        assert_eq!(choice("flim", &choices).unwrap_err(), "did you mean `film`? Possible: `draft`, `game`, `film`");
        assert_eq!(choice("x", &choices).unwrap_err(), "must be one of `draft`, `game`, `film`");
    }
}
