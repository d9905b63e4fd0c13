//! Work-precision diagrams as SVG, by `plotters`: errors to the right, times upwards, both logarithmic.

use super::plot::{COLOURS, GRID, PlotError, SIZE, range, shown_number};
use plotters::coord::Shift;
use plotters::prelude::*;

/// One setting of one dial.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Error.
    pub x: f64,
    /// Time, its median.
    pub y: f64,
    /// Lower end of the whisker.
    pub low: f64,
    /// Upper end of the whisker.
    pub high: f64,
    /// What it is set to.
    pub label: String,
}

/// Settings of one dial.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The dial.
    pub name: String,
    /// In the order in which they are joined.
    pub places: Vec<Place>,
    /// Whether they stand for themselves: dark and not joined.
    pub marked: bool,
}

/// Half the width of the ends of whiskers, pixels.
const CAP: i32 = 3;

/// Colour of what is marked, and of the lines across.
const INK: RGBColor = RGBColor(40, 42, 48);

/// An SVG document with all `curves` and lines across at the heights of `levels`; places that are not finite and positive are left out.
pub fn svg(x: &str, y: &str, curves: &[Curve], levels: &[f64]) -> Result<String, PlotError> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let shown = |place: &&Place| [place.x, place.y, place.low, place.high].into_iter().all(positive);
    let kept: Vec<Curve> = curves
        .iter()
        .map(|curve| Curve { places: curve.places.iter().filter(shown).cloned().collect(), ..curve.clone() })
        .collect();
    let places = || kept.iter().flat_map(|curve| &curve.places);
    let right = range(places().map(|place| place.x), true);
    let up = range(places().flat_map(|place| [place.low, place.high]).chain(levels.iter().copied()), true);
    // Room for labels and the legend.
    let (right, up) = (right.start / 1.2..right.end * 1.5, up.start / 1.2..up.end * 1.6);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(PlotError::new)?;
        draw(&area, [right, up], [x, y], &kept, levels)?;
        area.present().map_err(PlotError::new)?;
    }
    Ok(text)
}

fn draw(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    [right, up]: [std::ops::Range<f64>; 2],
    [x, y]: [&str; 2],
    curves: &[Curve],
    levels: &[f64],
) -> Result<(), PlotError> {
    let mut builder = ChartBuilder::on(area);
    builder.margin(16).x_label_area_size(44).y_label_area_size(64);
    let (from, to) = (right.start, right.end);
    let mut chart = builder.build_cartesian_2d(right.log_scale(), up.log_scale()).map_err(PlotError::new)?;
    chart
        .configure_mesh()
        .x_desc(x)
        .y_desc(y)
        .x_label_formatter(&|value| shown_number(*value))
        .y_label_formatter(&|value| shown_number(*value))
        .x_labels(6)
        .max_light_lines(1)
        .bold_line_style(GRID)
        .label_style(("sans-serif", 13))
        .draw()
        .map_err(PlotError::new)?;
    let small = ("sans-serif", 11).into_font();
    for &level in levels {
        let line = PathElement::new(vec![(from, level), (to, level)], INK.mix(0.35));
        chart.draw_series([line]).map_err(PlotError::new)?;
        let name = EmptyElement::at((to, level)) + Text::new(format!("{level} ms"), (-48, -14), small.clone());
        chart.draw_series([name]).map_err(PlotError::new)?;
    }
    let colours = COLOURS.iter().cycle();
    for (curve, colour) in curves.iter().zip(colours).map(|(curve, own)| (curve, if curve.marked { INK } else { *own }))
    {
        let style = colour.stroke_width(2);
        let joined = if curve.marked { &[] } else { curve.places.as_slice() };
        chart
            .draw_series(LineSeries::new(joined.iter().map(|place| (place.x, place.y)), style))
            .map_err(PlotError::new)?
            .label(curve.name.as_str())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], style));
        for place in &curve.places {
            let thin = colour.stroke_width(1);
            let whisker = PathElement::new(vec![(place.x, place.low), (place.x, place.high)], thin);
            chart.draw_series([whisker]).map_err(PlotError::new)?;
            let cap = |at| EmptyElement::at((place.x, at)) + PathElement::new(vec![(-CAP, 0), (CAP, 0)], thin);
            chart.draw_series([cap(place.low), cap(place.high)]).map_err(PlotError::new)?;
            let radius = if curve.marked { 5 } else { 3 };
            let dot = EmptyElement::at((place.x, place.y))
                + Circle::new((0, 0), radius, colour.filled())
                + Text::new(place.label.clone(), (6, -14), small.clone().color(&colour));
            chart.draw_series([dot]).map_err(PlotError::new)?;
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(GRID)
        .label_font(("sans-serif", 13))
        .draw()
        .map_err(PlotError::new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagrams_show_settings_whiskers_and_levels_and_leave_out_zeros() {
        let place = |x: f64, label: &str| Place { x, y: 2.0, low: 0.5, high: 20.0, label: label.to_owned() };
        let curve =
            Curve { name: "a dial".into(), places: vec![place(0.01, "one"), place(0.0, "absent")], marked: false };
        let marked = Curve { name: "presets".into(), places: vec![place(0.1, "game")], marked: true };
        let text = svg("error", "time", &[curve, marked], &[1.0, 16.7]).unwrap();
        assert!(["a dial", "one", "game", "16.7 ms", "error", "time"].iter().all(|word| text.contains(word)));
        assert!(!text.contains("absent") && !text.contains("NaN"));
        svg("error", "time", &[], &[1.0]).unwrap();
    }
}
