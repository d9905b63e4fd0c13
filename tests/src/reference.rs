//! The reference pages of the guide, generated from the code.

use crate::command_errors::{COMMAND_ERRORS, kinds_in_source};
use crate::fixture::Fixture;
use crate::pages;
use bytemuck::Zeroable;
use shatter_engine::object::ResultEnergies;
use shatter_engine::scene::{OBJECT_KEYS, WARP_KEYS};
use shatter_proto::ErrorKind;
use shatter_proto::control::ServiceStatusRow;
use shatter_proto::effect::Effect;
use shatter_proto::result::{EffectCost, EnergySource, StageCost, StageKind};
use shatter_server::metrics::{JobEnd, Metrics};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::time::Duration;

/// Note below the title of each generated page.
const NOTE: &str = "Generated from the code by the test `documents`. Do not edit this page.\n\n";

/// Name and text of each page.
pub fn reference_pages() -> [(&'static str, String); 5] {
    [
        ("errors", errors()),
        ("configuration", configuration()),
        ("scenes", scenes()),
        ("commands", commands()),
        ("metrics", metrics()),
    ]
}

/// Doc lines of each error kind by its name, from the source.
fn causes() -> BTreeMap<String, String> {
    let source = pages::text("proto/src/error.rs");
    let kinds = source.split_once("\nkinds! {").unwrap().1.split_once("\n}").unwrap().0;
    let (mut causes, mut doc) = (BTreeMap::new(), String::new());
    for line in kinds.lines().map(str::trim) {
        match line.strip_prefix("///") {
            Some(text) => doc += text,
            None if line.is_empty() => {}
            None => {
                let name = line.split('"').nth(1).unwrap().to_owned();
                causes.insert(name, std::mem::take(&mut doc).trim().to_owned());
            }
        }
    }
    causes
}

/// Remedy for an error of this kind. A new kind needs a line here.
fn remedy(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::BadMagic | ErrorKind::UnknownRequest | ErrorKind::ReservedField => {
            "Send requests with the client library of this version."
        }
        ErrorKind::VersionMismatch => "Install daemon and client of the same release.",
        ErrorKind::ObjectName => "Use 1 to 64 bytes of UTF-8, without separators, control characters or a leading dot.",
        ErrorKind::UnknownObject => "Correct the name (`shatter list` prints all names), or bake the object.",
        ErrorKind::CorruptObject => {
            "Correct what the message names: a key of the scene, or the database, which you can bake again. `shatter status` repeats it."
        }
        ErrorKind::ContactCount => "Give 1 to 8 contacts.",
        ErrorKind::ContactPoint => "Give finite coordinates.",
        ErrorKind::ContactTooFar => "Check `--unit`, `--up` and the convention, use a larger radius, or use a ray.",
        ErrorKind::Impulse => {
            "Give a finite impulse other than zero. If the message names the duration, change that; if it names anchors, move the contacts."
        }
        ErrorKind::ContactDuration => "Give a finite duration above zero. Without one (0 in C), the default applies.",
        ErrorKind::ContactRadius => {
            "Give a radius above zero, at most the diagonal of the object's bounds. Without one (0 in C), the default applies."
        }
        ErrorKind::Gamma => "Give a finite γ above zero.",
        ErrorKind::Degree => "Give a number of sites from 1 to the object's limit (`shatter list --json`), or a rule.",
        ErrorKind::Lift => "Use another lift, or bake the object so that it has this one.",
        ErrorKind::UnknownEffect => "Use an effect of the guide's page *Effects*.",
        ErrorKind::Budget => {
            "Use a preset of the guide, and finite limits above zero; only the number of iterations may be zero."
        }
        ErrorKind::Convention => "Use a named convention, or a unit of 1e-6 to 1e6 m.",
        ErrorKind::UnknownHandle => "Strike the object again with `keep`; raise `results.kept_max` or `times.kept_s`.",
        ErrorKind::CapExceeded => {
            "Request fewer sites or fewer output effects, or raise the limit of the request or the scene."
        }
        ErrorKind::ServiceName => "Use 1 to 32 letters, digits, `-` or `_`.",
        ErrorKind::Configuration => "Correct the key or the file that the message names, or install the program.",
        ErrorKind::Output => "Check the path, its permissions and the free space on the disk.",
        ErrorKind::Unsolvable => "Move the contacts, or anchor the object differently.",
        ErrorKind::Elastic => "Use `reduced` or `solve`.",
        ErrorKind::Effect => "Enable the effect that it needs, or change the scene.",
        ErrorKind::UnknownFragment => "Use the id of a fragment of that result.",
        ErrorKind::FragmentSize => "Strike a larger fragment, disable `elastic`, or treat this one as unbreakable.",
        ErrorKind::Ray => "Give one ray with a finite direction other than zero, and no other contact.",
        ErrorKind::RayMissed => "Aim at the object; the message gives the closest approach.",
        ErrorKind::ContactPartner => {
            "Give a partner for all contacts or for none, with a mass above zero, finite speeds, and inertia zero or positive definite."
        }
        ErrorKind::TicketSpent => "Send the request again, and read each ticket until its first result or error.",
        ErrorKind::Busy => {
            "Wait for `retry_after_ms`; free results that you have read; for more clients raise `service.clients_max`."
        }
        ErrorKind::Late => "Send fewer requests, allow more time, or use a faster preset.",
        ErrorKind::Stopping => "Send the request again when the next daemon serves.",
        ErrorKind::Canceled => "None is needed: the client dropped the ticket.",
        ErrorKind::Failed | ErrorKind::Transport => {
            "Raise the limit that the message names (`ulimit`). If it names none, report it with the daemon's log."
        }
        ErrorKind::ResultTooLarge => "Restart the daemon, or raise `results.bucket_mib_max`.",
        ErrorKind::BadResult => "Report it; check that no other program writes to the service's shared memory.",
        ErrorKind::Loading => "Wait for `retry_after_ms`.",
        ErrorKind::NoDaemon => {
            "Start `shatterd serve`, or wait if it still loads its databases; check the service's name and `XDG_RUNTIME_DIR`."
        }
        ErrorKind::Lost => "Send the request again when a daemon runs.",
        ErrorKind::SecondDaemon => "Stop the other daemon, or use another service name.",
        ErrorKind::RuntimeFolder => {
            "Make the folder that the message names yours alone (mode 0700) and writable, or set `XDG_RUNTIME_DIR` to another."
        }
        ErrorKind::SharedMemory => "Free space in `/dev/shm`.",
        ErrorKind::DatabaseFolder => "Check that the folder exists and can be read; see `--databases`.",
        ErrorKind::Port => "Choose another `operations.port`, or 0 for none.",
        other => panic!("no remedy for {}", other.name()),
    }
}

