//! Work-precision diagrams as SVG, by `plotters`: error to the right, time upwards, both logarithmic.

mod labels;

use super::plot::{COLORS, GRID, PlotError, SIZE, marked, range, shown_number};
use labels::Labels;
use plotters::coord::Shift;
use plotters::coord::combinators::{LogCoord, WithKeyPoints};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::ops::Range;

/// Point of a diagram: one value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub struct SettingPoint {
    /// Error.
    pub x: f64,
    /// Median time.
    pub y: f64,
    /// Lower end of the whisker.
    pub low: f64,
    /// Upper end of the whisker.
    pub high: f64,
    /// Half the length of the horizontal whisker; 0: none.
    pub bar: f64,
    /// Value of the setting.
    pub label: String,
}

/// Curve of the values of one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct SettingCurve {
    /// Name of the setting.
    pub name: String,
    /// Points in the order in which they are joined.
    pub places: Vec<SettingPoint>,
    /// Whether the points are highlighted: dark and not joined.
    pub marked: bool,
}

/// Axes and annotations of a diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiagramFrame<'a> {
    /// Label of the horizontal axis.
    pub x: &'a str,
    /// Label of the vertical axis.
    pub y: &'a str,
    /// Note at the top: object and machine.
    pub note: &'a str,
    /// Heights of horizontal lines, ms.
    pub levels: &'a [f64],
}

/// Half the width of the ends of whiskers, pixels.
const CAP: i32 = 3;

/// Color of highlighted points and of horizontal lines.
const INK: RGBColor = RGBColor(40, 42, 48);

/// SVG document with all `curves` within `frame`; omits points that are not finite and positive.
pub fn svg(frame: &DiagramFrame<'_>, curves: &[SettingCurve]) -> Result<String, PlotError> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let shown = |place: &&SettingPoint| [place.x, place.y, place.low, place.high].into_iter().all(positive);
    let kept: Vec<SettingCurve> = curves
        .iter()
        .map(|curve| SettingCurve { places: curve.places.iter().filter(shown).cloned().collect(), ..curve.clone() })
        .collect();
    let places = || kept.iter().flat_map(|curve| &curve.places);
    let right = range(places().map(|place| place.x), true);
    let up = range(places().flat_map(|place| [place.low, place.high]).chain(frame.levels.iter().copied()), true);
    // Space for labels and the legend.
    let (right, up) = (right.start / 1.2..right.end * 1.5, up.start / 1.2..up.end * 1.6);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(PlotError::new)?;
        draw(&area, [right, up], frame, &kept)?;
        area.present().map_err(PlotError::new)?;
    }
    Ok(text)
}

type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<WithKeyPoints<LogCoord<f64>>, WithKeyPoints<LogCoord<f64>>>>;

fn draw(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    [right, up]: [Range<f64>; 2],
    frame: &DiagramFrame<'_>,
    curves: &[SettingCurve],
) -> Result<(), PlotError> {
    let mut builder = ChartBuilder::on(area);
    builder.margin(16).x_label_area_size(44).y_label_area_size(64);
    builder.caption(frame.note, ("sans-serif", 12).into_font().color(&INK));
    let ends = [right.start, right.end];
    let mut chart = builder.build_cartesian_2d(marked(right), marked(up)).map_err(PlotError::new)?;
    chart
        .configure_mesh()
        .x_desc(frame.x)
        .y_desc(frame.y)
        .x_label_formatter(&|value| shown_number(*value))
        .y_label_formatter(&|value| shown_number(*value))
        .bold_line_style(GRID)
        .label_style(("sans-serif", 13))
        .draw()
        .map_err(PlotError::new)?;
    let (across, down) = chart.plotting_area().get_pixel_range();
    let mut labels = Labels::within([across.start, down.start], [across.end, down.end]);
    levels(&mut chart, frame.levels, ends, &mut labels)?;
    let colored: Vec<(&SettingCurve, RGBColor)> = curves.iter().zip(COLORS.iter().cycle()).map(colored).collect();
    for (curve, color) in &colored {
        lines(&mut chart, curve, *color, &mut labels)?;
    }
    // Highlighted points are labeled first, closest to their points.
    let (marked, others): (Vec<_>, Vec<_>) = colored.into_iter().partition(|(curve, _)| curve.marked);
    for (curve, color) in marked.into_iter().chain(others) {
        names(&mut chart, curve, color, &mut labels)?;
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

fn colored<'a>((curve, own): (&'a SettingCurve, &RGBColor)) -> (&'a SettingCurve, RGBColor) {
    (curve, if curve.marked { INK } else { *own })
}

fn small() -> FontDesc<'static> {
    ("sans-serif", 11).into_font()
}

