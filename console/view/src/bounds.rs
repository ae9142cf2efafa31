//! Bounds of a page, whatever a node sends.

/// Most entries of a list that is received.
pub const LIST_MAX: usize = 100;

/// Most characters of a text that is received; a longer one is cut, and ends with `…`.
pub const TEXT_MAX: usize = 2000;

/// A text within its bound.
pub fn text(of: &str) -> String {
    match of.char_indices().nth(TEXT_MAX) {
        None => of.to_owned(),
        Some(_) => of.chars().take(TEXT_MAX - 1).chain(['…']).collect(),
    }
}

/// Texts within their bounds.
pub fn texts<'t>(of: impl IntoIterator<Item = &'t String>) -> Vec<String> {
    of.into_iter().take(LIST_MAX).map(|of| text(of)).collect()
}
