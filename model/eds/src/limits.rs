//! How much of anything is read. Beyond these a file is refused, by name of the limit, before it costs memory.
//!
//! What a number in the file says costs nothing: a compact array of 254 elements is kept as its one description, and
//! elements are made when they are asked for.

/// The largest file, in bytes. Descriptions of modular couplers with thousands of objects have about one million.
pub const FILE_BYTES_MAX: usize = 8 << 20;

/// The most errors that are reported of one file, and as many warnings: more would only hide the first cause.
pub const PROBLEMS_MAX: usize = linewright_diagnostics::EXCERPTS_MAX;

/// The most elements of a compact array: its subindices are 1 to 254.
pub const COMPACT_MAX: u8 = 254;
