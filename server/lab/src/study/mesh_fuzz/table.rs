//! Table of a tally for people.

use super::FuzzCounts;
use super::FuzzTally;
use super::tally::NamedCounts;
use shatter_proto::text::counted;
use std::fmt;

impl fmt::Display for FuzzTally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (title, rows) in [("defect", &self.per_defect), ("mesh", &self.per_mesh)] {
            writeln!(f, "{title:<22} tried checked  exact refused unjustified failed  accepted  of must-accept")?;
            rows.iter().try_for_each(|row| line(f, row))?;
        }
        line(f, &NamedCounts { name: "all".to_owned(), all: self.all, must_accept: self.must_accept })?;
        for (reason, count) in &self.lattice_reasons {
            writeln!(f, "the lattice's surface, {}: {reason}", counted(*count, "time"))?;
        }
        for reported in &self.unjustified {
            writeln!(f, "unjustified: {}: {}", reported.mutant, reported.message)?;
        }
        for reported in &self.failures {
            writeln!(f, "failed: {}: {}", reported.mutant, reported.message)?;
        }
        Ok(())
    }
}

fn line(f: &mut fmt::Formatter<'_>, NamedCounts { name, all, must_accept }: &NamedCounts) -> fmt::Result {
    let counts = format!("{:>5} {:>7} {:>6} {:>7}", all.tried, all.checked, all.exact, all.refused);
    let rate = |of: &FuzzCounts, none: &str| match of.tried {
        0 => none.to_owned(),
        _ => format!("{:.1} %", 100.0 * of.accept_rate()),
    };
    let (accepted, must) = (rate(all, "–"), rate(must_accept, ""));
    writeln!(f, "{name:<22} {counts} {:>11} {:>6}  {accepted:>8} {must:>14}", all.unjustified, all.failed)
}
