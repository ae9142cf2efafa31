//! Siphons and traps: sets of places that stay empty, and sets that stay marked.
