//! Names of nodes with wildcards.

use linewright_parameters::{NodePattern, PatternError};
use proptest::prelude::*;

fn matches(pattern: &str, node: &str) -> bool {
    NodePattern::read(pattern).expect("a pattern").matches(node)
}

#[test]
fn wildcards_stand_for_whole_parts_as_in_ros() {
    for (pattern, node, expected) in [
        ("/**", "/drill", true),
        ("/**", "/hall/line/drill", true),
        ("/*", "/drill", true),
        ("/*", "/line/drill", false),
        ("/*/drill", "/line/drill", true),
        ("/*/drill", "/hall/line/drill", false),
        ("/**/drill", "/drill", true),
        ("/**/drill", "/hall/line/drill", true),
        ("/**/drill", "/hall/line/mill", false),
        ("/line/**", "/line/drill", true),
        ("/line/**", "/other/drill", false),
        ("/line/drill", "/line/drill", true),
        ("/line/drill", "/line/drill_2", false),
        ("drill", "/drill", true),
        ("drill", "/line/drill", false),
        ("line/drill", "/line/drill", true),
        ("/**/line/*", "/hall/line/drill", true),
        ("/**/line/*", "/line/hall/drill", false),
    ] {
        assert_eq!(matches(pattern, node), expected, "{pattern} {node}");
    }
}

#[test]
fn a_name_that_no_node_has_is_refused() {
    let read = |text| NodePattern::read(text).expect_err("no pattern");
    for text in ["", "/", "/a//b", "/a/"] {
        assert_eq!(read(text), PatternError::EmptyPart, "{text}");
    }
    for text in ["/drill_*", "/*drill", "/***"] {
        assert!(matches!(read(text), PatternError::PartOfPart(_)), "{text}");
    }
    for text in ["/1a", "/a b", "/dr-ill", "/schön"] {
        assert!(matches!(read(text), PatternError::Characters(_)), "{text}");
    }
}

/// By trying all ways, without a table.
fn stands_for(tokens: &[&str], parts: &[&str]) -> bool {
    match (tokens.split_first(), parts.split_first()) {
        (None, None) => true,
        (None, Some(_)) => false,
        (Some((&"**", rest)), None) => stands_for(rest, parts),
        (Some((&"**", rest)), Some((_, fewer))) => stands_for(rest, parts) || stands_for(tokens, fewer),
        (Some((token, rest)), Some((part, fewer))) => (*token == "*" || token == part) && stands_for(rest, fewer),
        (Some(_), None) => false,
    }
}

proptest! {
    #[test]
    fn a_pattern_matches_what_it_can_stand_for(
        tokens in prop::collection::vec(prop::sample::select(vec!["a", "b", "*", "**"]), 1..5),
        parts in prop::collection::vec(prop::sample::select(vec!["a", "b"]), 1..6),
    ) {
        let (pattern, node) = (format!("/{}", tokens.join("/")), format!("/{}", parts.join("/")));
        prop_assert_eq!(matches(&pattern, &node), stands_for(&tokens, &parts), "{} {}", pattern, node);
    }
}
