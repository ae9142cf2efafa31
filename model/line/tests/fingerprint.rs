//! The fingerprint of a description changes with what the nodes do by it, and with nothing else.

use linewright_line::{TransferLine, parse};

use crate::devices::LINE;

fn fingerprint(text: &str) -> u64 {
    parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line.fingerprint()
}

/// The shipped line with a text replaced.
fn with(from: &str, to: &str) -> u64 {
    let text = TransferLine::default().text();
    assert!(text.contains(from), "{from}");
    fingerprint(&text.replacen(from, to, 1))
}

#[test]
fn comments_titles_and_written_out_defaults_change_nothing() {
    let text = TransferLine::default().text();
    let usual = fingerprint(&text);
    assert_eq!(fingerprint(&format!("# A remark.\n{text}\n[timing]\nstale_ms = 250\n")), usual);
    assert_eq!(with("title = \"Transfer line\"", "title = \"Another title\""), usual);
    assert_eq!(with("why = \"", "why = \"still: "), usual);
    // The place of a name in the text is in the model too.
    assert_eq!(fingerprint(&format!("# A remark.\n{}", *LINE)), fingerprint(&LINE));
}

#[test]
fn arrows_times_names_and_bits_change_it() {
    let usual = fingerprint(&TransferLine::default().text());
    let others = [
        with("lag = 1", "lag = 2"),
        with("\n[[station]]", "\n[timing]\nlease_ms = 600\n\n[[station]]"),
        with("watchdog_s = ", "watchdog_s = 1"),
        with("node = 0x11", "node = 0x31"),
    ];
    for (at, other) in others.iter().enumerate() {
        assert!(*other != usual && !others[..at].contains(other), "{at}");
    }
}
