//! The database beside the records it was made from: written, read, fed again, damaged.

mod damage;
mod feeding;
mod line;
mod outages;
mod played;
mod retention;
mod rows;
