//! What is wrong, where, and what to do about it: one row for everything that is refused.

use linewright_pnml::{limits, read};

use crate::common::{drawn, said, with};

/// What stands in line 3 of a file, and what is said of it.
const IN_A_NET: &[(&str, &[&str])] = &[
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="u"/>"#,
        &["3:67: the arc `a` leads to `u`, which is no node of the net => write the id of a place or transition"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc source="q" target="t"/>"#,
        &["3:49: this arc comes from `q`, which is no node of the net => write the id of a place or transition"],
    ),
    (
        r#"<place id="p"/><place id="q"/><arc id="a" source="p" target="q"/>"#,
        &["3:31: the arc `a` joins two places => an arc joins a place and a transition"],
    ),
    (
        r#"<transition id="t"/><arc id="a" source="t" target="t"/>"#,
        &["3:21: the arc `a` joins two transitions => an arc joins a place and a transition"],
    ),
    (
        r#"<place id="p"/><arc id="a" source="p"/>"#,
        &["3:16: the arc `a` lacks `source` or `target` => write the ids of the nodes it joins"],
    ),
    (
        r#"<place id="p"/><transition id="p"/>"#,
        &["3:16: the id `p` is given twice => ids are unique in a file; the first is in line 3"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="p" source="p" target="t"/>"#,
        &["3:36: the id `p` is given twice => ids are unique in a file; the first is in line 3"],
    ),
    ("<place/>", &["3:1: this place has no id => arcs find their ends by id: give it one"]),
    (
        r#"<place id="p"><initialMarking><text>-3</text></initialMarking></place>"#,
        &["3:37: the initial marking of the place `p` is `-3` => it cannot be negative"],
    ),
    (
        r#"<place id="p"><initialMarking><text>two</text></initialMarking></place>"#,
        &["3:37: the initial marking of the place `p` is `two` => a whole number is needed"],
    ),
    (
        r#"<place id="p"><initialMarking><text>1.5</text></initialMarking></place>"#,
        &["3:37: the initial marking of the place `p` is `1.5` => a whole number is needed"],
    ),
    (
        r#"<place id="p"><initialMarking><text>4294967296</text></initialMarking></place>"#,
        &["3:37: the initial marking of the place `p` is `4294967296` => at most 4294967295 is possible"],
    ),
    (
        r#"<place id="p"><initialMarking><value>Red,1</value></initialMarking></place>"#,
        &[
            "3:38: the initial marking of the place `p` is `Red,1` => tokens with colours are not read; only place/transition nets are",
        ],
    ),
    (
        r#"<place id="p"><initialMarking><text>1</text></initialMarking><initialMarking><text>2</text></initialMarking></place>"#,
        &["3:62: the marking of the place `p` is given twice => remove one of the two"],
    ),
    (
        r#"<place id="p"><name><text>a</text><text>b</text></name></place>"#,
        &["3:35: this label has two texts => remove one of the two"],
    ),
    (
        r#"<place id="p"><initialMarking>1<text>2</text></initialMarking></place>"#,
        &["3:31: this label has two texts => remove one of the two"],
    ),
    (
        r#"<place id="p"><initialMarking>two</initialMarking></place>"#,
        &["3:31: the initial marking of the place `p` is `two` => a whole number is needed"],
    ),
    (
        r#"<place id="p"><initialMarking><graphics/><token>2</token></initialMarking></place>"#,
        &["3:42: `token` in a label is not known here => write what the label says in `<text>`"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="t"><arctype>inhibitor</arctype></arc>"#,
        &["3:79: the arc `a` is of the type `inhibitor` => only ordinary arcs are read, which take and give tokens"],
    ),
    (
        r#"<place id="p"><capacity><value>2</value></capacity></place>"#,
        &["3:15: the capacity of the place `p` is 2 => capacities are not read; write it as a complementary place"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="t"><inscription><text>0</text></inscription></arc>"#,
        &["3:89: the weight of the arc `a` is 0 => an arc moves at least one token; leave the arc out"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="t" inscription="[0,inf)"/>"#,
        &[
            "3:83: the weight of the arc `a` is `[0,inf)` => tokens with colours are not read; only place/transition nets are",
        ],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="t" inscription="4294967295"/><arc id="b" source="p" target="t"/>"#,
        &[
            "3:96: the arc `b` and those beside it have a weight of more than 4294967295 together => at most that is possible",
        ],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="t" type="inhibitor"/>"#,
        &["3:76: the arc `a` is of the type `inhibitor` => only ordinary arcs are read, which take and give tokens"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="t"><type value="reset"/></arc>"#,
        &["3:83: the arc `a` is of the type `reset` => only ordinary arcs are read, which take and give tokens"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><arc id="a" source="p" target="t"><arctype><text>read</text></arctype></arc>"#,
        &["3:85: the arc `a` is of the type `read` => only ordinary arcs are read, which take and give tokens"],
    ),
    (
        r#"<place id="p"/><transition id="t"/><inhibitorArc id="a" source="p" target="t"/>"#,
        &[
            "3:36: `inhibitorArc` is a kind of arc that is not known here => only ordinary arcs are read, which take and give tokens",
        ],
    ),
    (
        r#"<place id="p"><hlinitialMarking><text>1</text></hlinitialMarking></place>"#,
        &["3:15: `hlinitialMarking` belongs to a coloured net => only place/transition nets are read; unfold it first"],
    ),
    (
        r#"<transition id="t"><priority><value>1</value></priority></transition><transition id="u"><priority><value>2</value></priority></transition>"#,
        &[
            "3:89: the priority of the transition `u` is 2, another one's is 1 => priorities are not read: give all transitions the same",
        ],
    ),
    (
        r#"<place id="p"/><referencePlace id="r" ref="s"/>"#,
        &["3:44: `r` refers to `s`, which is no node of the net => write the id of a place"],
    ),
    (
        r#"<place id="p"/><referenceTransition id="r" ref="p"/>"#,
        &["3:49: `r` refers to `p`, which is no transition => write the id of a transition"],
    ),
    (
        r#"<referencePlace id="r" ref="s"/><referencePlace id="s" ref="r"/><place id="p"/>"#,
        &["3:1: `r` refers to itself => a reference leads, over others perhaps, to a node"],
    ),
    (
        r#"<place id="p"/><referencePlace id="r"/>"#,
        &["3:16: this reference to a place has no `ref` => write the id of the place it stands for"],
    ),
    (
        r#"<place id="p"><name><text>a &shy; b</text></name></place>"#,
        &[
            "3:29: `&shy;` stands for no character that is known here => `&lt; &gt; &amp; &quot; &apos;` and `&#number;` are read, and entities of one's own are not",
        ],
    ),
    (
        r#"<place id="p"><name><text>bell &#7;</text></name></place>"#,
        &[
            "3:32: `&#7;` stands for no character that is known here => `&lt; &gt; &amp; &quot; &apos;` and `&#number;` are read, and entities of one's own are not",
        ],
    ),
    (
        r#"<place id="p" id="q"/>"#,
        &[
            "3:1: an attribute of `place` cannot be read: position 13: duplicated attribute, previous declaration at position 6",
        ],
    ),
    ("", &["2:1: the net has neither a place nor a transition"]),
];

#[test]
fn what_is_wrong_with_a_net_is_said_where_it_is() {
    let mut wrong = Vec::new();
    for (inside, expected) in IN_A_NET {
        let found = said(with(inside).as_bytes());
        if found != *expected {
            wrong.push(format!("{inside}\n  expected {expected:#?}\n  found    {found:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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
