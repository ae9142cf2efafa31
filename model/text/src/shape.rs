//! Permitted contents of a description, as data, for editors and other tools.
//!
//! A shape holds keys, types and bounds. Names, and what holds between keys, are left to the rules of a description.

/// Permitted contents of one place.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    Text,
    /// Text that matches this regular expression.
    Like(&'static str),
    /// One of these words.
    Word(Vec<&'static str>),
    /// True or false.
    Flag,
    /// A whole number from the first to the second.
    Whole(i64, i64),
    /// A number from the first to the second.
    Number(f64, f64),
    /// A list of at most so many.
    List(Box<Shape>, usize),
    /// A table of at most so many names, which are the user's own.
    Names(Box<Shape>, usize),
    /// A table with these keys, and what it is.
    Table(&'static [&'static str], Vec<Property>),
    /// Keys of the table around it.
    Part(Vec<Property>),
    /// Any of these.
    Either(Vec<Shape>),
}

/// A key of a table, and what may stand there.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    pub key: &'static str,
    /// Meaning, with unit and bounds, line by line.
    pub doc: &'static [&'static str],
    /// Permitted contents.
    pub shape: Shape,
    /// Whether it may be left out.
    pub presence: KeyPresence,
    /// Default.
    pub usual: Option<Usual>,
}

/// Whether a key may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyPresence {
    /// It may.
    Optional,
    /// It may not.
    Required,
    /// It may where this other key is written.
    Unless(&'static [&'static str]),
}

/// Default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Usual {
    Word(&'static str),
    /// True or false.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    Number(f64),
}

impl From<bool> for Usual {
    fn from(flag: bool) -> Self {
        Usual::Flag(flag)
    }
}

impl From<i32> for Usual {
    fn from(number: i32) -> Self {
        Usual::Whole(number.into())
    }
}

impl From<i64> for Usual {
    fn from(number: i64) -> Self {
        Usual::Whole(number)
    }
}

impl From<f64> for Usual {
    fn from(number: f64) -> Self {
        Usual::Number(number)
    }
}

/// Any whole number.
pub(crate) const ANY_WHOLE: Shape = Shape::Whole(i64::MIN, i64::MAX);
pub(crate) const ANY_NUMBER: Shape = Shape::Number(f64::NEG_INFINITY, f64::INFINITY);

/// The lines of a doc comment as one text.
pub fn sentences(doc: &[&str]) -> String {
    doc.iter().map(|line| line.trim()).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}
