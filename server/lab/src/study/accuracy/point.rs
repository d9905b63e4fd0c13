//! Points of the study: a value of a setting with its times and errors.

use serde_json::{Map, Value};

/// Kind of error, defined in `shatter_fracture::accuracy`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Elastic energy.
    Energy,
    /// Strain energy density.
    Density,
    /// Fracture degree.
    Degree,
    /// Energy of the diagram.
    Gap,
    /// Distribution of fragment sizes.
    Size,
    /// Share of the volume with another label.
    Label,
    /// Mean distance of crack surfaces.
    CrackMean,
    /// Largest distance of crack surfaces.
    CrackMax,
    /// Volumes of the cells.
    Volume,
    /// Error that the result itself estimates.
    Estimate,
    /// Volume of pieces of cells that are detached from the largest piece.
    Stray,
    /// Distance of the lattice's boundary from the input's surface.
    Surface,
}

/// Number of measures.
const COUNT: usize = 12;

impl Measure {
    /// All kinds.
    pub const ALL: [Self; COUNT] = [
        Self::Energy,
        Self::Density,
        Self::Degree,
        Self::Gap,
        Self::Size,
        Self::Label,
        Self::CrackMean,
        Self::CrackMax,
        Self::Volume,
        Self::Estimate,
        Self::Stray,
        Self::Surface,
    ];

    /// Key in documents and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Energy => "energy_error",
            Self::Density => "density_error",
            Self::Degree => "degree_error",
            Self::Gap => "cvd_gap",
            Self::Size => "size_distance",
            Self::Label => "label_fraction",
            Self::CrackMean => "crack_distance_mean",
            Self::CrackMax => "crack_distance_max",
            Self::Volume => "volume_l1",
            Self::Estimate => "estimate",
            Self::Stray => "stray_volume",
            Self::Surface => "surface_deviation",
        }
    }

    /// Label of an axis.
    pub fn title(self) -> &'static str {
        match self {
            Self::Energy => "elastic energy, relative error",
            Self::Density => "strain energy density, relative L1 error",
            Self::Degree => "fracture degree, relative error",
            Self::Gap => "energy of the diagram above the best, relative",
            Self::Size => "fragment sizes, Wasserstein distance over the mean",
            Self::Label => "volume with another label, share",
            Self::CrackMean => "mean distance of cracks over the diagonal",
            Self::CrackMax => "largest distance of cracks over the diagonal",
            Self::Volume => "volumes of cells, relative L1 error",
            Self::Estimate => "estimated error",
            Self::Stray => "volume in detached pieces of cells, share",
            Self::Surface => "surface deviation over the diagonal",
        }
    }
}

/// Errors, as far as they were measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointErrors {
    values: [Option<f64>; COUNT],
    /// Flags of errors for which the reference is not fine enough.
    not_known: [bool; COUNT],
}

/// Text for an error whose reference is not fine enough.
pub const NOT_KNOWN: &str = "not known yet";

impl PointErrors {
    /// Adds an error.
    #[must_use]
    pub fn with(mut self, measure: Measure, value: f64) -> Self {
        self.values[measure as usize] = Some(value);
        self
    }

    /// Removes these errors and marks them as not known, because their reference is not fine enough.
    #[must_use]
    pub fn not_known(mut self, measures: &[Measure]) -> Self {
        for &measure in measures {
            (self.values[measure as usize], self.not_known[measure as usize]) = (None, true);
        }
        self
    }

    /// Whether the reference is not fine enough for this error.
    pub fn is_not_known(&self, measure: Measure) -> bool {
        self.not_known[measure as usize]
    }

    /// Adds the errors of `other` that are missing here.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            values: std::array::from_fn(|k| self.values[k].or(other.values[k])),
            not_known: std::array::from_fn(|k| self.not_known[k] || other.not_known[k]),
        }
    }

    /// Value of one kind.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        self.values[measure as usize]
    }

    /// Medians over impacts, of those that have the error.
    pub fn medians(all: &[Self]) -> Self {
        let values = |k: usize| all.iter().filter_map(|own| own.values[k]).collect::<Vec<_>>();
        Self {
            values: std::array::from_fn(|k| quantile(&values(k), 0.5)),
            not_known: std::array::from_fn(|k| all.iter().any(|own| own.not_known[k])),
        }
    }
}