fn errors() -> String {
    let causes = causes();
    let mut page = format!(
        "# Error kinds\n\n{NOTE}\
         `shatter` prints `shatter: KIND: MESSAGE` on stderr, `shatterd` prints `shatterd: KIND: MESSAGE (at AT)`, without the\n\
         parenthesis if MESSAGE contains AT. A usage error has several lines: the message, the usage, and the command that prints the help.\n\
         With `--json`, stdout contains a document with the key `error`.\n\n\
         | key of `error` | content |\n\
         |---|---|\n\
         | `kind` | a kind of this page; `usage` if the command line is invalid |\n\
         | `message` | the message, in one line |\n\
         | `fault`, `retry` | `caller`, `environment` or `service`; `true` if the same request may succeed later |\n\
         | `at` | a field (`contacts[0].point_m`), option, configuration key, path or place in a file; for some kinds only the refused value, such as a name. Empty for usage errors and where no single input is the cause |\n\
         | `retry_after_ms` | of `shatter` and of studies: time after which to try again, ms, or `null` |\n\n\
         *Fault* is the side that has to change something. *Retry* means that the same request may succeed later. *Exit* is\n\
         the exit code of a command that ends with the error. *Code* is the number in C and on the wire.\n\n\
         | kind | cause | remedy | fault | retry | exit | code |\n|---|---|---|---|---|---|---|\n"
    );
    for kind in ErrorKind::ALL {
        let retry = if kind.retry() { "yes" } else { "no" };
        let (name, cause, remedy) = (kind.name(), &causes[kind.name()], remedy(*kind));
        let (fault, exit, code) = (kind.fault().name(), kind.exit_code(), kind.code());
        writeln!(page, "| `{name}` | {cause} | {remedy} | {fault} | {retry} | {exit} | {code} |").unwrap();
    }
    page += "\nThe libraries report two more errors, which no service sends. C: `SHATTER_CODE_ARGUMENT` (200), an argument that cannot be\n\
             used (NULL, not UTF-8, or without meaning), and `SHATTER_CODE_PANICKED` (201), a defect of the library. Python:\n\
             `shatter.ArgumentError`, for the same arguments; it is a `ShatterError` and a `ValueError`.\n";
    command_errors(&mut page);
    page
}

