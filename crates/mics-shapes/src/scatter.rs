//! Numbers for tests that look as drawn.

/// The number k, in (-1, 1).
pub fn scatter(k: usize) -> f64 {
    (12.9898 * k as f64 + 4.1414).sin() * 43758.5453 % 1.0
}
