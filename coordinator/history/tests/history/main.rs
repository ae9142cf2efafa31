//! The database beside the records it was made from: written, read, fed again, damaged.

mod damage;
mod feeding;
mod played;
mod rows;
