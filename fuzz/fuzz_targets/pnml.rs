//! Any bytes as PNML: a net or problems with their places, never a panic; and a net that is read is written and read
//! again as the same one.

#![cfg_attr(feature = "engine", no_main)]

use libfuzzer_sys::fuzz_target;
use linewright_fuzz::draw_foreign;
use linewright_pnml::{Problems, limits, read, write};

/// No drawing of a few dozen problems is longer, whatever the lines of the file are.
const DRAWN_MAX: usize = 200_000;

fuzz_target!(|bytes: &[u8]| {
    match read("any.pnml", bytes, None) {
        Ok(net) => {
            let text = write(&net);
            let again = read("again.pnml", text.as_bytes(), None).expect("what is written can be read");
            assert_eq!(again.to_string(), net.to_string());
            assert_eq!(write(&again), text);
        }
        Err(problems) => draw(bytes, &problems),
    }
    // One of several nets, or none of that id.
    if let Err(problems) = read("any.pnml", bytes, Some("n2")) {
        draw(bytes, &problems);
    }
});

fn draw(bytes: &[u8], problems: &Problems) {
    assert!((1..=limits::PROBLEMS_MAX).contains(&problems.errors()));
    draw_foreign(bytes, problems, DRAWN_MAX);
}

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
