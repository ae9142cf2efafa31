//! Kinds of keys: reading, and shape.

use std::rc::Rc;
use std::time::Duration;

use crate::fields::{COORDINATE_MAX, DURATION_MAX_S, DURATION_MIN_S, MILLIS_MAX, POSITIVE_MAX, POSITIVE_MIN};
use crate::shape::{ANY_NUMBER, ANY_WHOLE};
use crate::{Fields, KeyPresence, Keys, Located, LocatedName, Named, Property, Report, Scalar, Shape, Usual};

type Reader<T> = dyn Fn(&mut Fields<'_>, &mut Report, &'static str) -> T;

/// Reading of the value of a key into a `T`, and its shape in the text.
pub struct KeyKind<T> {
    read: Box<Reader<T>>,
    shape: Rc<dyn Fn() -> Shape>,
    presence: KeyPresence,
    usual: Option<Usual>,
}

impl<T: 'static> KeyKind<T> {
    /// A kind that is read so, and looks so.
    pub fn new(
        read: impl Fn(&mut Fields<'_>, &mut Report, &'static str) -> T + 'static,
        shape: impl Fn() -> Shape + 'static,
    ) -> Self {
        KeyKind { read: Box::new(read), shape: Rc::new(shape), presence: KeyPresence::Optional, usual: None }
    }

    /// Reads the value at `key`.
    pub fn read(&self, fields: &mut Fields<'_>, report: &mut Report, key: &'static str) -> T {
        (self.read)(fields, report, key)
    }

    /// Adds what stands at `key` to a table's keys.
    pub fn describe(&self, key: &'static str, doc: &'static [&'static str], keys: &mut Vec<Property>) {
        match (self.shape)() {
            Shape::Part(inside) => keys.extend(inside),
            shape => keys.push(Property { key, doc, shape, presence: self.presence, usual: self.usual }),
        }
    }

    /// The same, turned into something else once it is read.
    pub fn then<U: 'static>(self, turn: fn(T, &mut Report) -> U) -> KeyKind<U> {
        let read = self.read;
        KeyKind {
            read: Box::new(move |fields, report, key| {
                let read = read(fields, report, key);
                turn(read, report)
            }),
            shape: self.shape,
            presence: self.presence,
            usual: self.usual,
        }
    }

    /// The same, with a narrower shape: what a later rule checks.
    pub fn like(self, shape: impl Fn() -> Shape + 'static) -> Self {
        KeyKind { shape: Rc::new(shape), ..self }
    }

    /// The same; a later rule checks that it is from `low` to `high`.
    pub fn from_to(self, low: i64, high: i64) -> Self {
        self.like(move || Shape::Whole(low, high))
    }

    /// The same; a later rule, not the reader, reports that it is missing.
    pub fn missed(self, presence: KeyPresence) -> Self {
        KeyKind { presence, ..self }
    }

    /// The same; a later rule takes `usual` where nothing is written.
    pub fn usually(self, usual: impl Into<Usual>) -> Self {
        KeyKind { usual: Some(usual.into()), ..self }
    }
}

impl<T: 'static> KeyKind<Option<T>> {
    /// The key of this kind as one that may not be missing.
    pub fn required(self) -> Self {
        let (read, shape) = (self.read, self.shape.clone());
        KeyKind {
            read: Box::new(move |fields, report, key| {
                let found = read(fields, report, key);
                fields.require(report, key, &*shape, found)
            }),
            presence: KeyPresence::Required,
            ..self
        }
    }

    /// The same, which may be missing only where one of `others` is written.
    pub fn required_unless(self, others: &'static [&'static str]) -> Self {
        let (read, shape) = (self.read, self.shape.clone());
        KeyKind {
            read: Box::new(move |fields, report, key| {
                let found = read(fields, report, key);
                let is_other = others.iter().any(|other| fields.has(other));
                if is_other { found } else { fields.require(report, key, &*shape, found) }
            }),
            presence: KeyPresence::Unless(others),
            ..self
        }
    }

    /// The key of this kind with the default value where it is missing.
    pub fn or_default(self) -> KeyKind<T>
    where
        T: Default,
    {
        self.then(|found, _| found.unwrap_or_default())
    }
}

impl<T: Copy + Into<Usual> + 'static> KeyKind<Option<Located<T>>> {
    /// The same without its place, and `usual` where nothing is written.
    pub fn or(self, usual: T) -> KeyKind<T> {
        let read = self.read;
        KeyKind {
            read: Box::new(move |fields, report, key| read(fields, report, key).map_or(usual, |found| found.value)),
            shape: self.shape,
            presence: self.presence,
            usual: Some(usual.into()),
        }
    }
}

impl<T: 'static> KeyKind<Option<Located<Vec<T>>>> {
    /// Entries of the list; nothing where none is written.
    pub fn entries(self) -> KeyKind<Vec<T>> {
        self.then(|found, _| found.map(|list| list.value).unwrap_or_default())
    }
}

/// Any text.
pub fn text() -> KeyKind<Option<LocatedName>> {
    KeyKind::new(|f, report, key| f.text(report, key), || Shape::Text)
}

/// True or false.
pub fn flag() -> KeyKind<Option<Located<bool>>> {
    KeyKind::new(|f, report, key| f.flag(report, key), || Shape::Flag)
}

/// A whole number.
pub fn integer() -> KeyKind<Option<Located<i64>>> {
    KeyKind::new(|f, report, key| f.integer(report, key), || ANY_WHOLE)
}

