//! Page on what a database has learned: predicted against optimized degree, distribution of errors, and contacts of the examples.

use super::plot::{Axes, PlotError, PlotLine, PlotMark, svg};
use crate::picture::{
    Backdrop, CREASE_DEG, Camera, Color, DrawnMesh, PictureError, PictureSize, Projection, RenderStyle, arrow, draw,
};
use crate::report::{Fact, ReportFigure, Section, Study, share};
use nalgebra::{Point3, Vector3};
use shatter_fracture::degree::{self, SITES_MIN, TrainingSample};
use shatter_fracture::pipeline::{LearnedModel, PreparedObject};

/// Error of the page.
#[derive(Debug, thiserror::Error)]
pub enum ExamplesError {
    /// The database has learned nothing.
    #[error("the database has no examples, or too few to learn from")]
    Nothing,
    /// A plot could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A picture could not be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// Number of bars of the histogram, and the relative error at its ends.
const BARS: usize = 40;
const ERROR_MAX: f64 = 0.5;

const SIZE: PictureSize = PictureSize { width: 900, height: 680 };
const FROM: [f32; 3] = [0.6, 0.5, 1.0];
const LENS: Projection = Projection::Perspective { fov_deg: 24.0 };

/// Length of an arrow over the object's diagonal.
const ARROW: f64 = 0.05;

/// Label of an example, and its predictions without that example.
struct ExampleRow {
    optimized: f64,
    network: f64,
    closed_form: f64,
}

/// Page on what `prepared` has learned. Trains the network again to obtain the prediction for each example when that example is left
/// out.
pub fn page(prepared: &PreparedObject) -> Result<Study, ExamplesError> {
    let learned = prepared.learned.as_ref().ok_or(ExamplesError::Nothing)?;
    let rows = rows(prepared).ok_or(ExamplesError::Nothing)?;
    Ok(Study {
        title: format!("What {} has learned", prepared.name),
        lead: vec![
            "Impacts spread over the surface, each labeled by the full optimization at every threshold. A network learned from \
             them the number of fragments. Predictions for an example come from a network trained without it."
                .to_owned(),
        ],
        facts: facts(prepared, learned),
        sections: vec![against(&rows)?, spread(&rows)?, struck(prepared)?],
    })
}

fn rows(prepared: &PreparedObject) -> Option<Vec<ExampleRow>> {
    let each = prepared.examples.iter().enumerate();
    let samples: Vec<TrainingSample> = each.flat_map(|(k, example)| example.samples(k)).collect();
    let trained = degree::train(&samples, prepared.parameters.seed)?;
    let labels = prepared.examples.iter().flat_map(|example| example.labels());
    let one = |((_, estimate, sites), left_out): ((f64, f64, u32), &f64)| ExampleRow {
        optimized: f64::from(sites),
        network: degree::sites(*left_out, estimate).max(2.0),
        closed_form: (prepared.kappa * estimate).max(2.0),
    };
    Some(labels.zip(&trained.left_out).map(one).collect())
}

fn facts(prepared: &PreparedObject, learned: &LearnedModel) -> Vec<Fact> {
    let quality = &learned.quality;
    let both = |median: f64, p90: f64| format!("{}, nine of ten {}", share(median), share(p90));
    let mut facts = vec![
        Fact::new("Examples", prepared.examples.len().to_string()),
        Fact::new("Network", both(quality.median_relative_error, quality.p90_relative_error)),
        Fact::new("Closed form, κ of these examples", both(quality.closed_form_median, quality.closed_form_p90)),
        Fact::new("Network on the impact's pose instead", both(quality.pose_network_median, quality.pose_network_p90)),
        Fact::new("Labels from other starts", share(quality.label_noise_median)),
        Fact::new("Labels of 8 sites and more", quality.holdout.to_string()),
    ];
    facts.extend(quality.few_within_one.map(|within| {
        Fact::new(
            "Labels below 8 sites",
            format!("{}, {:.0} % of them off by one at most", quality.few_holdout, 100.0 * within),
        )
    }));
    facts.extend(prepared.reduction.iter().flat_map(|reduction| {
        let ranks: Vec<String> = reduction.rank.iter().map(usize::to_string).collect();
        [
            Fact::new("Reduced elasticity, rank", ranks.join(", ")),
            Fact::new("Its energy, other impacts", both(reduction.energy_error_median, reduction.energy_error_p90)),
            Fact::new("Its energy density", share(reduction.density_error_median)),
            Fact::new("Estimates within a factor 3", share(reduction.estimates_within_3)),
        ]
    }));
    facts
}

fn against(rows: &[ExampleRow]) -> Result<Section, PlotError> {
    let points = |of: fn(&ExampleRow) -> f64| rows.iter().map(|rows| (rows.optimized, of(rows))).collect();
    let most = rows.iter().map(|rows| rows.optimized).fold(2.0, f64::max);
    let lines = [
        PlotLine { name: "closed form".into(), points: points(|rows| rows.closed_form), mark: PlotMark::Dots },
        PlotLine { name: "network".into(), points: points(|rows| rows.network), mark: PlotMark::Dots },
        PlotLine { name: "ideal".into(), points: vec![(2.0, 2.0), (most, most)], mark: PlotMark::Line },
    ];
    let axes = Axes { x: "optimized degree".into(), y: "predicted degree".into(), log_x: true, log_y: true };
    Ok(Section {
        heading: "Predicted against optimized".to_owned(),
        plots: vec![(svg(&axes, &lines)?, "One dot per label.".to_owned())],
        ..Section::default()
    })
}

fn spread(rows: &[ExampleRow]) -> Result<Section, PlotError> {
    let counted: Vec<&ExampleRow> = rows.iter().filter(|rows| rows.optimized >= SITES_MIN as f64).collect();
    let line = |name: &str, of: fn(&ExampleRow) -> f64| PlotLine {
        name: name.to_owned(),
        points: histogram(counted.iter().map(|rows| of(rows) / rows.optimized - 1.0)),
        mark: PlotMark::Line,
    };
    let lines = [line("closed form", |rows| rows.closed_form), line("network", |rows| rows.network)];
    let axes = Axes { x: "Δn / n".into(), y: "labels".into(), log_x: false, log_y: false };
    Ok(Section {
        heading: "Distribution of errors".to_owned(),
        lead: vec!["Degrees of 8 and more; the end bars include all errors beyond them.".to_owned()],
        plots: vec![(svg(&axes, &lines)?, "Relative errors.".to_owned())],
        ..Section::default()
    })
}

/// Outline of a histogram from −[`ERROR_MAX`] to [`ERROR_MAX`].
fn histogram(values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
    let mut counts = [0.0; BARS];
    for value in values {
        let place = (value / ERROR_MAX + 1.0) * 0.5 * BARS as f64;
        counts[(place.max(0.0) as usize).min(BARS - 1)] += 1.0;
    }
    let edge = |bar: usize| (2.0 * bar as f64 / BARS as f64 - 1.0) * ERROR_MAX;
    counts.iter().enumerate().flat_map(|(bar, count)| [(edge(bar), *count), (edge(bar + 1), *count)]).collect()
}

/// Section with the object and an arrow per contact.
fn struck(prepared: &PreparedObject) -> Result<Section, PictureError> {
    let meter = prepared.frame.diagonal_m;
    let mut scene = DrawnMesh::default();
    for body in &prepared.bodies {
        let positions = body.crack.nodes.iter().map(|node| (node * meter).cast()).collect();
        let faces = body.crack.boundary().iter().map(|face| face.nodes).collect();
        scene.append(DrawnMesh::paint(positions, faces, CREASE_DEG, |_, _| Color::oklch(0.86, 0.02, 85.0)));
    }
    let ground = scene.bounds().0.y;
    for contact in prepared.examples.iter().flat_map(|example| &example.contacts) {
        let tip: Point3<f32> = Point3::from(contact.point_m - prepared.frame.center_m).cast();
        let length = (ARROW * meter) as f32;
        scene.append(arrow(tip, contact.impulse_ns.cast(), length, Color::oklch(0.55, 0.14, 40.0)));
    }
    let aspect = SIZE.width as f32 / SIZE.height as f32;
    let camera = Camera::fit(&scene.positions, Vector3::from(FROM), LENS, aspect);
    let png = draw(&scene, &camera, SIZE, RenderStyle::CHART, Some(ground), Backdrop::Clear).png()?;
    let caption = "Each arrow ends at a contact of an example and points along its impulse.".to_owned();
    Ok(Section {
        heading: "Contacts of the examples".to_owned(),
        figures: vec![ReportFigure { png, caption, scale: None }],
        ..Section::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_counts_everything_once() {
        let outline = histogram([-3.0, -0.5, 0.0, 0.01, 0.499, 0.5, 7.0].into_iter());
        let total: f64 = outline.chunks(2).map(|edges| edges[0].1).sum();
        assert_eq!((outline.len(), total), (2 * BARS, 7.0));
        assert_eq!((outline[0], outline[2 * BARS - 1]), ((-0.5, 2.0), (0.5, 3.0)));
    }
}
