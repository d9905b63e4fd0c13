//! Points of the study: a value of a setting with its times and errors.

use serde_json::{Map, Value, json};
use shatter_fracture::accuracy::{BARS_MIN, is_hidden};
use shatter_fracture::random::RandomStream;

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
    /// Elastic energy of the lattice's shape.
    Geometry,
}

/// Number of measures.
const COUNT: usize = 13;

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
        Self::Geometry,
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
            Self::Geometry => "geometry_error",
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
            Self::Geometry => "elastic energy of the lattice's shape, relative error",
        }
    }
}

/// Number of resamples of an interval.
const RESAMPLES: usize = 1000;

/// Seed of the resamples.
const RESAMPLE_SEED: u64 = 27;

/// Ends of the interval that holds a median with 95 % confidence, as shares of the resampled medians.
const INTERVAL: [f64; 2] = [0.025, 0.975];

/// Spread of an error over impacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorSpread {
    /// Interval of the median, 95 %, by the bootstrap (B. Efron, 1979).
    pub median: [f64; 2],
    /// Ninth decile.
    pub p90: f64,
}

/// One error.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MeasuredError {
    value: f64,
    /// Error bar of the reference; `None` for references without one.
    bar: Option<f64>,
    spread: Option<ErrorSpread>,
}

/// Errors, as far as they were measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointErrors([Option<MeasuredError>; COUNT]);

impl PointErrors {
    /// Adds an error.
    #[must_use]
    pub fn with(mut self, measure: Measure, value: f64) -> Self {
        self.0[measure as usize] = Some(MeasuredError { value, bar: None, spread: None });
        self
    }

    /// Adds an error against a reference with an error bar.
    #[must_use]
    pub fn with_bar(mut self, measure: Measure, [value, bar]: [f64; 2]) -> Self {
        self.0[measure as usize] = Some(MeasuredError { value, bar: Some(bar), spread: None });
        self
    }

    /// Adds the errors of `other` that are missing here.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k].or(other.0[k])))
    }

    /// Value of one kind; three bars of the reference where the error is below that.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        let own = self.0[measure as usize]?;
        let least = own.bar.map_or(0.0, |bar| BARS_MIN * bar);
        Some(if self.is_at_most(measure) { least } else { own.value })
    }

    /// Whether the error is so small that the reference's bar hides it: then [`Self::get`] is an upper bound.
    pub fn is_at_most(&self, measure: Measure) -> bool {
        self.0[measure as usize].is_some_and(|own| own.bar.is_some_and(|bar| is_hidden(own.value, bar)))
    }

    /// Error bar of the reference.
    pub fn bar(&self, measure: Measure) -> Option<f64> {
        self.0[measure as usize]?.bar
    }

    /// Spread over impacts, of medians.
    pub fn spread(&self, measure: Measure) -> Option<ErrorSpread> {
        self.0[measure as usize]?.spread
    }

    /// Medians over impacts, of those that have the error, with their spread.
    pub fn medians(all: &[Self]) -> Self {
        let median = |k: usize| {
            let own: Vec<MeasuredError> = all.iter().filter_map(|own| own.0[k]).collect();
            let values: Vec<f64> = own.iter().map(|own| own.value).collect();
            let bars: Vec<f64> = own.iter().filter_map(|own| own.bar).collect();
            let spread = Some(ErrorSpread { median: interval(&values)?, p90: quantile(&values, 0.9)? });
            Some(MeasuredError { value: quantile(&values, 0.5)?, bar: quantile(&bars, 0.5), spread })
        };
        Self(std::array::from_fn(median))
    }

    /// Text of an error: `≤` before an upper bound; `None` if it was not measured.
    pub fn text(&self, measure: Measure) -> Option<String> {
        let sign = if self.is_at_most(measure) { "≤ " } else { "" };
        Some(format!("{sign}{}", crate::report::significant(self.get(measure)?, 3)))
    }

    /// JSON document of a median with its bar, interval and ninth decile; null if it was not measured.
    pub(super) fn document(&self, measure: Measure) -> Value {
        let Some(spread) = self.spread(measure) else { return Value::Null };
        json!({
            "median": self.get(measure),
            "at_most": self.is_at_most(measure),
            "bar": self.bar(measure),
            "median_interval": spread.median,
            "p90": spread.p90,
        })
    }

    /// JSON document of bar, interval and ninth decile of every error.
    fn details(&self) -> Value {
        let detail = |measure: Measure| {
            let spread = self.spread(measure)?;
            let value = json!({
                "bar": self.bar(measure),
                "at_most": self.is_at_most(measure),
                "median_interval": spread.median,
                "p90": spread.p90,
            });
            Some((measure.name().to_owned(), value))
        };
        Value::Object(Measure::ALL.into_iter().filter_map(detail).collect())
    }
}

