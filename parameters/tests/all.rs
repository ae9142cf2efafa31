//! Tests of the parameters of nodes.

mod files;
mod patterns;
mod sets;
