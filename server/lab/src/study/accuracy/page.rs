//! Diagrams, their data as CSV, and the page.

use super::bodies;
use super::close_up;
use super::front::{PresetStanding, preset_standings};
use super::{AccuracyFindings, Measure, StudyError, StudyPoint};
use crate::report::{Fact, ReportTable, Section, Study, significant};
use crate::study::precision::{DiagramFrame, SettingCurve, SettingPoint, svg};

/// Frame times of games and films, ms.
const LEVELS_MS: [f64; 4] = [1.0, 4.0, 8.0, 16.7];

/// Definition of one diagram.
struct Diagram {
    /// File name without extension.
    file: &'static str,
    heading: &'static str,
    lead: &'static str,
    measures: &'static [Measure],
    settings: &'static [&'static str],
    /// Whether the presets are measured against the same reference.
    presets: bool,
}

const DIAGRAMS: [Diagram; 7] = [
    Diagram {
        file: "elasticity",
        heading: "Elasticity: spacing of the elastic lattice, rank of the reduced basis",
        lead: "Against the same lattice refined uniformly, extrapolated to spacing 0. Horizontal bars: error bar of the reference.",
        measures: &[Measure::Energy, Measure::Density, Measure::Degree],
        settings: &["elastic_spacing", "rank"],
        presets: true,
    },
    Diagram {
        file: "rank",
        heading: "Errors added by the reduced basis and by single precision of the factor",
        lead: "Against the solve on the same lattice, in double precision.",
        measures: &[Measure::Energy, Measure::Density],
        settings: &["rank_own_lattice", "factor_precision"],
        presets: false,
    },
    Diagram {
        file: "cvd",
        heading: "The diagram: tolerance of its descent",
        lead: "Against the best of several starts that were run to convergence. Starts differ, so no tolerance leads to zero.",
        measures: &[Measure::Gap, Measure::Size],
        settings: &["cvd_tolerance"],
        presets: true,
    },
    Diagram {
        file: "degree",
        heading: "Degree ablation: source of the number of fragments",
        lead: "Against the median of several full optimizations with other seeds.",
        measures: &[Measure::Degree],
        settings: &["degree"],
        presets: false,
    },
    Diagram {
        file: "cracks",
        heading: "Cracks: spacing of the crack lattice, labels of nodes or the exact diagram",
        lead: "The same sites, against their exact diagram on the finest crack lattice, in its lift.",
        measures: &[Measure::Label, Measure::CrackMean, Measure::CrackMax, Measure::Volume],
        settings: &["crack_spacing", "tessellation"],
        presets: true,
    },
    Diagram {
        file: "labels",
        heading: "Errors of node labels",
        lead: "The same sites on the same lattice, against the exact diagram there.",
        measures: &[Measure::Label, Measure::CrackMean, Measure::Volume],
        settings: &["node_labels"],
        presets: false,
    },
    Diagram {
        file: "lift",
        heading: "Lift ablation, and its dimension",
        lead: "Diagrams in each lift, judged in the one with the most eigenfunctions: its energy of the same labels above that of its \
               own best diagram; and volume of pieces that are cut off from the rest of their cell, as where a cell joins two legs.",
        measures: &[Measure::Gap, Measure::Stray],
        settings: &["lift_dimension", "lift"],
        presets: false,
    },
];

/// Drawn diagram with its data.
pub struct AccuracyDrawing {
    /// File name without extension.
    pub file: String,
    /// SVG.
    pub svg: String,
    /// Comma-separated values.
    pub csv: String,
    /// Index into [`DIAGRAMS`].
    diagram: usize,
    caption: String,
}

/// Draws all diagrams that have a point.
///
/// # Errors
/// [`StudyError::Plot`].
pub fn drawn(findings: &AccuracyFindings) -> Result<Vec<AccuracyDrawing>, StudyError> {
    let (mut all, ground) = (Vec::new(), &findings.ground);
    let note =
        format!("{}: {} crack nodes; {} threads of {}", ground.object, ground.nodes[1], ground.threads, ground.machine);
    let frame = DiagramFrame { x: "", y: "time of a whole request, ms", note: &note, levels: &LEVELS_MS };
    for (number, diagram) in DIAGRAMS.iter().enumerate() {
        for &measure in diagram.measures {
            let points: Vec<&StudyPoint> =
                findings.points.iter().filter(|point| shown(point, diagram, measure)).collect();
            if points.is_empty() {
                continue;
            }
            let curves: Vec<SettingCurve> = curves(diagram, measure, &points);
            all.push(AccuracyDrawing {
                file: format!("accuracy-{}-{}", diagram.file, measure.name()),
                svg: svg(&DiagramFrame { x: measure.title(), ..frame }, &curves)?,
                csv: csv(measure, &points),
                diagram: number,
                caption: format!(
                    "{}: medians over impacts without zeros; whiskers from the first to the last decile of times.",
                    measure.name()
                ),
            });
        }
    }
    Ok(all)
}

