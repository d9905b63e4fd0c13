//! Suggestions for commands and options that do not exist.

use shatter_proto::name::nearest;

/// Commands of each program.
pub const COMMANDS: [(&str, &[&str]); 2] = [
    ("shatter", &["list", "status", "impact", "prefracture", "threshold", "view", "load"]),
    ("shatterd", &["demo", "bake", "merge", "inspect", "check", "serve", "study"]),
];

/// Other words for commands, with the commands that they mean.
const OTHER_COMMANDS: [(&str, &[&str]); 10] = [
    ("impact", &["strike", "hit", "break", "fracture", "smash", "shatter", "shoot"]),
    ("list", &["ls", "objects", "show"]),
    ("status", &["stat", "info", "ps", "top", "health", "ping"]),
    ("load", &["bench", "benchmark", "stress"]),
    ("serve", &["start", "run", "server", "daemon", "up"]),
    ("bake", &["convert", "import", "build", "prepare", "add", "create"]),
    ("inspect", &["dump", "verify"]),
    ("view", &["browser", "gui", "web", "window", "viewer"]),
    ("check", &["validate", "lint", "plan"]),
    ("merge", &["join"]),
];

/// Words for ending a daemon, which a signal does.
const ENDING: [&str; 5] = ["stop", "quit", "kill", "end", "shutdown"];

/// Other words for options, with the options that they mean.
const OTHER_OPTIONS: [(&str, &[&str]); 16] = [
    ("point", &["p", "pos", "position", "at", "contact"]),
    ("impulse", &["i", "force", "momentum", "strength"]),
    ("direction", &["impulse", "impulse-ns", "d", "dir"]),
    ("impulse", &["direction"]),
    ("degree", &["n", "sites", "pieces", "fragments", "count"]),
    ("out", &["o", "output", "file", "save", "export"]),
    ("databases", &["db", "database", "data", "folder", "dir", "out"]),
    ("out", &["db", "database", "folder", "dir"]),
    ("unit", &["units", "scale"]),
    ("quality", &["q", "preset", "resolution", "lod"]),
    ("duration-s", &["duration"]),
    ("radius-m", &["radius"]),
    ("time-ms", &["time", "budget"]),
    ("seconds", &["duration", "duration-s", "time"]),
    ("deadline-ms", &["timeout", "deadline"]),
    ("log", &["v", "verbose", "debug", "log-level"]),
];

/// Options of one command that are given to others.
const OWNERS: [(&str, &[&str]); 3] = [
    (
        "shatterd bake",
        &[
            "shape",
            "material",
            "materials",
            "fragment-size",
            "unit",
            "up",
            "elastic-spacing",
            "crack-spacing",
            "surface",
            "examples",
            "cracks",
        ],
    ),
    ("shatterd serve", &["config", "scene", "databases"]),
    ("shatter impact", &["point", "ray", "impulse", "impulse-ns", "degree", "lift", "enable", "keep", "convention"]),
];

/// Suggestions for missing arguments, by the names that the parser gives them.
const MISSING: [(&str, &str); 9] = [
    ("<MESH>", "give a mesh file with --name NAME, or --shape SHAPE for a generated object, or --scene FILE"),
    ("--name <NAME>", "the object is listed and struck by its name, for example --name vase"),
    ("--rate <PER_SECOND_TOTAL>", "give --rate PER_SECOND, or --closed for a closed loop"),
    ("<OBJECT>", "`shatter list` shows the names of the objects"),
    ("<SCENE>", "a scene is a TOML file with a table [objects.NAME] for each object"),
    ("--ray <X,Y,Z,DX,DY,DZ>", "--impulse-ns goes with --ray; --point goes with --impulse"),
    ("--point <X,Y,Z>", "give the contact point by --point X,Y,Z or by --ray X,Y,Z,DX,DY,DZ"),
    ("--impulse <X,Y,Z>", "--point goes with --impulse X,Y,Z; --ray goes with --impulse-ns J, or with --impulse X,Y,Z"),
    ("--direction <X,Y,Z>", "--point goes with --direction X,Y,Z; a --ray has a direction of its own"),
];

