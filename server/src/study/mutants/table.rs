//! A tally for people.

use super::Tally;
use super::tally::Named;
use std::fmt;

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (title, rows) in [("defect", &self.per_defect), ("mesh", &self.per_mesh)] {
            writeln!(f, "{title:<22} tried checked refused unjustified failed  accepted  of must-accept")?;
            rows.iter().try_for_each(|row| line(f, row))?;
        }
        line(f, &Named { name: "all".to_owned(), all: self.all, must_accept: self.must_accept })?;
        for told in &self.unjustified {
            writeln!(f, "unjustified: {}: {}", told.mutant, told.message)?;
        }
        for told in &self.failures {
            writeln!(f, "failed: {}: {}", told.mutant, told.message)?;
        }
        Ok(())
    }
}

fn line(f: &mut fmt::Formatter<'_>, Named { name, all, must_accept }: &Named) -> fmt::Result {
    let counts = format!("{:>5} {:>7} {:>7}", all.tried, all.checked, all.refused);
    let accepted = 100.0 * all.accept_rate();
    let must = match must_accept.tried {
        0 => String::new(),
        _ => format!("{:>12.1} %", 100.0 * must_accept.accept_rate()),
    };
    writeln!(f, "{name:<22} {counts} {:>11} {:>6}  {accepted:>6.1} %{must}", all.unjustified, all.failed)
}
