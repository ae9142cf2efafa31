//! Minimal semiflows: sums of tokens that never change, and firings that lead back.
