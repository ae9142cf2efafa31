//! Limits of reading. Beyond these a file is refused, by name of the limit, before it costs memory.
//!
//! A net of a million places with as many transitions, written by a talkative tool, is within all of them.

/// The largest file, in bytes.
pub const FILE_BYTES_MAX: usize = 256 << 20;

/// The deepest nesting of elements. The standard's own need five levels, and one more for each page within a page.
pub const DEPTH_MAX: usize = 256;

/// The most attributes of one element; PNML's have three at most, drawings a dozen.
pub const ATTRIBUTES_MAX: usize = 64;

/// The longest id or name, in bytes.
pub const NAME_BYTES_MAX: usize = 4096;

/// The most places, transitions and references to them, together.
pub const NODES_MAX: usize = 1 << 22;

/// The most arcs.
pub const ARCS_MAX: usize = 1 << 24;

/// The most problems that are reported of one file: more would only hide the first cause.
pub const PROBLEMS_MAX: usize = linewright_diagnostics::EXCERPTS_MAX;
