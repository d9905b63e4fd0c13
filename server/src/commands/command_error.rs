//! Error of a command: kind, fault, whether to retry, and the offending input.

use super::interrupt;
use serde_json::json;
use shatter_cli_common::{self as program, StdoutError};
use shatter_export::ExportError;
use shatter_fracture::database::{BakeError, DatabaseError, HALF_SPACING_COST, JoinError};
use shatter_fracture::lattice::LatticeError;
use shatter_fracture::pipeline::{AnchorError, AnchoredBasisError};
use shatter_fracture::scene::MaterialError;
use shatter_fracture::surface::SurfaceError;
use shatter_proto::{Error, ErrorKind, exit, text};
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

/// Exit code of a usage error, the same as clap's.
const USAGE: u8 = 2;

/// Kind of an error after the reader of stdout closed the pipe: the command ends without a message.
const CLOSED: &str = "closed";

/// Option that sets the spacing of the crack lattice.
const CRACK_SPACING: &str = "--crack-spacing";

/// Error of a command: printed text, JSON document and exit code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandError {
    kind: &'static str,
    fault: &'static str,
    retry: bool,
    at: String,
    message: String,
    exit_code: u8,
    /// Outcome per file, if the command writes several.
    files: Option<serde_json::Value>,
}

impl CommandError {
    /// Error in the caller's input.
    pub fn refused(kind: &'static str, at: impl Into<String>, message: impl Into<String>) -> Self {
        let (at, message) = (at.into(), message.into());
        Self { kind, fault: "caller", retry: false, at, message, exit_code: exit::REFUSED, files: None }
    }

    /// Error in the command line.
    pub fn usage(error: &clap::Error) -> Self {
        Self { exit_code: USAGE, ..Self::refused("usage", "", program::usage_message(error)) }
    }

    /// Error of a file or folder that cannot be written.
    pub fn output(path: &Path, error: &dyn std::fmt::Display) -> Self {
        let at = path.display().to_string();
        Self { fault: "environment", ..Self::refused("output", at, format!("{}: {error}", path.display())) }
    }

    /// Error of a database that cannot be read or written; `at` is the file, the message names the part of it.
    pub fn database(path: &Path, error: &DatabaseError) -> Self {
        let kind = match error {
            DatabaseError::Io { .. } => "database_file",
            DatabaseError::Format { .. } => "database_format",
            DatabaseError::Share => "database_share",
            DatabaseError::Whole => "whole_database",
            _ => "corrupt_database",
        };
        let refused = Self { fault: "environment", ..Self::refused(kind, path.display().to_string(), error.of(path)) };
        match error.remedy() {
            Some(remedy) => refused.advised(remedy),
            None if kind == "whole_database" => {
                refused.advised("name the files NAME.I-of-N.share that `shatterd bake --shard I/N` wrote")
            }
            None => refused,
        }
    }

    /// Adds the outcome of each file.
    pub fn with_files(self, files: serde_json::Value) -> Self {
        Self { files: Some(files), ..self }
    }

    /// Names `file` in the message and as the offending input.
    pub fn of_file(self, file: &Path) -> Self {
        let at = file.display().to_string();
        Self { message: format!("{at}: {}", self.message), at, ..self }
    }

    /// Begins the message with the name of the `scene` to which the offending key belongs.
    pub fn of_scene(self, scene: &Path) -> Self {
        Self { message: format!("{}: {}", scene.display(), self.message), ..self }
    }

    /// Appends advice to the message.
    pub fn advised(mut self, advice: &str) -> Self {
        self.message += "; ";
        self.message += advice;
        self
    }

    /// Names keys of a scene instead of options of `bake`.
    pub fn with_scene_keys(self) -> Self {
        Self { message: scene_keys(&self.message), at: scene_keys(&self.at), ..self }
    }

    /// Internal error.
    pub fn ours(kind: &'static str, message: impl Into<String>) -> Self {
        Self { fault: "service", exit_code: exit::OURS, ..Self::refused(kind, "", message) }
    }