/// Draws horizontal lines with labels at their right ends.
fn levels(chart: &mut Chart, levels: &[f64], [from, to]: [f64; 2], labels: &mut Labels) -> Result<(), PlotError> {
    for &level in levels {
        let line = DashedPathElement::new([(from, level), (to, level)], 5, 4, INK.mix(0.7));
        chart.draw_series([line]).map_err(PlotError::new)?;
        let (x, y) = chart.backend_coord(&(to, level));
        labels.keep_free([x - 52, y - 15], [x, y]);
        labels.keep_free([chart.backend_coord(&(from, level)).0, y - 1], [x, y + 1]);
        let name = EmptyElement::at((to, level)) + Text::new(format!("{level} ms"), (-48, -14), small().color(&INK));
        chart.draw_series([name]).map_err(PlotError::new)?;
    }
    Ok(())
}

/// Draws a curve with its points and whiskers.
fn lines(chart: &mut Chart, curve: &SettingCurve, color: RGBColor, labels: &mut Labels) -> Result<(), PlotError> {
    let style = color.stroke_width(2);
    let joined = if curve.marked { &[] } else { curve.places.as_slice() };
    chart
        .draw_series(LineSeries::new(joined.iter().map(|place| (place.x, place.y)), style))
        .map_err(PlotError::new)?
        .label(curve.name.as_str())
        .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], style));
    for ends in joined.windows(2) {
        let [from, to] = [&ends[0], &ends[1]].map(|place| chart.backend_coord(&(place.x, place.y)));
        labels.keep_free_along([from.0, from.1], [to.0, to.1]);
    }
    for place in &curve.places {
        let thin = color.stroke_width(1);
        let whisker = PathElement::new(vec![(place.x, place.low), (place.x, place.high)], thin);
        chart.draw_series([whisker]).map_err(PlotError::new)?;
        if place.bar > 0.0 {
            // An axis of logarithms has no place for ends at or below 0.
            let ends = [(place.x - place.bar).max(0.1 * place.x), place.x + place.bar];
            let across = PathElement::new(ends.map(|x| (x, place.y)).to_vec(), thin);
            chart.draw_series([across]).map_err(PlotError::new)?;
        }
        let cap = |at| EmptyElement::at((place.x, at)) + PathElement::new(vec![(-CAP, 0), (CAP, 0)], thin);
        chart.draw_series([cap(place.low), cap(place.high)]).map_err(PlotError::new)?;
        let radius = if curve.marked { 5 } else { 3 };
        let dot = EmptyElement::at((place.x, place.y)) + Circle::new((0, 0), radius, color.filled());
        chart.draw_series([dot]).map_err(PlotError::new)?;
        let ((x, y), [(_, low), (_, high)]) = (
            chart.backend_coord(&(place.x, place.y)),
            [place.low, place.high].map(|end| chart.backend_coord(&(place.x, end))),
        );
        labels.keep_free([x - radius, y - radius], [x + radius, y + radius]);
        labels.keep_free([x - CAP, high], [x + CAP, low]);
    }
    Ok(())
}

/// Draws the labels of a curve's points.
fn names(chart: &mut Chart, curve: &SettingCurve, color: RGBColor, labels: &mut Labels) -> Result<(), PlotError> {
    for place in &curve.places {
        let (x, y) = chart.backend_coord(&(place.x, place.y));
        let [right, down] = labels.put([x, y], &place.label);
        let name =
            EmptyElement::at((place.x, place.y)) + Text::new(place.label.clone(), (right, down), small().color(&color));
        chart.draw_series([name]).map_err(PlotError::new)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diagrams_show_settings_whiskers_and_levels_and_leave_out_zeros() {
        let place = |x: f64, label: &str| SettingPoint {
            x,
            y: 2.0,
            low: 0.5,
            high: 20.0,
            bar: 0.3 * x,
            label: label.to_owned(),
        };
        let curve = SettingCurve {
            name: "a dial".into(),
            places: vec![place(0.01, "one"), place(0.0, "absent")],
            marked: false,
        };
        let marked = SettingCurve { name: "presets".into(), places: vec![place(0.1, "game")], marked: true };
        let frame = DiagramFrame { x: "error", y: "time", note: "of an object", levels: &[1.0, 16.7] };
        let text = svg(&frame, &[curve, marked]).unwrap();
        assert!(
            ["a dial", "one", "game", "16.7 ms", "error", "time", "of an object"]
                .iter()
                .all(|word| text.contains(word))
        );
        assert!(!text.contains("absent") && !text.contains("NaN"));
        svg(&frame, &[]).unwrap();
    }
}
