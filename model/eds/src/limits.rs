//! Limits of reading. Beyond these a file is refused, by name of the limit, before it costs memory.
//!
//! A number in the file costs nothing by itself: a compact array of 254 elements is kept as its one description, and
//! elements are made on demand.

/// The largest file, in bytes. Descriptions of modular couplers with thousands of objects have about one million.
pub const FILE_BYTES_MAX: usize = 8 << 20;

/// The most errors that are reported of one file, and as many warnings: more would only hide the first cause.
pub const PROBLEMS_MAX: usize = linewright_diagnostics::EXCERPTS_MAX;

/// The most elements of a compact array: its subindices are 1 to 254.
pub const COMPACT_MAX: u8 = 254;