/// Suggestion for the unknown command `word` of `program`.
pub fn command(program: &str, word: &str) -> String {
    let word = word.trim_start_matches('-').to_lowercase();
    if ENDING.contains(&word.as_str()) {
        return "to end a daemon, send SIGTERM to the process that `shatter status` names: kill PID".to_owned();
    }
    let other = OTHER_COMMANDS.iter().find(|(_, words)| words.contains(&word.as_str())).map(|(command, _)| *command);
    let near = || own_first(program).find_map(|(_, commands)| nearest(&word, commands).first().copied());
    let exact = own_first(program).flat_map(|(_, commands)| commands).find(|command| **command == word).copied();
    let Some(likely) = exact.or(other).or_else(near) else {
        let all = own_first(program).map(|(program, commands)| format!("{program} {}", commands.join("|")));
        return format!("the commands are: {}", all.collect::<Vec<_>>().join(", and "));
    };
    let owner = own_first(program).find(|(_, commands)| commands.contains(&likely)).map_or(program, |(owner, _)| owner);
    match owner == program {
        true => format!("did you mean `{owner} {likely}`?"),
        false => format!("did you mean `{owner} {likely}`? {likely} is a command of {owner}, not of {program}"),
    }
}

/// The programs with their commands, `program` first.
fn own_first(program: &str) -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    let own = move |wanted: bool| COMMANDS.into_iter().filter(move |(name, _)| (*name == program) == wanted);
    own(true).chain(own(false))
}

/// The one of the options `known` that `flag` means, unless another command has `flag`.
pub fn option<'a>(flag: &str, known: &[&'a str]) -> Option<&'a str> {
    let flag = flag.to_lowercase().replace('_', "-");
    let meant = OTHER_OPTIONS.iter().filter(|(_, words)| words.contains(&flag.as_str())).map(|(option, _)| *option);
    let exact = std::iter::once(flag.as_str()).chain(meant).find_map(|own| known.iter().find(|known| **known == own));
    // An option of another command is no misspelled one of this command.
    let near = || nearest(&flag, known).first().copied().filter(|_| owner(&flag, known).is_none());
    exact.copied().or_else(near)
}

/// The command that has the option `flag`, if a command with the options `known` is not that one.
pub fn owner(flag: &str, known: &[&str]) -> Option<&'static str> {
    if known.contains(&flag) {
        return None;
    }
    OWNERS.into_iter().find(|(_, options)| options.contains(&flag)).map(|(command, _)| command)
}

/// Suggestion for missing arguments, by the names that the parser gives them.
pub fn missing(names: &[String]) -> Option<&'static str> {
    MISSING.iter().find(|(name, _)| names.iter().any(|own| own == name)).map(|(_, advice)| *advice)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(program: &str, word: &str, wanted: &str) {
        let found = command(program, word);
        assert!(found.contains(wanted), "{program} {word}: {found}");
    }

    #[test]
    fn commands_of_the_other_program_are_suggested() {
        check("shatter", "strike", "`shatter impact`");
        check("shatter", "LIST", "`shatter list`");
        check("shatter", "--impact", "`shatter impact`");
        check("shatter", "hit", "`shatter impact`");
        check("shatter", "bake", "`shatterd bake`? bake is a command of shatterd");
        check("shatter", "start", "`shatterd serve`");
        check("shatter", "imapct", "`shatter impact`");
        check("shatterd", "impact", "`shatter impact`? impact is a command of shatter");
        check("shatterd", "status", "`shatter status`");
        check("shatterd", "sevre", "`shatterd serve`");
        check("shatterd", "thresold", "`shatter threshold`");
        check("shatterd", "stop", "SIGTERM");
        check("shatter", "xylophone", "shatter list|status");
        check("shatter", "xylophone", "shatterd demo|bake");
    }

    #[test]
    fn options_are_found_by_synonyms() {
        let impact = ["point", "ray", "impulse", "degree", "out", "duration-s", "radius-m"];
        assert_eq!(option("direction", &impact), Some("impulse"));
        assert_eq!(option("radius_m", &impact), Some("radius-m"));
        assert_eq!(option("o", &impact), Some("out"));
        assert_eq!(option("impuls", &impact), Some("impulse"));
        assert_eq!(option("wrong", &impact), None);
        assert_eq!(option("impulse", &["point", "direction"]), Some("direction"));
        assert_eq!(option("out", &["databases"]), Some("databases"));
    }
}
