//! Numbers as people read them.

/// A number with all its digits, or by a power of ten where these would be many zeros.
pub fn number(x: f64) -> String {
    if x == 0.0 || (1e-4..1e7).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// A number to six digits without zeros at its end, or by a power of ten against many zeros.
pub fn rounded(x: f64) -> String {
    if x.is_finite() { number(format!("{x:.5e}").parse().unwrap_or(x)) } else { x.to_string() }
}

/// A number to three digits behind the point, or by a power of ten where these would lose it.
pub fn brief(x: f64) -> String {
    if x == 0.0 || (1e-2..1e7).contains(&x.abs()) { format!("{x:.3}") } else { format!("{x:.2e}") }
}

/// A number to the nearest whole one, or by a power of ten against a row of digits.
pub fn whole(x: f64) -> String {
    if x.abs() < 1e7 { format!("{x:.0}") } else { format!("{x:.1e}") }
}

/// Seconds as hours, minutes and seconds, as far as they count.
pub fn minutes(seconds: f64) -> String {
    let s = seconds.max(0.0) as u64;
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{} min {:02} s", s / 60, s % 60),
        3600..3_600_000 => format!("{} h {:02} min", s / 3600, s / 60 % 60),
        _ => format!("{} days", whole(seconds / 86_400.0)),
    }
}

/// Bytes in the unit that suits them.
pub fn size(bytes: f64) -> String {
    let (size, unit) = match bytes {
        ..1e5 => (bytes / 1e3, "kB"),
        ..1e9 => (bytes / 1e6, "MB"),
        _ => (bytes / 1e9, "GB"),
    };
    if size < 10.0 { format!("{size:.1} {unit}") } else { format!("{} {unit}", whole(size)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_and_small_numbers_in_powers_of_ten() {
        assert_eq!(
            [0.0, 1000.0, 1e-3, -0.25, 1e-300, 3e8].map(number),
            ["0", "1000", "0.001", "-0.25", "1e-300", "3e8"]
        );
        assert_eq!(
            [0.1 + 0.2, 2.0 / 3.0, 1.0 / 3e7, 12.5, 0.0].map(rounded),
            ["0.3", "0.666667", "3.33333e-8", "12.5", "0"]
        );
        assert_eq!([4879.6, 1e12].map(whole), ["4880", "1.0e12"]);
        assert_eq!([0.0, 0.25, 1.234e-6, 5e8].map(brief), ["0.000", "0.250", "1.23e-6", "5.00e8"]);
    }

    #[test]
    fn units_of_times_and_sizes() {
        assert_eq!(
            [59.0, 61.0, 3720.0, 1e15].map(minutes),
            ["59 s", "1 min 01 s", "1 h 02 min", "1.2e10 days"]
        );
        assert_eq!(
            [2.34e3, 2.34e5, 3.2e7, 1.25e9, 4.4e10, 1e30].map(size),
            ["2.3 kB", "0.2 MB", "32 MB", "1.2 GB", "44 GB", "1.0e21 GB"]
        );
    }
}