    /// Error of a command that a signal ended.
    pub fn interrupted(message: impl Into<String>) -> Self {
        Self { retry: true, exit_code: interrupt::exit_code(), ..Self::refused("interrupted", "", message) }
    }

    /// Name of the error.
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// Message for people.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Whether the error is internal.
    pub fn is_ours(&self) -> bool {
        self.fault == "service"
    }

    /// Prints the error on stderr, and as a JSON document on stdout if `as_json`; returns the exit code.
    pub fn print(&self, as_json: bool) -> ExitCode {
        if self.kind == CLOSED {
            return ExitCode::from(self.exit_code);
        }
        if as_json && let Err(StdoutError::Failed(error)) = program::print(format_args!("{:#}\n", self.document())) {
            let _ = writeln!(std::io::stderr(), "shatterd: {error}");
        }
        let _ = writeln!(std::io::stderr(), "shatterd: {}", self.line());
        ExitCode::from(self.exit_code)
    }

    /// The error in one line: kind, message, and the offending input if the message does not name it.
    fn line(&self) -> String {
        let (message, at) = (text::message(&self.message), text::quoted(&self.at));
        // A message may quote the input escaped.
        let is_named = message.contains(&at) || self.message.contains(&self.at);
        let at = if is_named { String::new() } else { format!(" (at {at})") };
        format!("{}: {message}{at}", self.kind)
    }

    /// JSON document of the error.
    pub fn document(&self) -> serde_json::Value {
        let mut document = json!({"error": {
            "kind": self.kind, "message": text::message(&self.message), "fault": self.fault, "retry": self.retry,
            "at": text::quoted(&self.at),
        }});
        if let Some(files) = &self.files {
            document["files"] = files.clone();
        }
        document
    }
}

impl From<StdoutError> for CommandError {
    fn from(error: StdoutError) -> Self {
        match error {
            StdoutError::Failed(error) => error.into(),
            StdoutError::Closed => {
                let message = "the reader of stdout closed it";
                Self { fault: "environment", exit_code: exit::CLOSED, ..Self::refused(CLOSED, "stdout", message) }
            }
        }
    }
}

impl From<Error> for CommandError {
    fn from(error: Error) -> Self {
        Self {
            kind: error.kind.name(),
            fault: error.kind.fault().name(),
            retry: error.kind.retry(),
            exit_code: error.kind.exit_code(),
            at: error.at,
            message: error.message,
            files: None,
        }
    }
}

impl From<ExportError> for CommandError {
    fn from(error: ExportError) -> Self {
        match error.path() {
            Some(path) => Error::new(ErrorKind::Output, path.display().to_string(), error.to_string()).into(),
            None => Self::ours("failed", error.to_string()),
        }
    }
}

impl From<MaterialError> for CommandError {
    fn from(error: MaterialError) -> Self {
        let (kind, at) = match &error {
            MaterialError::Unreadable(_) => ("material_table", String::new()),
            MaterialError::OutOfRange { material, key, .. } => ("material_number", format!("{material}.{key}")),
            MaterialError::Unknown { name, .. } => ("unknown_material", name.clone()),
        };
        Self::refused(kind, at, error.to_string())
    }
}