/// Errors of meshes, bakes and databases.
fn command_errors(page: &mut String) {
    let service: BTreeSet<&str> = ErrorKind::ALL.iter().map(|kind| kind.name()).collect();
    let listed: BTreeSet<String> = COMMAND_ERRORS.iter().map(|(kind, ..)| (*kind).to_owned()).collect();
    assert_eq!(listed, kinds_in_source(&service), "every kind of the commands has a cause and a remedy");
    *page += "\n## Errors of the commands of `shatterd`\n\n\
              They concern meshes, materials, bakes, databases and shares. They have no code, because no client receives them. The\n\
              exit code is 3; of `interrupted` 130 or 143, and of a defect of the engine (*Report it*) 6.\n\n\
              | kind | cause | remedy |\n|---|---|---|\n";
    for (kind, cause, remedy) in COMMAND_ERRORS {
        writeln!(page, "| `{kind}` | {cause} | {remedy} |").unwrap();
    }
}

fn configuration() -> String {
    let mut page = format!(
        "# Configuration\n\n{NOTE}\
         `shatterd serve --config FILE` reads a TOML file. It needs only the keys that differ from the default below; options\n\
         override both. An unknown key is refused by name.\n"
    );
    let mut doc: Vec<&str> = Vec::new();
    for line in pages::text("config/shatterd.toml").lines() {
        if let Some(text) = line.strip_prefix('#') {
            doc.push(text.trim());
        } else if let Some(section) = line.strip_prefix('[') {
            let section = section.trim_end_matches(']');
            write!(page, "\n## {section}\n\n| key | default | meaning |\n|---|---|---|\n").unwrap();
        } else if let Some((key, value)) = line.split_once(" = ") {
            writeln!(page, "| `{key}` | `{value}` | {} |", doc.join(" ").replace('|', "\\|")).unwrap();
            doc.clear();
        } else {
            doc.clear();
        }
    }
    page
}

/// Keys of scenes, from the head of a shipped scene.
fn scenes() -> String {
    let mut page = format!(
        "# Keys of scenes\n\n{NOTE}\
         A [scene](../scenes.md) is a TOML file: an optional `title`, and a table `[objects.NAME]` for each object. An unknown key is\n\
         refused by name.\n"
    );
    let scene = pages::text("config/scenes/glass_shop.toml");
    let lines = scene.lines().map_while(|line| line.strip_prefix('#'));
    let mut sections: Vec<(&str, Vec<(&str, String)>)> = Vec::new();
    for line in lines.skip_while(|line| !line.starts_with(" Keys of")) {
        let Some(text) = line.strip_prefix("   ") else {
            sections.push((line.trim(), Vec::new()));
            continue;
        };
        let rows = &mut sections.last_mut().unwrap().1;
        match text.split_once(char::is_whitespace).filter(|(key, _)| !key.is_empty()) {
            Some((key, text)) => rows.push((key, text.trim().to_owned())),
            None => rows.last_mut().unwrap().1 += &format!(" {}", text.trim()),
        }
    }
    let listed = |section: usize| sections[section].1.iter().map(|(key, _)| *key).collect::<BTreeSet<_>>();
    assert_eq!(
        listed(0),
        BTreeSet::from(OBJECT_KEYS),
        "config/scenes/glass_shop.toml describes every key of an object"
    );
    assert_eq!(listed(1), BTreeSet::from(WARP_KEYS), "config/scenes/glass_shop.toml describes every control");
    for ((heading, rows), title) in sections.iter().zip(["Objects", "Controls for artists"]) {
        write!(page, "\n## {title}\n\n{heading}\n\n| key | default | meaning |\n|---|---|---|\n").unwrap();
        for (key, text) in rows {
            let (meaning, default) = text.strip_suffix(']').and_then(|text| text.rsplit_once(" [")).expect(key);
            writeln!(page, "| `{key}` | {default} | {meaning} |").unwrap();
        }
    }
    page
}

