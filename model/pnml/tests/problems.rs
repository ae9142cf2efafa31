//! Errors, places and advice: one row for everything that is refused.

use linewright_pnml::{limits, read};

use crate::common::{drawn, said, with};

#[test]
fn rules_of_a_net() {
    let problems = |text: &str| match read("net.pnml", text.as_bytes(), None) {
        Ok(_) => Vec::new(),
        Err(problems) => {
            drawn(&problems);
            problems.into_vec()
        }
    };
    // What stands in line 3 of a file.
    let dir = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/problems");
    linewright_cases::check(dir, "net.cases", |_| with("…"), problems);
}

/// Whole files.
const FILES: &[(&[u8], &str)] = &[
    (b"", "1:1: there is no XML element in this file => is this the right file?"),
    (b"net n\n", "1:1: there is no XML element in this file => is this the right file?"),
    (b"<html/>", "1:1: the outermost element is `html`, not `pnml` => only PNML is read; is this the right file?"),
    (b"<pnml/>", "1:1: there is no net in this file => a net is an element `<net>` in `<pnml>`"),
    (
        b"<pnml><net id=\"a\"/>\n<net id=\"b\"/></pnml>",
        "2:1: the file has 2 nets: `a`, `b` => select one with `--net ID`",
    ),
    (
        b"<pnml><net id=\"n\"/></pnml>\n<pnml/>",
        "2:1: a second element stands behind the end of the first => a file has one outermost element; keep each in a file of its own",
    ),
    (
        b"<pnml>\n<net id=\"n\" type=\"http://www.pnml.org/version-2009/grammar/symmetricnet\"/></pnml>",
        "2:19: this net is of the type `http://www.pnml.org/version-2009/grammar/symmetricnet` => only place/transition nets are read: unfold it, or export it as http://www.pnml.org/version-2009/grammar/ptnet",
    ),
    (
        b"<pnml><net id=\"n\" type=\"http://www.pnml.org/version-2009/grammar/pt-hlpng\"/></pnml>",
        "1:25: this net is of the type `http://www.pnml.org/version-2009/grammar/pt-hlpng` => only place/transition nets are read: unfold it, or export it as http://www.pnml.org/version-2009/grammar/ptnet",
    ),
    (
        b"<pnml>\n<net id=\"n\">\n<place id=\"p\">",
        "3:1: the file ends before `<place id=\"p\">` is closed => the file has been cut short; write it again",
    ),
    (b"<pnml>\n<net></page></pnml>", "2:6: this is not XML: `</net>` is expected here, not `</page>`"),
    (b"<pnml></pnml></net>", "1:14: this is not XML: `</net>` closes nothing"),
    (b"<pnml>\n<net id=\"n", "2:1: this is not XML: attribute value not closed: `\"` not found before end of input"),
    (
        b"<pnml>\n<net id=\"n\"><place id=\"p\"><name><text>a & b</text>",
        "2:41: this is not XML: a `&` that begins no reference is written `&amp;`",
    ),
    (
        b"<pnml>\n<name>\xC3\xA9\xE9</name></pnml>",
        "2:8: the byte 0xE9 here is not UTF-8 => save the file as UTF-8, or declare the encoding: <?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>",
    ),
    (b"\xFF\xFE<\0p\0", "1:1: the file is UTF-16 => save it as UTF-8"),
    (
        b"<?xml version=\"1.0\" encoding=\"EUC-JP\"?><pnml>\xC3\xA9</pnml>",
        "1:1: the file declares the encoding `euc-jp` => UTF-8, US-ASCII and ISO-8859-1 are read; save it as UTF-8",
    ),
    (b"<pnml>\n\x1B[2J</pnml>", "2:1: the control character U+001B is not allowed in XML => remove it"),
];

#[test]
fn what_is_wrong_with_a_file_is_said_where_it_is() {
    let mut wrong = Vec::new();
    for (file, expected) in FILES {
        let found = said(file);
        if found != [*expected] {
            wrong.push(format!("{}\n  expected {expected}\n  found    {found:#?}", String::from_utf8_lossy(file)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_net_that_is_not_there_is_asked_for() {
    let file = b"<pnml><net id=\"a\"/><net id=\"b\"/><net id=\"b\"/></pnml>";
    let problem = |net| {
        let problems = read("nets.pnml", file, Some(net)).unwrap_err();
        let problem = problems.iter().next().unwrap();
        format!("{} => {}", problem.message, problem.hint.as_deref().unwrap())
    };
    assert_eq!(problem("c"), "no net of this file has the id `c` => there is `a`, `b`, `b`");
    assert_eq!(problem("b"), "2 nets of this file have the id `b` => ids are unique in a file");
}

/// A file after a careless evening with an editor.
const CARELESS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">
  <net id="cell" type="http://www.pnml.org/version-2009/grammar/ptnet">
    <page id="g">
      <place id="idle"><initialMarking><text>one</text></initialMarking></place>
      <place id="busy"/>
      <place id="busy"/>
      <transition id="start"/>
      <arc id="a1" source="idle" target="start"/>
      <arc id="a2" source="start" target="bussy"/>
      <arc id="a3" source="busy" target="idle"/>
      <arc id="a4" source="busy" target="start"><type value="inhibitor"/></arc>
    </page>
  </net>
</pnml>
"#;

#[test]
fn all_problems_are_drawn_at_their_places() {
    let problems = read("cell.pnml", CARELESS.as_bytes(), None).expect_err("this is wrong in many ways");
    insta::assert_snapshot!("drawn", drawn(&problems));
    insta::assert_snapshot!("listed", format!("{problems:#}"));
}

#[test]
fn of_a_line_without_end_a_part_is_drawn() {
    let long = CARELESS.replace(['\n', '\r'], " ").replace("<page id=\"g\">", &"<place id=\"é\"/>".repeat(1000));
    let problems = read("cell.pnml", long.replace("</page>", "").as_bytes(), None).expect_err("ids are not unique");
    assert_eq!(problems.to_string(), format!("cell.pnml: the first {} errors of more", limits::PROBLEMS_MAX));
    let drawn = drawn(&problems);
    assert!(drawn.lines().all(|line| line.chars().count() < 200), "{drawn}");
}
