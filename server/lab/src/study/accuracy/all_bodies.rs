//! Elastic energies of the presets over all bodies: medians of the bodies' medians.

use super::{BodyPoint, Measure, PointErrors};
use serde_json::{Value, json};

/// Name in the table of the bodies.
pub(super) const NAME: &str = "all bodies";

/// Error of the elastic energy of a preset over all bodies, of the impacts that were reduced.
#[derive(Clone, Debug, PartialEq)]
pub struct AllBodiesPoint {
    /// Name of the preset.
    pub preset: &'static str,
    /// Number of bodies with reduced impacts.
    pub bodies: usize,
    /// Median over these bodies of their median errors. The interval is by the bootstrap over the bodies.
    pub reduced: PointErrors,
}

impl AllBodiesPoint {
    /// Points of the presets that have bodies, in the order of their first bodies.
    pub fn all(points: &[BodyPoint]) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for point in points {
            if all.iter().any(|known| known.preset == point.preset) {
                continue;
            }
            let of_preset = points.iter().filter(|own| own.preset == point.preset);
            let errors: Vec<PointErrors> = of_preset.map(|own| own.by_method[0]).collect();
            let bodies = errors.iter().filter(|own| own.get(Measure::Energy).is_some()).count();
            all.push(Self { preset: point.preset, bodies, reduced: PointErrors::medians(&errors) });
        }
        all
    }

    /// JSON document of the point.
    pub fn document(&self) -> Value {
        json!({
            "preset": self.preset,
            "bodies": self.bodies,
            "energy_error_reduced": self.reduced.document(Measure::Energy),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(preset: &'static str, reduced: Option<f64>) -> BodyPoint {
        let error = |value| PointErrors::default().with_bar(Measure::Energy, [value, 0.001]);
        let reduced = reduced.map_or_else(PointErrors::default, |value| PointErrors::medians(&[error(value)]));
        BodyPoint {
            body: "body".to_owned(),
            preset,
            nodes: 1,
            // Of all impacts, and of solved ones: neither may count.
            errors: error(0.5),
            by_method: [reduced, error(0.7)],
            lattice: PointErrors::default(),
            is_quadratic: false,
            order: None,
            solved: 0.5,
            reference_s: 0.0,
        }
    }

    #[test]
    fn the_median_is_over_bodies_with_reduced_impacts_of_one_preset() {
        let game = [Some(0.04), None, Some(0.09), Some(0.01)].map(|error| body("game", error));
        let points: Vec<BodyPoint> = [body("draft", None)].into_iter().chain(game).collect();
        let [draft, game] = &AllBodiesPoint::all(&points)[..] else { panic!("two presets") };
        assert_eq!((draft.preset, draft.bodies, draft.reduced.get(Measure::Energy)), ("draft", 0, None));
        assert!(draft.document()["energy_error_reduced"].is_null());
        assert_eq!((game.preset, game.bodies), ("game", 3));
        let error = &game.document()["energy_error_reduced"];
        assert_eq!((&error["median"], &error["at_most"], &error["bar"]), (&json!(0.04), &json!(false), &json!(0.001)));
        let interval = [0, 1].map(|end| error["median_interval"][end].as_f64().unwrap());
        assert_eq!(interval, [0.01, 0.09], "bodies are resampled");
    }
}
