//! Codes go there and back, and records keep their spelling.

use linewright_orders::{OrderKey, TaskFailure, TaskRefusal};

#[test]
fn codes_go_there_and_back() {
    for code in 0..=u16::MAX {
        assert_eq!(TaskFailure::from_code(code).code(), code);
        if let Some(refusal) = TaskRefusal::from_code(code) {
            assert_eq!(refusal.code(), code);
        }
    }
    for refusal in TaskRefusal::ALL {
        assert_eq!(TaskRefusal::from_code(refusal.code()), Some(refusal));
    }
    assert_eq!(TaskFailure::from_code(999), TaskFailure::Waiting(999));
    assert_eq!(TaskFailure::from_code(1006), TaskFailure::Stopped);
    assert_eq!(TaskFailure::from_code(1007), TaskFailure::Other(1007));
    assert_eq!([0, 12].map(TaskRefusal::from_code), [None, None]);
}

/// Logs of cells contain them.
#[test]
fn the_spelling_in_records_stays() {
    let words = TaskRefusal::ALL.map(|refusal| serde_json::to_string(&refusal).expect("a word"));
    let expected = [
        "busy",
        "mode",
        "other-memory",
        "old-epoch",
        "old",
        "late",
        "not-there",
        "devices",
        "unknown",
        "incomplete",
        "isolated",
    ];
    assert_eq!(words, expected.map(|word| format!("\"{word}\"")));
    let key = OrderKey { epoch: 3, id: 41 };
    assert_eq!(serde_json::to_string(&key).expect("a key"), r#"{"epoch":3,"id":41}"#);
    assert!(serde_json::from_str::<OrderKey>(r#"{"epoch":3,"id":41,"at":1}"#).is_err());
    assert_eq!(key.to_string(), "order 3.41");
}