/// Times of whole requests, ms.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointTimes(pub Vec<f64>);

impl PointTimes {
    /// Quantile of the times; 0 without times.
    pub fn at(&self, share: f64) -> f64 {
        quantile(&self.0, share).unwrap_or(0.0)
    }
}

/// Quantile by the nearest rank; `None` without values.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let low = (last as f64 * share).floor();
    let (from, to) = (sorted[low as usize], sorted[last.min(low as usize + 1)]);
    Some(from + (to - from) * (last as f64 * share - low))
}

/// Measured value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyPoint {
    /// Name of the setting.
    pub setting: &'static str,
    /// Value: a number or a name.
    pub value: Value,
    /// Name of the preset, if the point is one.
    pub preset: Option<&'static str>,
    /// Times.
    pub times: PointTimes,
    /// Median errors.
    pub errors: PointErrors,
}

impl StudyPoint {
    /// Value as text.
    pub fn label(&self) -> String {
        match &self.value {
            Value::Number(number) if number.is_f64() => {
                number.as_f64().map_or_else(|| number.to_string(), |x| crate::report::significant(x, 2))
            }
            Value::String(text) => text.clone(),
            other => other.to_string(),
        }
    }

    /// JSON document: numbers that are not finite and errors that were not measured are null.
    ///
    /// `not_known_yet` names the errors whose reference is not fine enough.
    pub fn document(&self) -> Value {
        let mut map = Map::new();
        map.insert("dial".to_owned(), self.setting.into());
        map.insert("value".to_owned(), self.value.clone());
        map.insert("preset".to_owned(), self.preset.into());
        for (key, share) in [("p10", 0.1), ("p50", 0.5), ("p90", 0.9), ("p99", 0.99)] {
            map.insert(format!("time_ms_{key}"), self.times.at(share).into());
        }
        for measure in Measure::ALL {
            map.insert(measure.name().to_owned(), self.errors.get(measure).into());
        }
        let not_known = Measure::ALL.into_iter().filter(|measure| self.errors.is_not_known(*measure));
        map.insert("not_known_yet".to_owned(), not_known.map(Measure::name).collect());
        Value::Object(map)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_leave_out_what_was_not_measured() {
        let one = PointErrors::default().with(Measure::Energy, 1.0).with(Measure::Gap, 4.0);
        let two = PointErrors::default().with(Measure::Energy, 3.0);
        let found = PointErrors::medians(&[one, two, PointErrors::default()]);
        assert_eq!(found.get(Measure::Energy), Some(2.0));
        assert_eq!(found.get(Measure::Gap), Some(4.0));
        assert_eq!(found.get(Measure::Size), None);
        assert!(Measure::ALL.iter().enumerate().all(|(place, measure)| *measure as usize == place));
    }

    #[test]
    fn an_error_without_a_fine_reference_is_not_known() {
        let measured = PointErrors::default().with(Measure::Energy, 0.009).with(Measure::Gap, 0.01);
        let errors = PointErrors::medians(&[measured, measured]).not_known(&[Measure::Energy]);
        assert_eq!([Measure::Energy, Measure::Gap].map(|measure| errors.get(measure)), [None, Some(0.01)]);
        let point = StudyPoint {
            setting: "preset",
            value: "film".into(),
            preset: Some("film"),
            times: PointTimes::default(),
            errors,
        };
        let document = point.document();
        assert_eq!(document["energy_error"], Value::Null);
        assert_eq!(document["not_known_yet"], serde_json::json!(["energy_error"]));
        assert!(PointErrors::medians(&[errors]).and(measured).is_not_known(Measure::Energy));
    }

    #[test]
    fn times_have_quantiles() {
        let times = PointTimes((0..=100).rev().map(f64::from).collect());
        assert_eq!([0.1, 0.5, 0.99].map(|share| times.at(share)), [10.0, 50.0, 99.0]);
        assert_eq!(PointTimes::default().at(0.5), 0.0);
    }
}
