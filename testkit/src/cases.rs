//! How many cases a generated test tries.

/// `usual`, times the percentage in the environment variable `LINEWRIGHT_CASES`; at least one.
///
/// A build that is waited for tries fewer than `usual` (`cargo xtask test`), a long run more (`cargo xtask test --long`).
pub fn cases(usual: u64) -> u64 {
    let percent = std::env::var("LINEWRIGHT_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(100);
    usual.saturating_mul(percent).div_ceil(100).max(1)
}