/// Errors of the diagrams with presets, and the points drawn for each.
pub(super) fn together(findings: &AccuracyFindings) -> Vec<(&'static str, Measure, Vec<&StudyPoint>)> {
    let own = DIAGRAMS.iter().filter(|diagram| diagram.presets);
    own.flat_map(|diagram| diagram.measures.iter().map(move |measure| (diagram, *measure)))
        .map(|(diagram, measure)| {
            let points = findings.points.iter().filter(|point| shown(point, diagram, measure)).collect();
            (diagram.file, measure, points)
        })
        .collect()
}

fn shown(point: &StudyPoint, diagram: &Diagram, measure: Measure) -> bool {
    (diagram.settings.contains(&point.setting) || diagram.presets && point.preset.is_some())
        && point.errors.get(measure).is_some()
}

fn curves(diagram: &Diagram, measure: Measure, points: &[&StudyPoint]) -> Vec<SettingCurve> {
    let place = |point: &&StudyPoint| {
        let name = point.preset.map_or_else(|| point.label(), str::to_owned);
        SettingPoint {
            x: point.errors.get(measure).unwrap_or(f64::NAN),
            y: point.times.at(0.5),
            low: point.times.at(0.1),
            high: point.times.at(0.9),
            bar: point.errors.bar(measure).unwrap_or(0.0),
            label: if point.errors.is_at_most(measure) { format!("≤ {name}") } else { name },
        }
    };
    let of = |setting: &&str| SettingCurve {
        name: (*setting).to_owned(),
        places: points.iter().filter(|point| point.setting == *setting && point.preset.is_none()).map(place).collect(),
        marked: false,
    };
    let presets = points.iter().filter(|point| point.preset.is_some()).map(place).collect();
    let presets = SettingCurve { name: "presets".to_owned(), places: presets, marked: true };
    diagram.settings.iter().map(of).chain([presets]).filter(|curve| !curve.places.is_empty()).collect()
}

fn csv(measure: Measure, points: &[&StudyPoint]) -> String {
    let number = |value: f64| format!("{value:e}");
    let row = |point: &&StudyPoint| {
        let times = [0.1, 0.5, 0.9, 0.99].map(|share| number(point.times.at(share))).join(",");
        let error = point.errors.get(measure).map_or_else(String::new, number);
        let value = point.value.as_str().map_or_else(|| point.value.to_string(), str::to_owned);
        let bar = point.errors.bar(measure).map_or_else(String::new, number);
        let at_most = point.errors.is_at_most(measure);
        let spread = point
            .errors
            .spread(measure)
            .map_or_else(|| ",,".to_owned(), |own| [own.median[0], own.median[1], own.p90].map(number).join(","));
        format!("{},{value},{},{error},{bar},{at_most},{spread},{times}\n", point.setting, point.preset.unwrap_or(""))
    };
    let rows: String = points.iter().map(row).collect();
    let head = "time_ms_p10,time_ms_p50,time_ms_p90,time_ms_p99";
    format!("dial,value,preset,{},bar,at_most,median_low,median_high,p90,{head}\n{rows}", measure.name())
}

/// Builds the page; `close_up` is [`CloseUp::png`](super::CloseUp::png).
pub fn page(findings: &AccuracyFindings, drawn: &[AccuracyDrawing], close_up: Option<Vec<u8>>) -> Study {
    let mut sections: Vec<Section> = DIAGRAMS
        .iter()
        .enumerate()
        .map(|(number, diagram)| {
            let own = drawn.iter().filter(|own| own.diagram == number);
            Section {
                heading: diagram.heading.to_owned(),
                lead: vec![diagram.lead.to_owned()],
                plots: own.map(|own| (own.svg.clone(), own.caption.clone())).collect(),
                ..Section::default()
            }
        })
        .filter(|section| !section.plots.is_empty())
        .collect();
    sections.extend(close_up.map(|png| close_up::section(findings, png)));
    sections.extend(bodies::section(&findings.bodies));
    sections.push(Section {
        heading: "All figures".to_owned(),
        tables: vec![table(&findings.points)],
        ..Section::default()
    });
    sections.push(front(findings));
    sections.push(left_out(findings));
    Study {
        title: format!("Accuracy against time: {}", findings.ground.object),
        lead: lead(findings),
        facts: facts(findings),
        sections,
    }
}

