//! Any bytes as a line description: an answer, never a panic, and every place in it within the text.
//!
//! A description that parses must also go all the way to controllers: what the parser lets through, nothing behind it
//! may trip over.

#![cfg_attr(feature = "engine", no_main)]

use libfuzzer_sys::fuzz_target;
use linewright_fuzz::draw_description;
use linewright_line::net::StationNet;
use linewright_line::{Line, Problems, parse};
use linewright_station_logic::{Controller, Restore};

fuzz_target!(|bytes: &[u8]| {
    // A file is read as UTF-8 before the parser sees it.
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match parse("any.toml", text) {
        Ok(parsed) => {
            compile(&parsed.line);
            draw_description(text, &Problems::new("any.toml", text, parsed.warnings));
        }
        Err(problems) => {
            assert!(problems.errors() > 0, "no line and no error");
            draw_description(text, &problems);
        }
    }
});

/// Every station's net and controller can be made; a controller may refuse, with a reason.
fn compile(line: &Line) {
    for station in line.station_ids() {
        let net = StationNet::of(line, station);
        assert_eq!(net.net().place_count(), net.places().len());
        if let Err(refusal) = Controller::new(line, station, 1, Restore::Fresh) {
            assert!(!refusal.to_string().is_empty());
        }
    }
}

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
