//! Plot of latency against load, as SVG.

use super::tally::LoadTally;
use plotters::prelude::*;

const SIZE: (u32, u32) = (760, 460);
const MARGIN: f64 = 1.3;

/// Curve: name, color, and value of a run in ms.
type Curve = (&'static str, RGBColor, fn(&LoadTally) -> f64);

const CURVES: [Curve; 3] = [
    ("median latency", RGBColor(72, 138, 84), |tally| tally.latency_ms().0),
    ("99th percentile", RGBColor(196, 92, 46), |tally| tally.latency_ms().1),
    ("99th percentile of an ideal queue", RGBColor(46, 108, 168), LoadTally::ideal_ms),
];

/// Latencies of all runs over their rates, with the highest throughput marked. `None` for fewer than two rates.
pub fn svg(runs: &[(f64, &LoadTally)]) -> Option<Result<String, String>> {
    let rates = runs.iter().map(|(rate, _)| *rate);
    let (low, high) = (rates.clone().fold(f64::INFINITY, f64::min), rates.fold(0.0, f64::max));
    (high > low).then(|| draw(runs, low, high).map_err(|error| error.to_string()))
}

fn draw(runs: &[(f64, &LoadTally)], low: f64, high: f64) -> Result<String, Box<dyn std::error::Error>> {
    let values = || runs.iter().flat_map(|(_, tally)| CURVES.map(|(.., value)| value(tally))).filter(|ms| *ms > 0.0);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(1e-3, f64::max));
    let (least, most) = (least.min(most) / MARGIN, most * MARGIN);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut builder = ChartBuilder::on(&area);
        builder.margin(16).x_label_area_size(44).y_label_area_size(64);
        let margin = 0.05 * (high - low);
        let mut chart = builder.build_cartesian_2d(low - margin..high + margin, (least..most).log_scale())?;
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("requests due per second").y_desc("from due time to result, ms").max_light_lines(1);
        mesh.bold_line_style(RGBColor(226, 223, 216)).label_style(("sans-serif", 13)).draw()?;
        for (name, color, value) in CURVES {
            let style = color.stroke_width(2);
            let points: Vec<(f64, f64)> = runs.iter().map(|(rate, tally)| (*rate, value(tally))).collect();
            chart.draw_series(points.iter().map(|&point| Circle::new(point, 3, color.filled())))?;
            let line = chart.draw_series(LineSeries::new(points, style))?;
            line.label(name).legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], style));
        }
        let saturation = runs.iter().map(|(_, tally)| tally.throughput_hz()).fold(0.0, f64::max);
        let gray = RGBColor(90, 94, 102).stroke_width(1);
        let mark = LineSeries::new([(saturation, least), (saturation, most)], gray);
        let mark = chart.draw_series(mark)?.label(format!("highest throughput: {saturation:.0} per second"));
        mark.legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], gray));
        let mut legend = chart.configure_series_labels();
        legend.position(SeriesLabelPosition::UpperLeft).background_style(WHITE.mix(0.85));
        legend.border_style(RGBColor(226, 223, 216)).label_font(("sans-serif", 13)).draw()?;
        area.present()?;
    }
    Ok(text)
}
