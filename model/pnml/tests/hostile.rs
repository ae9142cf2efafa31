//! Files that are made to hurt: too deep, too long, too many, or cut anywhere. Each ends soon, with a net or a problem.

use std::time::{Duration, Instant};

use linewright_pnml::{limits, read};
use proptest::prelude::*;

use crate::common::{ring, said, sound, with};

/// Far more than any of them takes, also on a busy machine, and far less than anything quadratic would.
const SOON: Duration = Duration::from_secs(20);

fn refused_soon(text: &str, expected: &str) {
    let start = Instant::now();
    let said = said(text.as_bytes());
    assert!(said[0].contains(expected), "{}", said[0]);
    assert!(said.iter().all(|line| line.len() < 600), "{said:?}");
    assert!(start.elapsed() < SOON, "{expected}: took {:?}", start.elapsed());
}

#[test]
fn depth_is_bounded() {
    refused_soon(&with(&"<page>".repeat(200_000)), "nested more than 256 deep");
    refused_soon(&with(&"<x>".repeat(200_000)), "nested more than 256 deep");
    let nested = |pages| with(&format!("{}<place id=\"p\"/>{}", "<page>".repeat(pages), "</page>".repeat(pages)));
    let most = limits::DEPTH_MAX - 3;
    assert_eq!(sound(&nested(most)).place_count(), 1);
    refused_soon(&nested(most + 1), "nested more than 256 deep");
}

#[test]
fn numbers_are_bounded() {
    let marking =
        |text: &str| with(&format!("<place id=\"p\"><initialMarking><text>{text}</text></initialMarking></place>"));
    refused_soon(&marking(&"9".repeat(200_000)), "the initial marking of the place `p` is `999");
    refused_soon(&marking(&format!("-{}", "1".repeat(1000))), "is `-111");
    assert_eq!(sound(&marking(&format!("{}7", "0".repeat(1000)))).initial_marking().total(), 7);
}

#[test]
fn entities_are_not_expanded() {
    let bomb =
        (1..20).map(|n| format!("<!ENTITY a{n} \"{}\">", format!("&a{};", n - 1).repeat(10))).collect::<String>();
    let file = format!(
        "<!DOCTYPE pnml [<!ENTITY a0 \"ha\">{bomb}<!ENTITY f SYSTEM \"file:///etc/passwd\">]>\n{}",
        with("<place id=\"p\"><name><text>&a19;&f;</text></name></place><place id=\"&a19;\"/>")
    );
    let said = said(file.as_bytes());
    assert!(said[0].contains("`&a19;` stands for no character") && said[1].contains("`&f;`"), "{said:#?}");
    assert!(said[2].contains("the attribute `id` cannot be read"), "{said:#?}");
}

#[test]
fn ids_names_and_attributes_are_bounded() {
    let long = "x".repeat(10_000_000);
    refused_soon(&with(&format!("<place id=\"{long}\"/>")), "the attribute `id` has 10000000 bytes");
    refused_soon(
        &with(&format!("<place id=\"p\"><name><text>{long}</text></name></place>")),
        "a name has more than 4096 bytes",
    );
    refused_soon(&with(&format!("<{long} id=\"p\"/><place/>")), "this place has no id");
    refused_soon(&with("<place id=\"a&#27;\"/>"), "the attribute `id` has a character that is not allowed in XML");
    refused_soon(&with(&format!("<place id=\"p\"></{long}>")), "`</place>` is expected here, not `</xxx");
    refused_soon(&with(&format!("<place id=\"&{long};\"/>")), "the attribute `id` has 10000002 bytes");
    refused_soon(&with(&format!("<place id=\"&{};\"/>", "x".repeat(4000))), "the attribute `id` cannot be read");
    let many: String = (0..200_000).map(|n| format!(" a{n}=\"\"")).collect();
    refused_soon(&with(&format!("<place{many} id=\"p\"/>")), "more than 64 attributes");
    refused_soon(&with(&format!("<place id=\"p\"{many}>")), "`</place>` is expected here, not `</net>`");
    refused_soon(&format!("<pnml>{}</pnml>", "<net/>".repeat(200_000)), "more than 10000 nets");
}

#[test]
fn many_problems_are_cut() {
    refused_soon(&with(&"<place/>\n".repeat(200_000)), "this place has no id");
    refused_soon(&with(&"<arc source=\"p\" target=\"q\"/>".repeat(100_000)), "this arc comes from `p`");
    let ring: String =
        (0..100_000).map(|n| format!("<referencePlace id=\"r{n}\" ref=\"r{}\"/>", (n + 1) % 100_000)).collect();
    refused_soon(&with(&ring), "`r0` refers to itself");
    assert_eq!(said(with(&ring).as_bytes()).len(), 1, "one ring is one problem");
}

#[test]
fn a_large_net_is_read() {
    let start = Instant::now();
    let places: String = (0..100_000).map(|n| format!("<place id=\"p{n}\"/>")).collect();
    let references: String = (0..100_000)
        .map(|n| {
            format!(
                "<referencePlace id=\"r{n}\" ref=\"{}\"/>",
                if n == 0 { "p0".to_owned() } else { format!("r{}", n - 1) }
            )
        })
        .collect();
    let net = sound(&with(&format!("{places}{references}<transition id=\"t\"/><arc source=\"r99999\" target=\"t\"/>")));
    assert_eq!((net.place_count(), net.consumers(net.place_named("p0").unwrap()).len()), (100_000, 1));
    assert!(start.elapsed() < SOON, "took {:?}", start.elapsed());
}

#[test]
fn a_file_cut_anywhere_is_a_problem_at_its_end() {
    let whole = ring(1);
    let end = whole.trim_end().len();
    for at in 1..end {
        assert!(read("cut.pnml", &whole.as_bytes()[..at], None).is_err(), "cut at {at}");
    }
    assert!(read("whole.pnml", &whole.as_bytes()[..end], None).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_end_with_a_net_or_with_problems(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        if read("any.pnml", &bytes, None).is_err() {
            said(&bytes);
        }
    }

    #[test]
    fn slips_end_with_a_net_or_with_problems(slips in prop::collection::vec((0.0..1.0, 0_usize..9, slip()), 1..5)) {
        let mut text = ring(1).into_bytes();
        for (at, removed, inserted) in slips {
            let start = (text.len() as f64 * at) as usize;
            let end = (start + removed).min(text.len());
            text.splice(start..end, inserted.into_bytes());
        }
        if read("any.pnml", &text, None).is_err() {
            said(&text);
        }
    }
}

fn slip() -> impl Strategy<Value = String> {
    let words = vec![
        "<",
        ">",
        "\"",
        "&",
        ";",
        "</",
        "/>",
        "<!--",
        "-->",
        "<![CDATA[",
        "]]>",
        "<page>",
        "</page>",
        "\u{0}",
        "é",
        "\n",
        "-1",
        "<?",
        "<!DOCTYPE",
        "=\"",
        "id=\"o_0_0\"",
    ];
    prop_oneof![prop::sample::select(words).prop_map(String::from), any::<char>().prop_map(String::from)]
}
