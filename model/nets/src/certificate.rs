//! What structure proves, with the evidence, and a small checker that believes only the evidence.
