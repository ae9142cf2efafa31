//! What all charts in SVG share.

/// Round times, at most a dozen of them, from zero to the end of a span.
pub fn steps(span: f64) -> Vec<f64> {
    let magnitude = 10f64.powf((span / 10.0).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|n| n * magnitude).into_iter().find(|step| span / step <= 12.0);
    let step = step.unwrap_or(span);
    let count = (span / step).floor() as u32;
    (0..=count).map(|n| (f64::from(n) * step * 1e6).round() / 1e6).collect()
}

/// Text between tags and in attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_few() {
        assert_eq!(steps(3.5), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5]);
        assert_eq!(steps(1.0).len(), 11);
        for span in [1e-6, 0.3, 7.118, 59.0, 1e5, 1e9] {
            let steps = steps(span);
            assert!((2..=13).contains(&steps.len()) && steps.iter().all(|&at| at <= span + 1e-6), "{span}: {steps:?}");
        }
    }
}
