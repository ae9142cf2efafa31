//! Tests of this crate, in one program.

mod machine;
mod published;
