//! Number of cases of a generated test.

/// `stated` times the percentage in the environment variable `LINEWRIGHT_CASES`, 100 where it is not given; at least one. `cargo xtask test`
/// sets 25, `cargo xtask test --long` 400.
pub fn cases(stated: u64) -> u64 {
    let percent = std::env::var("LINEWRIGHT_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(100);
    stated.saturating_mul(percent).div_ceil(100).max(1)
}
