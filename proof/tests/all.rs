//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod agreement;
mod broken;
mod cells;
mod common;
mod generated;
mod limits;
mod lumped;
mod parts;
mod positions;
mod recovery;
mod restarts;
mod row;
mod rules;
mod single;
mod structure;
mod tables;
mod task_driven;
