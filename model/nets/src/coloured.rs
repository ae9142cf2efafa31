//! Coloured nets: tokens that carry data, arc functions and guards (seed 000, definitions 13 to 21).
