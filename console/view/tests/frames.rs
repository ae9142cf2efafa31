//! Frames: changes add up to the page, a reader that has missed one is given the whole, and what is no frame leaves the page as it is.

use linewright_console_view::{PageChange, PageFeed, PageFrameError, PageReader};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::bench::{ViewBench, ms};

/// Any JSON of a few levels with keys that occur again.
fn json_value() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        (0_u64..4).prop_map(Value::from),
        "[a-c0/~]{0,2}".prop_map(Value::from),
    ];
    leaf.prop_recursive(4, 40, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            prop::collection::btree_map("[a-c0/~]{1,2}", inner, 0..4)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

proptest! {
    #[test]
    fn changes_make_the_old_page_the_new_one(old in json_value(), new in json_value()) {
        let changes = PageChange::between(&old, &new);
        prop_assert_eq!(changes.is_empty(), old == new);
        let mut page = old;
        for change in changes {
            change.apply(&mut page).expect("its place is there");
        }
        prop_assert_eq!(page, new);
    }

    /// A reader that is given frames as a server gives them, some of them skipped.
    #[test]
    fn a_reader_has_the_page_of_its_newest_frame(pages in prop::collection::vec((json_value(), any::<bool>()), 1..12)) {
        let (mut feed, mut reader, mut last) = (PageFeed::default(), PageReader::default(), None);
        for (at, (page, is_read)) in pages.into_iter().enumerate() {
            let page = json!({ "of": page });
            let frame = feed.frame_of(ms(at as u64), page.clone());
            if is_read {
                last = Some(reader.take(frame.text_after(last)).expect("it fits"));
                prop_assert_eq!((reader.page(), reader.now_ms(), last), (&page, at as u64, Some(frame.sequence())));
            }
        }
    }
}

#[test]
fn pages_of_a_line_are_sent_as_what_has_changed() {
    let mut bench = ViewBench::received(0);
    let (mut feed, mut reader) = (PageFeed::default(), PageReader::default());
    let whole = feed.frame(ms(0), &bench.page(0));
    let size = whole.text_after(None).len();
    reader.take(whole.text_after(None)).expect("it fits");
    bench.stations[1].as_mut().expect("received").0.operation = "advance clamp".to_owned();
    let page = bench.page(10);
    let frame = feed.frame(ms(10), &page);
    let changes = frame.text_after(Some(1));
    assert_eq!(changes, r#"{"changes":[[["stations",1,"operation"],"advance clamp"]],"now_ms":10,"sequence":2}"#);
    assert!(size > 10 * changes.len(), "{size}");
    reader.take(changes).expect("it fits");
    assert_eq!(*reader.page(), serde_json::to_value(&page).expect("JSON"));
}

#[test]
fn what_does_not_fit_is_refused_and_the_page_stays() {
    let mut reader = PageReader::default();
    let changes =
        |sequence: u64, path: Value| json!({ "sequence": sequence, "now_ms": 1, "changes": [[path, 1]] }).to_string();
    assert_eq!(reader.take(&changes(2, json!(["a"]))), Err(PageFrameError::Missed { expected: 1, is: 0 }));
    let whole = json!({ "sequence": 5, "now_ms": 1, "page": { "a": 0, "b": [0] } }).to_string();
    assert_eq!(reader.take(&whole), Ok(5));
    assert_eq!(reader.take(&changes(7, json!(["a"]))), Err(PageFrameError::Missed { expected: 6, is: 5 }));
    for path in [json!(["c"]), json!(["b", 1]), json!(["a", "x"]), json!(["b", "0"])] {
        assert_eq!(reader.take(&changes(6, path)), Err(PageFrameError::NoSuchPlace));
    }
    for text in ["", "{}", "[]", r#"{"sequence":-1,"now_ms":0}"#] {
        assert!(matches!(reader.take(text), Err(PageFrameError::NotAFrame(_))), "{text}");
    }
    assert_eq!(*reader.page(), json!({ "a": 0, "b": [0] }));
    assert_eq!(reader.take(&changes(6, json!(["b", 0]))), Ok(6));
}
