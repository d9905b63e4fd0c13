//! Bar charts and color bars as inline SVG.

use super::figures::{grouped, nanoseconds, power_of_ten};
use super::text::escape;
use super::{Scale, StageTime};
use std::fmt::Write;

/// Number of colors in a legend's gradient.
const STOPS: usize = 24;

/// Minimum length of the bar of a stage that ran, % of the longest one.
const SHORTEST: f64 = 0.4;

/// Bars of the stages; all bars of a page share a linear scale that ends at `longest` nanoseconds.
pub(super) fn stages(stages: &[StageTime], longest: u64) -> String {
    let rows: String = stages.iter().map(|stage| row(stage, longest)).collect();
    let total: u64 = stages.iter().filter_map(|stage| stage.ns).sum();
    format!(
        "<div class=\"stages\">\n<h3>Time per stage</h3>\n<table>\n<tbody>\n{rows}</tbody>\n\
         <tfoot><tr><th scope=\"row\">sum</th><td></td><td>{}</td></tr></tfoot>\n</table>\n</div>\n",
        nanoseconds(total)
    )
}

fn row(stage: &StageTime, longest: u64) -> String {
    let name = escape(&stage.name);
    let Some(ns) = stage.ns else {
        return format!("<tr class=\"skipped\"><th scope=\"row\">{name}</th><td></td><td>did not run</td></tr>\n");
    };
    let width = (100.0 * ns as f64 / longest.max(1) as f64).max(SHORTEST);
    format!(
        "<tr><th scope=\"row\">{name}</th><td><svg viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" aria-hidden=\"true\">\
         <rect width=\"{width:.2}\" height=\"10\"/></svg></td><td>{}<small>{} ns</small></td></tr>\n",
        nanoseconds(ns),
        grouped(ns)
    )
}

/// Color bar of a picture with a tick per decade. `id` is the gradient's identifier within the page.
pub(super) fn legend(id: &str, scale: &Scale) -> String {
    let mut stops = String::new();
    for stop in 0..=STOPS {
        let share = stop as f32 / STOPS as f32;
        // Writing to a string cannot fail.
        let _ = write!(stops, "<stop offset=\"{share:.4}\" stop-color=\"{}\"/>", scale.ramp.at(share).hex());
    }
    let mut ticks = String::new();
    for (place, label) in decades(scale.low, scale.high) {
        let _ = write!(ticks, "<span style=\"left:{:.2}%\">{}</span>", 100.0 * place, escape(&label));
    }
    format!(
        "<div class=\"legend\"><p>{label}</p><svg viewBox=\"0 0 100 6\" preserveAspectRatio=\"none\" aria-hidden=\"true\">\
         <defs><linearGradient id=\"{id}\">{stops}</linearGradient></defs>\
         <rect width=\"100\" height=\"6\" fill=\"url(#{id})\"/></svg><div class=\"ticks\">{ticks}</div></div>\n",
        label = escape(&scale.label),
    )
}

/// Powers of ten between two positive values, with their positions from 0 to 1 on the logarithmic scale.
fn decades(low: f64, high: f64) -> Vec<(f64, String)> {
    let (first, last) = (low.log10(), high.log10());
    if !(first.is_finite() && last.is_finite() && last > first) {
        return Vec::new();
    }
    let powers = first.ceil() as i32..=last.floor() as i32;
    powers.map(|power| ((f64::from(power) - first) / (last - first), power_of_ten(power))).collect()
}
