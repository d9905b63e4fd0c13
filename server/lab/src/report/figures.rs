//! Number formats for people.

/// `value` with `digits` significant digits; very large and very small values with a power of ten.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let scientific = format!("{value:.*e}", digits.max(1) - 1);
    let exponent: i32 = scientific.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0);
    if (-3..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return format!("{value:.decimals$}");
    }
    let mantissa = scientific.split('e').next().unwrap_or_default();
    format!("{mantissa}\u{a0}×\u{a0}10{}", superscript(exponent))
}

/// Power of ten, written out if it is short.
pub(super) fn power_of_ten(power: i32) -> String {
    if (-2..=2).contains(&power) { format!("{}", 10_f64.powi(power)) } else { format!("10{}", superscript(power)) }
}

/// An integer in raised digits.
fn superscript(number: i32) -> String {
    let raised = |letter: char| match letter {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32('⁰' as u32 + letter as u32 - '0' as u32).unwrap_or(letter),
        other => other,
    };
    number.to_string().chars().map(raised).collect()
}

/// Integer in groups of three digits, with narrow no-break spaces.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// Duration in a suitable unit.
pub fn nanoseconds(ns: u64) -> String {
    match ns {
        0..1_000 => format!("{ns} ns"),
        1_000..1_000_000 => format!("{} µs", significant(ns as f64 / 1e3, 3)),
        1_000_000..1_000_000_000 => format!("{} ms", significant(ns as f64 / 1e6, 3)),
        _ => format!("{} s", significant(ns as f64 / 1e9, 3)),
    }
}

/// Size in a suitable unit.
pub fn bytes(count: u64) -> String {
    match count {
        0..1_024 => format!("{count} B"),
        1_024..1_048_576 => format!("{} KiB", significant(count as f64 / 1_024.0, 3)),
        _ => format!("{} MiB", significant(count as f64 / 1_048_576.0, 3)),
    }
}

/// Share of a whole in percent.
pub fn share(part: f64) -> String {
    format!("{} %", significant(part * 100.0, 3))
}
