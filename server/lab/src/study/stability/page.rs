//! Page and JSON document of the stability study.

use super::{BendingDeficit, CaseOutcome, CaseRow, Neck};
use crate::report::{Fact, ReportFigure, ReportTable, Section, Study, share, significant};
use crate::study::mesh_fuzz::{FuzzTally, MUST_ACCEPT_RATE_MIN, NamedCounts};
use crate::study::plot::{Axes, PlotError, PlotLine, PlotMark, svg};
use serde_json::{Value, json};

/// Results of the stability study.
#[derive(Clone, Debug)]
pub struct StabilityFindings {
    /// Rows of the catalog, then of real meshes.
    pub rows: Vec<CaseRow>,
    /// Error of bending against Poisson's ratio.
    pub bending_deficits: Vec<BendingDeficit>,
    /// Results of the weak neck over a range of impulses.
    pub necks: Vec<Neck>,
    /// Pictures of three of these results.
    pub neck_portraits: Vec<ReportFigure>,
    /// Pictures of real meshes after the impact.
    pub real_portraits: Vec<ReportFigure>,
    /// Pictures of bad meshes after the impact.
    pub damaged: Vec<ReportFigure>,
    /// Tally of bad meshes.
    pub mutants: FuzzTally,
}

impl StabilityFindings {
    /// Whether anything failed, or too many meshes were refused.
    pub fn failed(&self) -> bool {
        let refused = self.must_accept_rate().is_some_and(|rate| rate < MUST_ACCEPT_RATE_MIN);
        self.count(CaseOutcome::Failed) > 0 || self.mutants.all.failed > 0 || refused
    }

    /// Accepted share of the mutants that must be accepted; `None` if no such mutant was tried.
    fn must_accept_rate(&self) -> Option<f64> {
        (self.mutants.must_accept.tried > 0).then_some(self.mutants.must_accept_rate)
    }

    fn count(&self, outcome: CaseOutcome) -> usize {
        self.rows.iter().filter(|row| row.outcome == outcome).count()
    }

    /// JSON document of `--json`.
    pub fn document(&self) -> Value {
        let all = &self.mutants.all;
        json!({
            "cases": self.rows,
            "mutants": {
                "tried": all.tried,
                "checked": all.checked,
                "exact": all.exact,
                "refused": all.refused,
                "failed": all.failed,
                "must_accept_rate": self.must_accept_rate(),
                "per_mesh": self.mutants.per_mesh,
                "per_defect": self.mutants.per_defect,
                "lattice_reasons": self.mutants.lattice_reasons,
                "failures": self.mutants.failures,
                "unjustified": self.mutants.unjustified,
            },
        })
    }

    /// Builds the page.
    pub fn page(&self) -> Result<Study, PlotError> {
        let all = &self.mutants.all;
        Ok(Study {
            title: "Hard cases".to_owned(),
            lead: vec![
                "Every case ends in a checked result, with a figure and a bound, or in an error that names its reason. No case may panic, \
                 hang, or return a number that is not finite or an open mesh."
                    .to_owned(),
            ],
            facts: vec![
                Fact::new("Cases within their bound", self.count(CaseOutcome::Passed).to_string()),
                Fact::new("Refused, as expected", self.count(CaseOutcome::Refused).to_string()),
                Fact::new("Cases failed", self.count(CaseOutcome::Failed).to_string()),
                Fact::new("Bad meshes tried", all.tried.to_string()),
                Fact::new("Bad meshes failed", all.failed.to_string()),
                Fact::new("Accepted of those that must be", self.must_accept_rate().map_or("–".to_owned(), share)),
            ],
            sections: [vec![self.cases(), self.poisson()?, self.neck()?, self.bad_meshes()], self.real_meshes()].concat(),
        })
    }

    fn cases(&self) -> Section {
        let cell = |row: &CaseRow| {
            let figure = row.figure.map_or_else(|| "–".to_owned(), |figure| significant(figure, 3));
            let outcome = match row.outcome {
                CaseOutcome::Passed => "passed",
                CaseOutcome::Refused => "refused",
                CaseOutcome::Failed => "failed",
            };
            let why =
                row.message.as_ref().map_or_else(|| row.why.clone(), |message| format!("{} ({message})", row.why));
            (outcome, vec![row.item.clone(), row.name.clone(), outcome.to_owned(), figure, row.expected.clone(), why])
        };
        Section {
            heading: format!("{} cases", self.rows.len()),
            lead: vec!["The last column explains the figure and its bound.".to_owned()],
            tables: vec![ReportTable {
                head: ["item", "case", "outcome", "figure", "bound", "why"].map(str::to_owned).to_vec(),
                rows: self.rows.iter().map(cell).collect(),
            }],
            ..Section::default()
        }
    }

