//! Stacked bar charts as SVG, by `plotters`.

use super::plot::PlotError;
use plotters::prelude::*;

/// Segment of a bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Name in the legend.
    pub name: &'static str,
    /// Length in the unit of the axis.
    pub length: f64,
    /// Whether it is drawn as a hatched outline, for something that did not run.
    pub hatched: bool,
}

/// Bar of consecutive segments.
#[derive(Clone, Debug, PartialEq)]
pub struct StackedBar {
    /// Name of the bar.
    pub name: String,
    /// Segments; segments at the same position have the same color in all bars.
    pub segments: Vec<Segment>,
}

const WIDTH: u32 = 900;
const LEFT: i32 = 150;
const BAR: i32 = 44;
const GAP: i32 = 18;
const ROW: i32 = 20;
const COLUMNS: usize = 5;
const STROKES: i32 = 7;

/// SVG document with all `bars` on one scale from zero; `unit` is the label of the axis.
pub fn svg(bars: &[StackedBar], unit: &str) -> Result<String, PlotError> {
    let longest = bars.iter().map(|bar| bar.segments.iter().map(|segment| segment.length).sum::<f64>());
    let scale = f64::from(WIDTH as i32 - LEFT - 20) / longest.fold(f64::MIN_POSITIVE, f64::max);
    let names: Vec<&str> = bars.first().into_iter().flat_map(|bar| &bar.segments).map(|segment| segment.name).collect();
    let bottom = GAP + bars.len() as i32 * (BAR + GAP) + 34;
    let height = bottom + (names.len().div_ceil(COLUMNS) as i32 + 1) * ROW;
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH, height as u32)).into_drawing_area();
        area.fill(&WHITE).map_err(PlotError::new)?;
        let font = ("sans-serif", 13).into_font();
        for (row, bar) in bars.iter().enumerate() {
            let top = GAP + row as i32 * (BAR + GAP);
            area.draw(&Text::new(bar.name.clone(), (8, top + BAR / 2 - 7), font.clone())).map_err(PlotError::new)?;
            let mut from = 0.0;
            for (place, segment) in bar.segments.iter().enumerate() {
                let [left, right] = [from, from + segment.length].map(|x| LEFT + (x * scale).round() as i32);
                from += segment.length;
                let corners = [(left, top), (right, top + BAR)];
                let color = Palette99::pick(place).to_rgba();
                if segment.hatched {
                    for stroke in hatch(corners) {
                        area.draw(&PathElement::new(stroke, color.mix(0.55))).map_err(PlotError::new)?;
                    }
                    area.draw(&Rectangle::new(corners, color.mix(0.8))).map_err(PlotError::new)?;
                } else {
                    area.draw(&Rectangle::new(corners, color.filled())).map_err(PlotError::new)?;
                }
            }
        }
        for (x, label) in ticks(scale) {
            area.draw(&PathElement::new(vec![(x, bottom - 30), (x, bottom - 24)], BLACK)).map_err(PlotError::new)?;
            area.draw(&Text::new(label, (x - 4, bottom - 22), font.clone())).map_err(PlotError::new)?;
        }
        area.draw(&Text::new(unit.to_owned(), (8, bottom - 22), font.clone())).map_err(PlotError::new)?;
        let column = WIDTH as i32 / COLUMNS as i32;
        for (place, name) in names.iter().enumerate() {
            let (x, y) = (8 + (place % COLUMNS) as i32 * column, bottom + (place / COLUMNS) as i32 * ROW + 6);
            let color = Palette99::pick(place).to_rgba();
            area.draw(&Rectangle::new([(x, y), (x + 12, y + 12)], color.filled())).map_err(PlotError::new)?;
            area.draw(&Text::new((*name).to_owned(), (x + 18, y), font.clone())).map_err(PlotError::new)?;
        }
        area.present().map_err(PlotError::new)?;
    }
    Ok(text)
}

/// Positions and labels of about five round numbers on an axis with that many pixels per unit.
fn ticks(scale: f64) -> Vec<(i32, String)> {
    let longest = f64::from(WIDTH as i32 - LEFT - 20) / scale;
    let power = 10f64.powf((longest / 5.0).log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|step| longest / step <= 6.0).unwrap_or(longest);
    let label = |k: u32| f64::from(k) * step;
    let places = (0..).map(label).take_while(|value| *value <= longest);
    places
        .map(|value| {
            (
                LEFT + (value * scale).round() as i32,
                format!("{:.3}", value).trim_end_matches('0').trim_end_matches('.').to_owned(),
            )
        })
        .collect()
}

/// Slanted strokes inside a rectangle.
fn hatch([(left, top), (right, bottom)]: [(i32, i32); 2]) -> Vec<Vec<(i32, i32)>> {
    let height = bottom - top;
    let stroke = |start: i32| {
        let (from, to) = ((start - height).max(left), start.min(right));
        (from < to).then(|| vec![(from, bottom - (from - (start - height))), (to, top + (start - to))])
    };
    (left..right + height).step_by(STROKES as usize).filter_map(stroke).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_name_what_they_show_and_hatch_what_is_not_there() {
        let segment = |name, length, hatched| Segment { name, length, hatched };
        let bar = |hatched| StackedBar {
            name: "a bar".into(),
            segments: vec![segment("first", 2.0, hatched), segment("second", 1.0, false)],
        };
        let (full, off) = (svg(&[bar(false)], "ms").unwrap(), svg(&[bar(true)], "ms").unwrap());
        for word in ["a bar", "first", "second", "ms"] {
            assert!(full.contains(word), "{word}");
        }
        assert!(off.matches("<polyline").count() > full.matches("<polyline").count() + 20);
    }

    #[test]
    fn ticks_are_round_and_few() {
        for (longest, labels) in [(194.0, vec!["0", "50", "100", "150"]), (0.9, vec!["0", "0.2", "0.4", "0.6", "0.8"])]
        {
            let found = ticks(f64::from(WIDTH as i32 - LEFT - 20) / longest);
            assert_eq!(found.into_iter().map(|(_, label)| label).collect::<Vec<_>>(), labels);
        }
    }

    #[test]
    fn strokes_stay_inside() {
        for corners in [[(10, 5), (60, 25)], [(0, 0), (3, 40)], [(5, 5), (5, 9)]] {
            let [(left, top), (right, bottom)] = corners;
            let inside = |&(x, y): &(i32, i32)| (left..=right).contains(&x) && (top..=bottom).contains(&y);
            assert!(hatch(corners).iter().flatten().all(inside), "{:?}", hatch(corners));
        }
    }
}