/// Interval of the median of `values` by the bootstrap; `None` without values.
fn interval(values: &[f64]) -> Option<[f64; 2]> {
    let mut stream = RandomStream::new(RESAMPLE_SEED, values.len() as u64);
    let mut drawn = || values[(stream.uniform() * values.len() as f64) as usize];
    if values.is_empty() {
        return None;
    }
    let mut resample = || quantile(&values.iter().map(|_| drawn()).collect::<Vec<_>>(), 0.5);
    let medians: Vec<f64> = (0..RESAMPLES).filter_map(|_| resample()).collect();
    let [low, high] = INTERVAL.map(|share| quantile(&medians, share));
    Some([low?, high?])
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
pub(super) fn quantile(values: &[f64], share: f64) -> Option<f64> {
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
    /// `details` has the reference's error bar, the interval of the median and the ninth decile of every error.
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
        map.insert("details".to_owned(), self.errors.details());
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
    fn an_error_below_three_bars_is_an_upper_bound() {
        let film = PointErrors::default().with_bar(Measure::Energy, [0.002, 0.001]).with(Measure::Gap, 0.01);
        let game = PointErrors::default().with_bar(Measure::Energy, [0.05, 0.001]);
        let errors = PointErrors::medians(&[film, film, film]);
        assert!(errors.is_at_most(Measure::Energy) && !errors.is_at_most(Measure::Gap));
        assert_eq!(errors.get(Measure::Energy), Some(0.003));
        assert_eq!(errors.text(Measure::Energy).unwrap(), "≤ 0.00300");
        assert!(!game.is_at_most(Measure::Energy) && game.text(Measure::Energy).unwrap() == "0.0500");
        let point = StudyPoint {
            setting: "preset",
            value: "film".into(),
            preset: Some("film"),
            times: PointTimes::default(),
            errors,
        };
        let document = point.document();
        assert_eq!(document["energy_error"], 0.003);
        assert_eq!(document["details"]["energy_error"]["at_most"], true);
        assert_eq!(document["details"]["energy_error"]["bar"], 0.001);
        assert_eq!(document["details"]["cvd_gap"]["median_interval"], json!([0.01, 0.01]));
    }

    #[test]
    fn intervals_hold_the_median_and_are_the_same_every_time() {
        let values: Vec<f64> = (0..24).map(f64::from).collect();
        let [low, high] = interval(&values).unwrap();
        assert!((3.0..11.5).contains(&low) && (11.5..20.0).contains(&high), "{low} {high}");
        assert_eq!(interval(&values), interval(&values));
        assert_eq!(interval(&[]), None);
    }

    #[test]
    fn times_have_quantiles() {
        let times = PointTimes((0..=100).rev().map(f64::from).collect());
        assert_eq!([0.1, 0.5, 0.99].map(|share| times.at(share)), [10.0, 50.0, 99.0]);
        assert_eq!(PointTimes::default().at(0.5), 0.0);
    }
}
