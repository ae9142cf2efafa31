//! Shared by the tests of this crate: nets, and results of reading.

use std::fmt::Write;

use linewright_nets::Net;
use linewright_pnml::{Problems, read};
use miette::{GraphicalReportHandler, GraphicalTheme};

/// Reads a file that is sound.
pub fn sound(text: &str) -> Net {
    read("net.pnml", text.as_bytes(), None).unwrap_or_else(|problems| panic!("{problems:#}\nin {text}"))
}

/// A file with one net that contains `inside`.
pub fn with(inside: &str) -> String {
    format!("<pnml>\n<net id=\"n\">\n{inside}\n</net>\n</pnml>\n")
}

/// Messages for a file that is not sound: `line:column: message`, and the advice behind an arrow.
pub fn said(bytes: &[u8]) -> Vec<String> {
    let problems = read("net.pnml", bytes, None).expect_err("this is wrong");
    drawn(&problems);
    let text = |p: &linewright_pnml::Problem| {
        let hint = p.hint.as_ref().map(|hint| format!(" => {hint}")).unwrap_or_default();
        format!("{}:{}: {}{hint}", p.line, p.column, p.message)
    };
    problems.iter().map(text).collect()
}

/// The problems as they are shown in a terminal.
pub fn drawn(problems: &Problems) -> String {
    let mut drawn = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(120)
        .render_report(&mut drawn, problems)
        .expect("every report can be drawn");
    drawn
}

/// A ring of stations with six operations each, written as a program would write it: one control token for each
/// station, buffers full and empty by turns between them, and places called what their ids are.
pub fn ring(stations: usize) -> String {
    let (mut places, mut transitions, mut arcs) = (String::new(), String::new(), String::new());
    let place = |out: &mut String, id: String, tokens: usize| {
        let marking = if tokens > 0 { "<initialMarking><text>1</text></initialMarking>" } else { "" };
        writeln!(out, "<place id=\"{id}\"><name><text>{id}</text></name>{marking}</place>").unwrap();
    };
    let mut count = 0;
    let mut arc = |source: String, target: String| {
        writeln!(arcs, "<arc id=\"a{count}\" source=\"{source}\" target=\"{target}\"/>").unwrap();
        count += 1;
    };
    for i in 0..stations {
        let next = (i + 1) % stations;
        for j in 0..6 {
            place(&mut places, format!("o_{i}_{j}"), 0);
            place(&mut places, format!("c_{i}_{j}"), usize::from(j == 5));
            for kind in ["s", "d"] {
                let id = format!("{kind}_{i}_{j}");
                writeln!(transitions, "<transition id=\"{id}\"><name><text>{id}</text></name></transition>").unwrap();
            }
            arc(format!("c_{i}_{}", (j + 5) % 6), format!("s_{i}_{j}"));
            arc(format!("s_{i}_{j}"), format!("o_{i}_{j}"));
            arc(format!("o_{i}_{j}"), format!("d_{i}_{j}"));
            arc(format!("d_{i}_{j}"), format!("c_{i}_{j}"));
        }
        place(&mut places, format!("f_{i}"), usize::from(i % 2 == 0));
        place(&mut places, format!("e_{i}"), usize::from(i % 2 == 1));
        // The third operation takes a part from the buffer before, the fifth puts it into the one behind.
        arc(format!("f_{i}"), format!("s_{i}_2"));
        arc(format!("d_{i}_2"), format!("e_{i}"));
        arc(format!("e_{next}"), format!("s_{i}_4"));
        arc(format!("d_{i}_4"), format!("f_{next}"));
    }
    format!(
        "<?xml version=\"1.0\"?>\n<pnml xmlns=\"http://www.pnml.org/version-2009/grammar/pnml\">\n\
         <net id=\"ring\" type=\"http://www.pnml.org/version-2009/grammar/ptnet\"><name><text>ring</text></name>\
         <page id=\"g\">\n{places}{transitions}{arcs}</page></net></pnml>\n"
    )
}
