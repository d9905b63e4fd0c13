//! Parts that the programs `shatter` and `shatterd` share: standard output, arguments and usage errors. Not an interface for hosts.

pub mod cli_error;
pub mod lab;
pub mod manuals;
mod mistakes;
mod stdout;
mod usage;

pub use mistakes::COMMANDS;
pub use stdout::{StdoutError, is_closed, print};
pub use usage::{arguments, usage_message, usage_text};

use shatter_proto::name::{nearest, suggestion};
use std::fmt::Display;
use std::io::IsTerminal;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Makes writes beyond the limit of the size of files (`ulimit -f`) fail with an error; else the system ends the process without a message.
pub fn report_file_size_limit() {
    // A system without the signal has no such limit.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Prints the help or the version that was requested.
///
/// # Errors
/// [`StdoutError`].
pub fn print_help(help: &clap::Error) -> Result<(), StdoutError> {
    let text = help.render();
    if std::io::stdout().is_terminal() { print(format_args!("{}", text.ansi())) } else { print(format_args!("{text}")) }
}

/// Finds the one of `choices` with this name.
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

/// Parser of an option that takes a whole number of `range`; its message names both limits.
pub fn whole_number<T: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let found = text.parse().ok().filter(|number| range.contains(number));
        found.and_then(|number| T::try_from(number).ok()).ok_or_else(|| whole_number_wanted(range.start(), range.end()))
    }
}

/// Message for a value that is no whole number from `low` to `high`.
fn whole_number_wanted(low: &dyn Display, high: &dyn Display) -> String {
    format!("must be a whole number, {low} to {high}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_choices_suggest_the_nearest() {
        let choices = [("draft", 1), ("game", 2), ("film", 3)];
        assert_eq!(choice("game", &choices), Ok(2));
        assert_eq!(choice("flim", &choices).unwrap_err(), "did you mean `film`? Possible: `draft`, `game`, `film`");
        assert_eq!(choice("x", &choices).unwrap_err(), "must be one of `draft`, `game`, `film`");
    }
}