impl From<SurfaceError> for CommandError {
    fn from(error: SurfaceError) -> Self {
        let (kind, at) = match &error {
            SurfaceError::Unreadable { path, .. } => ("unreadable_file", path.display().to_string()),
            SurfaceError::UnknownFormat { path, .. } => ("unknown_format", path.display().to_string()),
            SurfaceError::Malformed { place, .. } => ("malformed_file", place.clone()),
            SurfaceError::RequiredExtension { extension } => ("required_extension", extension.clone()),
            SurfaceError::TooLarge { .. } => ("too_large", String::new()),
            SurfaceError::Empty { .. } => ("empty_mesh", String::new()),
            SurfaceError::NonFiniteVertex { vertex, .. } => ("non_finite_vertex", format!("vertex {vertex}")),
            SurfaceError::VertexOutOfBounds { face, .. } => ("vertex_out_of_bounds", format!("face {face}")),
            SurfaceError::VertexOutOfRange { vertex, .. } => ("extent_out_of_range", format!("vertex {vertex}")),
            SurfaceError::FarVertex { vertex } => ("far_vertex", format!("vertex {vertex}")),
            SurfaceError::Outliers { vertices, .. } => {
                let names = vertices.iter().map(|(vertex, _)| format!("vertex {vertex}"));
                ("far_vertex", names.collect::<Vec<_>>().join(", "))
            }
            SurfaceError::AllDegenerate => ("all_degenerate", String::new()),
            SurfaceError::ZeroExtent => ("zero_extent", String::new()),
            SurfaceError::ExtentOutOfRange { .. } => ("extent_out_of_range", String::new()),
            SurfaceError::NothingInside | SurfaceError::Flat { .. } => ("nothing_inside", String::new()),
            SurfaceError::Needle { .. } => ("too_thin", String::new()),
            SurfaceError::Canceled(_) => return interrupt::ended(),
        };
        Self::refused(kind, at, error.to_string())
    }
}

/// A text about options of `bake`, with the keys of a scene in their place.
pub fn scene_keys(text: &str) -> String {
    let keys = [
        ("--elastic-spacing", "elastic_spacing"),
        ("--crack-spacing", "crack_spacing"),
        ("--fragment-size", "fragment_size_m"),
        ("--gamma", "gamma_j_m2"),
        ("--examples", "examples"),
        ("--quality ", "quality = "),
        ("--elements ", "elements = "),
        ("--surface ", "surface = "),
    ];
    keys.iter().fold(text.to_owned(), |text, (option, key)| text.replace(option, key))
}

impl From<LatticeError> for CommandError {
    fn from(error: LatticeError) -> Self {
        let option = |level: &str| format!("--{level}-spacing");
        let (kind, at, advice) = match &error {
            LatticeError::SpacingOutOfRange { level, spacing_min, spacing_max, .. } => {
                let advice = format!("set {} from {spacing_min} to {spacing_max}", option(level));
                ("spacing_out_of_range", option(level), advice)
            }
            LatticeError::GridTooLarge { .. } => {
                ("grid_too_large", String::new(), "use a coarser --elastic-spacing and --crack-spacing".to_owned())
            }
            LatticeError::TooManyNodes { level, .. } => {
                ("too_many_nodes", option(level), format!("set it with {}", option(level)))
            }
            LatticeError::CrackCoarser { elastic, .. } => {
                ("spacing_order", option("crack"), format!("set --crack-spacing to {elastic} or less"))
            }
            LatticeError::NothingInside { .. } => {
                ("nothing_inside", option("crack"), format!("bake with a finer --crack-spacing; {HALF_SPACING_COST}"))
            }
            LatticeError::Canceled(_) => return interrupt::ended(),
            LatticeError::BoundsNotFinite
            | LatticeError::VolumeNotPositive { .. }
            | LatticeError::DistanceNotFinite { .. } => return Self::ours("lattice", error.to_string()),
        };
        Self::refused(kind, at, error.to_string()).advised(&advice)
    }
}