    fn poisson(&self) -> Result<Section, PlotError> {
        let line = |name: &str, figure: fn(&BendingDeficit) -> f64| PlotLine {
            name: name.to_owned(),
            points: self.bending_deficits.iter().map(|at| (at.poisson, 100.0 * figure(at))).collect(),
            mark: PlotMark::Both,
        };
        let lines = [
            line("body-centered lattice, 6 cubes across", |at| at.body_centered),
            line("cubes divided in six, 8 across", |at| at.six_per_cube),
        ];
        let axes = Axes { x: "Poisson's ratio".into(), y: "missing energy, %".into(), log_x: false, log_y: false };
        Ok(Section {
            heading: "Nearly incompressible materials".to_owned(),
            lead: vec![
                "Linear tetrahedra lock as Poisson's ratio approaches one half. The plot shows the relative deficit of the energy in pure \
                 bending: small on the lattice of the bake, three quarters on tetrahedra in the worst arrangement. Baking accepts ratios \
                 up to 0.45, where the worst arrangement loses at most 15 %, and refuses larger ones."
                    .to_owned(),
            ],
            plots: vec![(svg(&axes, &lines)?, "Error of a bent beam against Poisson's ratio.".to_owned())],
            ..Section::default()
        })
    }

    fn neck(&self) -> Result<Section, PlotError> {
        let line = |name: &str, figure: fn(&Neck) -> f64| PlotLine {
            name: name.to_owned(),
            points: self.necks.iter().map(|neck| (neck.times, figure(neck))).collect(),
            mark: PlotMark::Both,
        };
        let lines = [
            line("fragments", |neck| neck.fragments as f64),
            line("fragments from the neck", |neck| neck.in_neck as f64),
            line("share of each end in one piece", |neck| neck.ends_kept),
        ];
        let axes =
            Axes { x: "impulse over the breaking one".into(), y: "count, share".into(), log_x: true, log_y: false };
        Ok(Section {
            heading: "A weak neck".to_owned(),
            lead: vec![
                "A dumbbell with one end pushed sideways: the strain energy is in its neck. Near the threshold it snaps in two. Far above \
                 it, an energy-weighted diagram puts its cells where the energy is, so the neck shatters while the ends stay whole. For a \
                 clean snap at any impulse, request two sites or raise γ."
                    .to_owned(),
            ],
            plots: vec![(svg(&axes, &lines)?, "Fragments of a dumbbell over a range of impulses.".to_owned())],
            figures: self.neck_portraits.clone(),
            ..Section::default()
        })
    }

    /// Section of real meshes; empty without pictures.
    fn real_meshes(&self) -> Vec<Section> {
        let section = Section {
            heading: "Real meshes".to_owned(),
            lead: vec![
                "Scans and models with holes, open edges and inverted faces, baked at default spacings and struck once \
                 with 12 sites."
                    .to_owned(),
            ],
            figures: self.real_portraits.clone(),
            ..Section::default()
        };
        if self.real_portraits.is_empty() { Vec::new() } else { vec![section] }
    }

    fn bad_meshes(&self) -> Section {
        let table = |title: &str, rows: &[NamedCounts]| ReportTable {
            head: [
                title,
                "tried",
                "checked",
                "exact",
                "refused",
                "unjustified errors",
                "failed",
                "must-accept accepted",
            ]
            .map(str::to_owned)
            .to_vec(),
            rows: rows.iter().map(counts).collect(),
        };
        let reasons = self.mutants.lattice_reasons.iter();
        let reasons = ReportTable {
            head: ["reason for the lattice's surface", "times"].map(str::to_owned).to_vec(),
            rows: reasons.map(|(reason, count)| ("", vec![reason.clone(), count.to_string()])).collect(),
        };
        Section {
            heading: format!("{} bad meshes", self.mutants.all.tried),
            lead: vec![
                "Twenty defects, by meshes and seeds. Each mesh is repaired, baked and struck, and every fragment of the result is \
                 checked. Meshes without an inside or with values that are not finite may be refused. Inside-out, flipped, \
                 duplicated, mixed, holed, doubled, nested and T-junctioned meshes must be accepted; the pictures show a \
                 statue with each of these defects and the same impact."
                    .to_owned(),
            ],
            figures: self.damaged.clone(),
            tables: vec![
                table("defect", &self.mutants.per_defect),
                table("mesh", &self.mutants.per_mesh),
                reasons,
            ],
            ..Section::default()
        }
    }
}

fn counts(row: &NamedCounts) -> (&'static str, Vec<String>) {
    let must = match row.must_accept.tried {
        0 => "–".to_owned(),
        _ => format!("{:.1} %", 100.0 * row.must_accept.accept_rate()),
    };
    let numbers = [row.all.tried, row.all.checked, row.all.exact, row.all.refused, row.all.unjustified, row.all.failed];
    let cells = std::iter::once(row.name.clone()).chain(numbers.iter().map(u64::to_string)).chain([must]);
    (if row.all.failed > 0 { "failed" } else { "" }, cells.collect())
}