/// Every command that has its own `--help`.
const COMMANDS: [&str; 18] = [
    "shatterd",
    "shatterd demo",
    "shatterd bake",
    "shatterd merge",
    "shatterd inspect",
    "shatterd check",
    "shatterd serve",
    "shatterd study stability",
    "shatterd study effects",
    "shatterd study paper",
    "shatterd study accuracy",
    "shatter",
    "shatter list",
    "shatter status",
    "shatter impact",
    "shatter prefracture",
    "shatter threshold",
    "shatter view",
];

/// Commands that the help of the program itself lists.
fn listed(help: &str) -> BTreeSet<&str> {
    let listed = help.split_once("Commands:\n").unwrap().1.lines().take_while(|line| !line.is_empty());
    listed.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect()
}

fn commands() -> String {
    let fixture = Fixture::new();
    let help = |command: &str| {
        let words: Vec<&str> = command.split(' ').collect();
        let mut run = fixture.command(words[0]);
        let output = run.args(&words[1..]).arg("--help").env_remove("SHATTER_MESHES").output().unwrap();
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().map(|line| line.trim_end().to_owned() + "\n").collect::<String>()
    };
    for program in ["shatter", "shatterd"] {
        let own = COMMANDS.iter().chain(&["shatter load"]).filter_map(|command| command.strip_prefix(program));
        let own: BTreeSet<&str> = own.filter_map(|rest| rest.strip_prefix(' ')?.split(' ').next()).collect();
        assert_eq!(own, listed(&help(program)), "the reference shows every command of {program}");
    }
    let mut page = format!(
        "# Command lines\n\n{NOTE}The text of `--help` of every command, except `manuals`, which writes man pages and completions for packages.\n"
    );
    for command in COMMANDS.iter().chain(&["shatter load"]) {
        write!(page, "\n## {command}\n\n```text\n{}```\n", help(command)).unwrap();
    }
    page
}

/// Metrics with all of their labels.
fn exposition() -> String {
    let mut metrics = Metrics::new().unwrap();
    use JobEnd::{Busy, Canceled, Completed, Failed, Late, Refused};
    for end in [Completed, Busy, Canceled, Failed, Late, Refused] {
        metrics.ended(end);
    }
    let mut stage = StageCost::idle(StageKind::Elasticity);
    stage.add(Duration::from_millis(1), 0);
    let mut effect = EffectCost::idle(Effect::Bonds);
    effect.add(Duration::from_millis(1), 0);
    let energies = ResultEnergies::unknown(EnergySource::Bounded);
    metrics.ran(Completed, Duration::from_millis(1), Some(energies), &[stage], &[effect]);
    metrics.text(&ServiceStatusRow::zeroed())
}

fn metrics() -> String {
    let text = exposition();
    let mut page = format!(
        "# Metrics\n\n{NOTE}\
         `/metrics` of `operations.port` serves these as OpenMetrics text. The daemon also writes them to its runtime folder\n\
         every `times.metrics_s`. Samples of counters end in `_total`; those of histograms in `_bucket`, `_sum` and `_count`.\n\n\
         | metric | type | meaning | label |\n|---|---|---|---|\n"
    );
    let described = |kind: &str| -> BTreeMap<&str, &str> {
        text.lines().filter_map(|line| line.strip_prefix(kind)?.split_once(' ')).collect()
    };
    let (types, helps) = (described("# TYPE "), described("# HELP "));
    for (name, kind) in types {
        let sample = text.lines().find(|line| !line.starts_with('#') && line.starts_with(name)).unwrap_or_default();
        let labels = sample.split_once('{').and_then(|(_, rest)| rest.split_once('}')).map_or("", |(labels, _)| labels);
        let label = labels.split('=').next().filter(|label| !label.is_empty() && *label != "le");
        let label = label.map_or_else(String::new, |label| format!("`{label}`"));
        let help = helps[name].trim_end_matches('.');
        writeln!(page, "| `{name}` | {kind} | {help} | {label} |").unwrap();
    }
    page
}
