//! Line plots as SVG, by `plotters`; each axis is linear or logarithmic.

use super::ticks::ticks;
use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, LogCoord, WithKeyPoints};
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;

/// Named line.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotLine {
    /// Name in the legend.
    pub name: String,
    /// Points of the line.
    pub points: Vec<(f64, f64)>,
    /// Style of the points.
    pub mark: PlotMark,
}

/// Style of points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlotMark {
    /// Joined, with a dot at each point.
    #[default]
    Both,
    /// Joined.
    Line,
    /// Small dots.
    Dots,
}

/// Axes of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// Label of the horizontal axis, with unit.
    pub x: String,
    /// Label of the vertical axis, with unit.
    pub y: String,
    /// Whether the horizontal axis is logarithmic.
    pub log_x: bool,
    /// Whether the vertical axis is logarithmic.
    pub log_y: bool,
}

/// Error of drawing a plot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("plot: {0}")]
pub struct PlotError(String);

impl PlotError {
    /// Wraps an error of the drawing library.
    pub(super) fn new(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}

pub(super) const SIZE: (u32, u32) = (760, 460);
pub(super) const COLORS: [RGBColor; 5] = [
    RGBColor(196, 92, 46),
    RGBColor(46, 108, 168),
    RGBColor(72, 138, 84),
    RGBColor(132, 84, 160),
    RGBColor(90, 94, 102),
];
/// Color of grid lines.
pub(super) const GRID: RGBColor = RGBColor(226, 223, 216);

/// SVG document with all `lines`; omits points that are not finite, or not positive on a logarithmic axis.
pub fn svg(axes: &Axes, lines: &[PlotLine]) -> Result<String, PlotError> {
    let shown =
        |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite() && (!axes.log_x || x > 0.0) && (!axes.log_y || y > 0.0);
    let kept: Vec<PlotLine> = lines
        .iter()
        .map(|line| PlotLine { points: line.points.iter().copied().filter(shown).collect(), ..line.clone() })
        .collect();
    let x = range(kept.iter().flat_map(|line| &line.points).map(|point| point.0), axes.log_x);
    let y = range(kept.iter().flat_map(|line| &line.points).map(|point| point.1), axes.log_y);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE).map_err(PlotError::new)?;
        match (axes.log_x, axes.log_y) {
            (false, false) => draw(&area, x, y, axes, &kept),
            (true, false) => draw(&area, marked(x), y, axes, &kept),
            (false, true) => draw(&area, x, marked(y), axes, &kept),
            (true, true) => draw(&area, marked(x), marked(y), axes, &kept),
        }?;
        area.present().map_err(PlotError::new)?;
    }
    Ok(text)
}

/// Logarithmic axis.
pub(super) fn marked(range: Range<f64>) -> WithKeyPoints<LogCoord<f64>> {
    let marks = ticks(&range);
    range.log_scale().with_key_points(marks)
}

/// Range of the values with a margin; a default range without values.
pub(super) fn range(values: impl Iterator<Item = f64> + Clone, log: bool) -> Range<f64> {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    match (low.is_finite() && high.is_finite(), log) {
        (false, _) => 1.0..10.0,
        (true, true) => low / 1.25..high * 1.25,
        (true, false) => {
            let margin = 0.05 * (high - low).max(1e-3 * high.abs()).max(f64::MIN_POSITIVE);
            low - margin..high + margin
        }
    }
}

fn draw<'a, X, Y>(
    area: &DrawingArea<SVGBackend<'a>, Shift>,
    x: X,
    y: Y,
    axes: &Axes,
    lines: &[PlotLine],
) -> Result<(), PlotError>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
{
    let mut builder = ChartBuilder::on(area);
    builder.margin(16).x_label_area_size(44).y_label_area_size(64);
    let mut chart = builder.build_cartesian_2d(x, y).map_err(PlotError::new)?;
    chart
        .configure_mesh()
        .x_desc(axes.x.as_str())
        .y_desc(axes.y.as_str())
        .x_label_formatter(&|value| shown_number(*value))
        .y_label_formatter(&|value| shown_number(*value))
        .max_light_lines(1)
        .bold_line_style(GRID)
        .label_style(("sans-serif", 13))
        .draw()
        .map_err(PlotError::new)?;
    for (line, color) in lines.iter().zip(COLORS.iter().cycle()) {
        let style = color.stroke_width(2);
        let joined = if line.mark == PlotMark::Dots { &[] } else { line.points.as_slice() };
        chart
            .draw_series(LineSeries::new(joined.iter().copied(), style))
            .map_err(PlotError::new)?
            .label(line.name.as_str())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], style));
        let (dotted, radius) = match line.mark {
            PlotMark::Both => (line.points.as_slice(), 3),
            PlotMark::Line => (&[][..], 0),
            PlotMark::Dots => (line.points.as_slice(), 1),
        };
        chart
            .draw_series(dotted.iter().map(|&point| Circle::new(point, radius, color.filled())))
            .map_err(PlotError::new)?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(GRID)
        .label_font(("sans-serif", 13))
        .draw()
        .map_err(PlotError::new)
}

/// Format of a number on an axis.
pub(super) fn shown_number(value: f64) -> String {
    let value = rounded(value);
    if (1e-3..1e5).contains(&value.abs()) || value == 0.0 { format!("{value}") } else { format!("{value:e}") }
}

/// Removes rounding errors from a number on an axis.
fn rounded(value: f64) -> f64 {
    if value.abs() < 1e-14 { 0.0 } else { format!("{value:.10e}").parse().unwrap_or(value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(log_x: bool, log_y: bool, points: Vec<(f64, f64)>) -> String {
        let axes = Axes { x: "to the right".into(), y: "upwards".into(), log_x, log_y };
        let mark = [PlotMark::Both, PlotMark::Line, PlotMark::Dots][usize::from(log_x) + usize::from(log_y)];
        svg(&axes, &[PlotLine { name: "a line".into(), points, mark }]).unwrap()
    }

    #[test]
    fn plots_name_what_they_show() {
        for (log_x, log_y) in [(false, false), (true, false), (false, true), (true, true)] {
            let text = check(log_x, log_y, vec![(1.0, 1e-6), (10.0, 1e3)]);
            assert!(text.starts_with("<svg") && text.contains("a line") && text.contains("upwards"));
        }
    }

    #[test]
    fn what_cannot_be_shown_is_left_out() {
        let text = check(true, true, vec![(0.0, 1.0), (f64::NAN, 2.0), (1.0, f64::INFINITY)]);
        assert!(!text.contains("NaN") && !text.contains("inf"));
        check(false, false, Vec::new());
        check(false, false, vec![(1.0, 1.0)]);
    }
}
