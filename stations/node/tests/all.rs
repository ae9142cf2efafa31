//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod device_texts;
mod images;
mod journal;
mod orders;