fn lead(findings: &AccuracyFindings) -> Vec<String> {
    let ground = &findings.ground;
    vec![
        format!(
            "Every dial of a strike over its values, everything else at its default. To the right the error against a reference, upwards \
             the time of a whole strike in process, with the emission of its meshes: medians of {} strikes ({} impacts, each {} times), on \
             {} threads of {}. What a service adds is not in it.",
            ground.strikes[0] * ground.strikes[1],
            ground.strikes[0],
            ground.strikes[1],
            ground.threads,
            ground.machine
        ),
        "Left and low is good. Points are labeled with their settings; spacings are over the diagonal. Errors of \
         elasticity below three error bars of their reference are upper bounds (≤)."
            .to_owned(),
    ]
}

fn facts(findings: &AccuracyFindings) -> Vec<Fact> {
    let ground = &findings.ground;
    let mut facts = vec![
        Fact::new("input", format!("{} triangles", ground.triangles)),
        Fact::new("elastic and crack nodes", format!("{} and {}", ground.nodes[0], ground.nodes[1])),
        Fact::new("crack nodes of the reference", ground.reference_nodes.to_string()),
        Fact::new("dimension of the lift", ground.dimension.to_string()),
        Fact::new("sites", ground.sites.to_string()),
    ];
    if let Some(share) = findings.estimates_within(4.0) {
        let value = format!("{:.0} % of {}", 100.0 * share, findings.estimates.len());
        facts.push(Fact::new("estimates of reduced energies within a factor 4", value));
    }
    facts
}

fn table(points: &[StudyPoint]) -> ReportTable {
    let head = ["dial", "value", "preset", "p50, ms", "p99, ms"].map(str::to_owned).into_iter();
    let head = head.chain(Measure::ALL.map(|measure| measure.name().to_owned())).collect();
    let row = |point: &StudyPoint| {
        let text = [point.setting.to_owned(), point.label(), point.preset.unwrap_or("").to_owned()];
        let times = [0.5, 0.99].map(|share| significant(point.times.at(share), 3));
        let error = |measure| point.errors.text(measure).unwrap_or_else(|| "–".to_owned());
        ("", text.into_iter().chain(times).chain(Measure::ALL.map(error)).collect())
    };
    ReportTable { head, rows: points.iter().map(row).collect() }
}

fn front(findings: &AccuracyFindings) -> Section {
    let lead = "A preset lies on the front unless another point of the same diagram is both faster, beyond the whiskers, and more accurate. \
                Combined: the worst of three errors, of elastic energy, cells and cracks, each over that of game.";
    let row = |own: &PresetStanding| {
        let text = own
            .beaten_by
            .as_ref()
            .map_or_else(|| "on the front".to_owned(), |by| format!("beaten by {}", by.join(" ")));
        let error = own.measure.map_or("combined", Measure::name);
        ("", vec![own.preset.to_owned(), own.diagram.to_owned(), error.to_owned(), text])
    };
    let head = ["preset", "diagram", "error", "stands"].map(str::to_owned).to_vec();
    let tables = vec![ReportTable { head, rows: preset_standings(findings).iter().map(row).collect() }];
    Section { heading: "Presets and the front".to_owned(), lead: vec![lead.to_owned()], tables, ..Section::default() }
}

fn left_out(findings: &AccuracyFindings) -> Section {
    let failed = findings.left_out.iter().map(|row| ("failed", row.to_vec()));
    let rows: Vec<_> = failed.chain(zeros(findings)).collect();
    let none = "Nothing failed or was omitted.".to_owned();
    let lead = if rows.is_empty() { vec![none] } else { Vec::new() };
    let head = ["what", "why"].map(str::to_owned).to_vec();
    let tables = if rows.is_empty() { Vec::new() } else { vec![ReportTable { head, rows }] };
    Section { heading: "Failures and omissions".to_owned(), lead, tables, ..Section::default() }
}

/// Errors of zero, which the diagrams omit because a logarithmic axis cannot show them.
fn zeros(findings: &AccuracyFindings) -> impl Iterator<Item = (&'static str, Vec<String>)> {
    let every = DIAGRAMS.iter().flat_map(|diagram| diagram.measures.iter().map(move |measure| (diagram, *measure)));
    every.filter_map(|(diagram, measure)| {
        let zero = |point: &&StudyPoint| shown(point, diagram, measure) && point.errors.get(measure) == Some(0.0);
        let named = |point: &StudyPoint| {
            point.preset.map_or_else(|| format!("{} {}", point.setting, point.label()), str::to_owned)
        };
        let points: Vec<String> = findings.points.iter().filter(zero).map(named).collect();
        let why = "no error at all, which a logarithmic axis cannot show; see all figures";
        let what = format!("in the diagram of {} ({}): {}", measure.name(), diagram.file, points.join(", "));
        (!points.is_empty()).then(|| ("", vec![what, why.to_owned()]))
    })
}