impl From<BakeError> for CommandError {
    fn from(error: BakeError) -> Self {
        let message = error.to_string();
        match error {
            error if error.is_canceled() => interrupt::ended(),
            BakeError::Severed(_) => Self::refused("severed_parts", "--quality", message),
            BakeError::Name(name) => Self::refused("object_name", name, message),
            BakeError::NotPositive { key, .. } if !key.contains(' ') => {
                let option = format!("--{key}");
                Self::refused("not_positive", option, format!("--{message}"))
            }
            BakeError::NotPositive { key, .. } => Self::refused("not_positive", key, message),
            BakeError::Unusual { key, .. } => Self::refused("out_of_range", key, message),
            BakeError::TooManyExamples { asked } => Self::refused("too_many_examples", asked.to_string(), message),
            BakeError::TooSmall { .. } => Self::refused("too_small", CRACK_SPACING, message),
            BakeError::TooThin { thickness_needed_m: None, .. } => {
                Self::refused("too_thin", CRACK_SPACING, message).advised("set it with --crack-spacing")
            }
            BakeError::TooThin { .. } => Self::refused("too_thin", "", message)
                .advised("make the walls thicker, or bake the object in smaller parts"),
            BakeError::CracksMiss { .. } => Self::refused("cracks_miss", "--cracks", message),
            BakeError::CracksTooSmall { .. } => Self::refused("cracks_too_small", CRACK_SPACING, message),
            BakeError::CracksTakeAll { .. } => Self::refused("cracks_take_all", CRACK_SPACING, message),
            BakeError::Cracks(error) => Self { message, ..error.into() },
            BakeError::Surface(error) => error.into(),
            BakeError::Lattice(error) => error.into(),
            BakeError::Elasticity { body, .. } | BakeError::FreeJoint { body, .. } => {
                Self::refused("elasticity", format!("body {body}"), message)
            }
            BakeError::Lift { .. } => Self::ours("lift", message),
            BakeError::Calibration(_) => Self::ours("calibration", message),
            BakeError::Canceled(_) => interrupt::ended(),
        }
    }
}

impl From<AnchoredBasisError> for CommandError {
    fn from(error: AnchoredBasisError) -> Self {
        match error {
            AnchoredBasisError::Anchors(AnchorError::Canceled(_)) => interrupt::ended(),
            AnchoredBasisError::Impact(error) => BakeError::from(error).into(),
            error => Error::new(ErrorKind::Configuration, "anchors", error.to_string()).into(),
        }
    }
}

impl From<JoinError> for CommandError {
    fn from(error: JoinError) -> Self {
        let message = error.to_string();
        let shown = |path: &Path| path.display().to_string();
        match error {
            JoinError::Database { path, source } => Self::database(&path, &source),
            JoinError::Nothing => Self::refused("no_share", "", message),
            JoinError::OtherWork { path, .. } => Self::refused("other_work", shown(&path), message),
            JoinError::OtherBits { tensor, .. } => Self::refused("other_bits", tensor, message),
            JoinError::Unfinished { path, .. } => Self::refused("unfinished_share", shown(&path), message),
            JoinError::Twice { path, .. } => Self::refused("share_twice", shown(&path), message),
            JoinError::Missing { share } => Self::refused("share_missing", share.to_string(), message),
            JoinError::Bake(error) => error.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_not_positive_is_an_option() {
        let error = CommandError::from(BakeError::NotPositive { key: "gamma", value: 0.0 });
        assert_eq!(error.line(), "not_positive: --gamma is 0; it must be a finite number above 0");
        let error = CommandError::from(BakeError::NotPositive { key: "gamma", value: 1e-320 });
        assert!(error.message().starts_with("--gamma is 1e-320; it must be a finite number of at least 2.2"));
    }

    #[test]
    fn a_line_names_the_offending_input_once() {
        for (at, message, wanted) in [
            ("a\nb", "object name \"a\\nb\" is invalid", "object_name: object name \"a\\nb\" is invalid"),
            ("a\nb", "the file a\nb is empty", "object_name: the file a\\nb is empty"),
            ("a\nb", "it is empty", "object_name: it is empty (at a\\nb)"),
            ("", "it is empty", "object_name: it is empty"),
        ] {
            assert_eq!(CommandError::refused("object_name", at, message).line(), wanted);
        }
        assert_eq!(interrupt::ended().line().matches("interrupted").count(), 1);
    }

    #[test]
    fn errors_of_a_scene_name_its_file_and_keep_the_key() {
        let error = CommandError::refused("configuration", "objects.a.material", "objects.a.material: missing");
        let error = error.of_scene(Path::new("shop.toml"));
        assert_eq!(
            (error.at.as_str(), error.message()),
            ("objects.a.material", "shop.toml: objects.a.material: missing")
        );
    }
}
