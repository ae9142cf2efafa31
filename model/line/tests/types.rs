//! Station types: that a line with types is the line with all its stations written out.

use linewright_line::{Line, TransferLine, expand, parse};
use proptest::prelude::*;

/// The shipped line, its clamp and its mill being stations of types.
pub const TYPES: &str = include_str!("descriptions/types.toml");

fn line(text: &str) -> Line {
    match parse("line.toml", text) {
        Ok(parsed) => {
            assert!(parsed.warnings.is_empty(), "{:?}", parsed.warnings);
            parsed.line
        }
        Err(problems) => panic!("{problems:#}\n{text}"),
    }
}

fn written_out(text: &str) -> String {
    expand("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}"))
}

/// The order of what stands beside stations follows from the text, and means nothing.
fn sorted(mut line: Line) -> Line {
    line.arrows.sort_by_key(|arrow| format!("{arrow:?}"));
    line.conflicts.sort_by_key(|conflict| format!("{conflict:?}"));
    line.devices.sort_by_key(|device| device.name.clone());
    line
}

/// As many pairs, each of two short tables.
fn with(machines: usize) -> String {
    let uses = TYPES.find("[[station]]\ntype").expect("stations of types");
    let rest = TYPES.find("[[device]]\nname = \"console io\"").expect("devices");
    let clamps = (1..=machines).map(|nth| {
        let io = 0x21 + 4 * (nth - 1);
        format!(
            "[[station]]\ntype = \"clamp\"\nname = \"clamp_{nth}\"\nparameters = {{ number = {nth}, io = {io} }}\n\n"
        )
    });
    let mills = (1..=machines).map(|nth| {
        let io = 0x22 + 4 * (nth - 1);
        let nodes = format!("io = {io}, positioning = {}, main = {}", io + 1, io + 2);
        format!(
            "[[station]]\nname = \"mill_{nth}\"\ntype = \"mill\"\n[station.parameters]\nnumber = {nth}\nclamp = \"clamp_{nth}\"\n{}\n\n",
            nodes.replace(", ", "\n")
        )
    });
    format!("{}{}{}", &TYPES[..uses], clamps.chain(mills).collect::<String>(), &TYPES[rest..])
}

#[test]
fn a_line_of_types_is_the_line_with_all_its_stations() {
    assert_eq!(sorted(line(TYPES)), sorted(line(&TransferLine::default().text())));
    for machines in [1, 2, 7, TransferLine::MACHINES_MAX] {
        let typed = with(machines);
        let shipped = TransferLine { machines, time_scale: 1.0 }.text();
        assert_eq!(sorted(line(&typed)), sorted(line(&shipped)), "{machines}");
        assert!(typed.len() < shipped.len(), "{machines}");
    }
}

#[test]
fn a_text_without_types_stays_as_it_is() {
    let shipped = TransferLine::default().text();
    assert_eq!(written_out(&shipped), shipped);
    assert_eq!(written_out("no TOML ["), "no TOML [");
}

#[test]
fn what_is_written_out_has_its_comments_and_no_types() {
    let text = TYPES.replace("[[station_type.operation]]", "# an operation\n[[station_type.operation]] # begins");
    let text = text.replace("[[station]]\ntype", "# a station\n[[station]]\ntype");
    let text = text.replace("io = 0x21 }\n", "io = 0x21 } # the first\n");
    let out = written_out(&text);
    assert!(!out.contains("station_type") && !out.contains("type = \"clamp\"") && !out.contains("parameters"), "{out}");
    assert!(out.contains("# a station\n[[station]]\nname = \"clamp_1\"\n"), "{out}");
    assert_eq!(out.matches("# an operation\n").count(), 7);
    assert!(out.contains("node = 0x21\n") && out.contains("title = \"Clamp 1\""), "{out}");
}

#[test]
fn keys_of_tables_have_parameters_as_texts_have() {
    let (plain, braces) = ("LS_open", "LS{number}.open");
    let device = "node = \"{io}\"\ninputs = [\"LS_open\"";
    assert!(TYPES.contains(device) && TYPES.contains("complete = \"LS_open\""), "the description has changed");
    let named = |signal: &str, comments: &str| {
        let text = TYPES.replace("\"LS_open\"", &format!("\"{signal}\""));
        let inputs = format!("node = \"{{io}}\"\ninputs = [\"{signal}\"");
        text.replacen(&inputs, &format!("{comments}\n{inputs}"), 1)
    };
    let inline = named(braces, "comments = { \"LS{number}.open\" = \"at {io}\", LS_closed = \"{{\" }");
    let dotted = named(braces, "comments.\"LS{number}.open\" = \"at {io}\"\ncomments.LS_closed = \"{{\"");
    for text in [inline, dotted] {
        let out = written_out(&text);
        assert!(out.contains("\"LS1.open\" = \"at 33\""), "{out}");
        // Every signal that has a comment is one of the device.
        line(&text);
    }
    let unknown = named(plain, "comments = { \"LS{count}_open\" = \"at\" }");
    let problems = parse("line.toml", &unknown).expect_err("no such parameter");
    assert!(format!("{problems:#}").contains("unknown parameter `{count}`"), "{problems:#}");
}