/// A whole number within bounds.
pub fn whole(low: i64, high: i64) -> KeyKind<Option<Located<i64>>> {
    KeyKind::new(move |f, report, key| f.whole(report, key, low, high), move || Shape::Whole(low, high))
}

/// Any number.
pub fn number() -> KeyKind<Option<Located<f64>>> {
    KeyKind::new(|f, report, key| f.number(report, key), || ANY_NUMBER)
}

/// A number within bounds.
pub fn within(low: f64, high: f64) -> KeyKind<Option<Located<f64>>> {
    KeyKind::new(move |f, report, key| f.within(report, key, low, high), move || Shape::Number(low, high))
}

/// A number above zero: a distance, a speed, a ratio.
pub fn positive() -> KeyKind<Option<Located<f64>>> {
    KeyKind::new(|f, report, key| f.positive(report, key), || Shape::Number(POSITIVE_MIN, POSITIVE_MAX))
}

fn on_an_axis() -> Shape {
    Shape::Number(-COORDINATE_MAX, COORDINATE_MAX)
}

/// A coordinate in millimetres.
pub fn coordinate() -> KeyKind<Option<Located<f64>>> {
    KeyKind::new(|f, report, key| f.coordinate(report, key), on_an_axis)
}

/// A positive duration in seconds.
pub fn seconds() -> KeyKind<Option<Located<Duration>>> {
    KeyKind::new(|f, report, key| f.seconds(report, key), || Shape::Number(DURATION_MIN_S, DURATION_MAX_S))
}

/// A period in whole milliseconds.
pub fn millis() -> KeyKind<Option<Located<Duration>>> {
    KeyKind::new(|f, report, key| f.millis(report, key), || Shape::Whole(1, MILLIS_MAX))
}

fn words<T>(known: &'static [(&'static str, T)]) -> Shape {
    Shape::Word(known.iter().map(|(word, _)| *word).collect())
}

/// One of a few words; the first one where nothing is written.
pub fn word<T: Copy>(known: &'static [(&'static str, T)]) -> KeyKind<T> {
    let read = KeyKind::new(move |f, report, key| f.word(report, key, known), || words(known));
    KeyKind { usual: known.first().map(|(word, _)| Usual::Word(word)), ..read }
}

/// One of a few words, and its place.
pub fn one_of<T: Copy>(known: &'static [(&'static str, T)]) -> KeyKind<Option<Located<T>>> {
    KeyKind::new(move |f, report, key| f.maybe_word(report, key, known), || words(known))
}

/// A list of texts, at most `max` long.
pub fn texts(max: usize) -> KeyKind<Option<Located<Vec<LocatedName>>>> {
    KeyKind::new(move |f, report, key| f.texts(report, key, max), move || Shape::List(Box::new(Shape::Text), max))
}

/// A table of at most `max` coordinates, under names that are the user's own.
pub fn coordinates(max: usize) -> KeyKind<Option<Named<f64>>> {
    KeyKind::new(
        move |f, report, key| f.coordinates(report, key, max),
        move || Shape::Names(Box::new(on_an_axis()), max),
    )
}

/// A table of at most `max` texts, under names that are the user's own.
pub fn texts_by_name(max: usize) -> KeyKind<Option<Named<LocatedName>>> {
    KeyKind::new(
        move |f, report, key| f.texts_by_name(report, key, max),
        move || Shape::Names(Box::new(Shape::Text), max),
    )
}

/// A table of at most `max` texts or whole numbers, under names that are the user's own.
pub fn scalars(max: usize) -> KeyKind<Option<Named<Located<Scalar>>>> {
    KeyKind::new(
        move |f, report, key| f.scalars(report, key, max),
        move || Shape::Names(Box::new(Shape::Either(vec![Shape::Text, ANY_WHOLE])), max),
    )
}

/// A table of at most `max` lists of texts, each at most `longest` long, under names that are the user's own.
pub fn lists(max: usize, longest: usize) -> KeyKind<Option<Named<Located<Vec<LocatedName>>>>> {
    KeyKind::new(
        move |f, report, key| f.lists(report, key, max, longest),
        move || Shape::Names(Box::new(Shape::List(Box::new(Shape::Text), longest)), max),
    )
}

/// A table inside this one.
pub fn table<K: Keys + 'static>() -> KeyKind<Option<K>> {
    KeyKind::new(|f, report, key| Some(K::read_all(f.table(report, key, K::WHAT)?, report)), K::shape)
}

/// A list of tables, at most `max` long.
pub fn tables<K: Keys + 'static>(max: usize) -> KeyKind<Vec<K>> {
    KeyKind::new(
        move |f, report, key| {
            let tables = f.tables(report, key, K::WHAT, max);
            tables.into_iter().map(|table| K::read_all(table, report)).collect()
        },
        move || Shape::List(Box::new(K::shape()), max),
    )
}

/// Some keys of this table that are the same in another one, read as one value.
pub fn part<K: Keys + 'static>() -> KeyKind<K> {
    KeyKind::new(|f, report, _| K::read(f, report), || Shape::Part(K::keys()))
}

/// Nothing that can be written: a value that another table of the same struct has.
pub fn nothing<T: Default + 'static>() -> KeyKind<T> {
    KeyKind::new(|_, _, _| T::default(), || Shape::Part(Vec::new()))
}

/// Whether anything is written at a key that is read for itself, even if it cannot be read.
pub fn written() -> KeyKind<bool> {
    KeyKind::new(|f, _, key| f.has(key), || Shape::Part(Vec::new()))
}
