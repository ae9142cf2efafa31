//! What a cell's coordinator keeps on disk.

mod log;

pub use log::{CellLog, CellLogError, Found, RECORDS_MAX};