#[test]
fn a_brace_of_the_texts_own_is_written_twice() {
    let text = TYPES.replacen("title = \"Clamp {number}\"", "title = \"{number}: close {{{io}}}\"", 1);
    assert_eq!(line(&text).stations[1].title, "1: close {33}");
    let wrong = |title: &str| {
        let text = TYPES.replacen("title = \"Clamp {number}\"", &format!("title = \"{title}\""), 1);
        let problems = parse("line.toml", &text).expect_err(title).into_vec();
        problems.into_iter().map(|problem| problem.message).collect::<Vec<_>>()
    };
    for open in ["{name", "a}b", "{", "}", "{{}"] {
        assert_eq!(wrong(open), ["a brace without its other half"], "{open}");
    }
    assert_eq!(wrong("é{é}"), ["unknown parameter `{é}` of this type"]);
}

#[test]
fn what_stands_beside_a_station_may_be_a_list() {
    let start = TYPES.find("[[station_type.arrow]]").expect("arrows");
    let end = TYPES[start..].find("[[station_type.conflict]]").expect("conflicts") + start;
    let list = "arrow = [\n  { from = \"{name}: return clamp\", to = \"transfer: 1st lift\" }, # first\n  { from = \"transfer: 4th lower\", to = \"{name}: advance clamp\", lag = 0 },\n  { from = \"{name}: advance clamp\", to = \"transfer: return transfer\", modes = [\"auto\"] },\n]\n";
    let without = format!("{}{}", &TYPES[..start], &TYPES[end..]);
    let text = without.replacen("title = \"Clamp {number}\"\n", &format!("title = \"Clamp {{number}}\"\n{list}"), 1);
    assert_eq!(sorted(line(&text)), sorted(line(TYPES)));
}

/// A value of a parameter, and the same in a description.
fn word() -> impl Strategy<Value = String> {
    "[ -~äß\\u{1F600}]{0,12}"
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever texts are put in, the written out description is the same line; braces and quotes among them.
    #[test]
    fn the_written_out_text_is_the_same_line(title in word(), own in word(), machines in 1_usize..4) {
        let quoted = |text: &str| toml_edit::Value::from(text).to_string();
        let literal = own.replace('{', "{{").replace('}', "}}");
        let pattern = quoted(&format!("{literal} {{number}} {{what}}"));
        let text = with(machines)
            .replacen("parameters = [\"number\", \"io\"]", "parameters = [\"number\", \"io\", \"what\"]", 1)
            .replacen("title = \"Clamp {number}\"", &format!("title = {pattern}"), 1)
            .replace("parameters = { number", &format!("parameters = {{ what = {}, number", quoted(&title)));
        let typed = line(&text);
        prop_assert_eq!(&line(&written_out(&text)), &typed);
        prop_assert_eq!(&typed.stations[1].title, &format!("{own} 1 {title}"));
    }

    /// Cut off anywhere, it is understood or refused, with problems that point into it.
    #[test]
    fn half_a_description_of_types_is_refused_in_place(cut in 0_usize..20_000, drop in 0_usize..400) {
        let end = (cut + drop).min(TYPES.len());
        let start = cut.min(end);
        let text = format!("{}{}", &TYPES[..start], &TYPES[end..]);
        if let Err(problems) = parse("line.toml", &text) {
            prop_assert!(problems.errors() > 0);
            for problem in problems.iter() {
                prop_assert!(problem.span.end <= text.len());
            }
        }
        if let Ok(out) = expand("line.toml", &text) {
            prop_assert_eq!(parse("line.toml", &out).is_ok(), parse("line.toml", &text).is_ok());
        }
    }
}

/// An arrow of a type stands for one of each of its stations.
#[test]
fn arrows_have_the_lines_in_which_people_wrote_them() {
    let parsed = parse("line.toml", TYPES).unwrap_or_else(|problems| panic!("{problems:#}"));
    let lines: Vec<&str> = TYPES.lines().collect();
    assert_eq!(parsed.arrow_lines.len(), parsed.line.arrows.len());
    let headers: Vec<&str> = parsed.arrow_lines.iter().map(|&line| lines[line - 1]).collect();
    assert!(headers.contains(&"[[station_type.arrow]]"), "{headers:?}");
    assert!(headers.iter().all(|header| header.contains("arrow]]")), "{headers:?}");
}
