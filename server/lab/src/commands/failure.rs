//! Conversion of lab errors to errors of commands.

use crate::study::accuracy::StudyError;
use crate::study::effects::EffectsError;
use crate::study::examples::ExamplesError;
use crate::study::paper::PaperError;
use shatter_server::commands::CommandError;

impl From<EffectsError> for CommandError {
    fn from(error: EffectsError) -> Self {
        match error {
            EffectsError::Refused(error) => error.into(),
            EffectsError::Bake(error) => error.into(),
            EffectsError::Hold(error) => Self::refused("configuration", "anchors", error.to_string()),
            EffectsError::Whole(_) => Self::refused("study", "object", error.to_string()),
            EffectsError::Warp(_) | EffectsError::Plot(_) | EffectsError::Picture(_) | EffectsError::Materials(_) => {
                Self::ours("study", error.to_string())
            }
        }
    }
}

impl From<StudyError> for CommandError {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Bake(error) => error.into(),
            StudyError::Plot(_) => Self::ours("study", error.to_string()),
            error => Self::refused("study", "object", error.to_string()),
        }
    }
}

impl From<PaperError> for CommandError {
    fn from(error: PaperError) -> Self {
        match error {
            PaperError::Bake(error) => error.into(),
            PaperError::Strike(error) => error.into(),
            error => Self::refused("study", "object", error.to_string()),
        }
    }
}

impl From<ExamplesError> for CommandError {
    fn from(error: ExamplesError) -> Self {
        let message = error.to_string();
        match error {
            ExamplesError::Nothing => Self::refused("no_examples", "", message),
            ExamplesError::Plot(_) | ExamplesError::Picture(_) => Self::ours("page", message),
        }
    }
}
