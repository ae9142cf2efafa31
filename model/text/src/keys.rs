//! Tables of keys: the contents of a description, written down once, for its reader and for other tools.

use crate::{Fields, Property, Report, Shape};

/// A table of a description as it was written, made by [`keys!`](crate::keys).
pub trait Keys: Sized {
    /// Its name, for messages: "a station", "`moves`".
    const WHAT: &'static str;
    /// Its meaning, for the authors of descriptions, line by line.
    const DOC: &'static [&'static str];

    fn read(fields: &mut Fields<'_>, report: &mut Report) -> Self;

    fn keys() -> Vec<Property>;

    /// Reads its keys, and reports all others.
    fn read_all(mut fields: Fields<'_>, report: &mut Report) -> Self {
        let mut found = Report::default();
        let mut read = Self::read(&mut fields, &mut found);
        let as_meant = fields.as_meant();
        fields.finish(&mut found);
        // What is near a key by its letters may be something else by its value.
        if let Some(mut fields) = as_meant {
            let mut meant = Report::default();
            let read_as_meant = Self::read(&mut fields, &mut meant);
            let fits = fields.misspelled_fit(&meant);
            fields.finish(&mut meant);
            if fits {
                (read, found) = (read_as_meant, meant);
            }
        }
        report.join(found);
        read
    }

    /// Its shape.
    fn shape() -> Shape {
        Shape::Table(Self::DOC, Self::keys())
    }
}

/// Makes structs of tables as they are written, each with its reader and its description.
///
/// A field is a key of the same name, unless another one is given by `as`; its type and its [`KeyKind`](crate::KeyKind) belong
/// together. Keys are read in the order in which they stand here. What is missing or could not be read is `None`, and has been
/// reported. Doc comments are shown by editors to people who write descriptions: they contain unit and bounds.
///
/// ```
/// use linewright_text::{Keys, LocatedName, Report, keys, text, whole, Located};
///
/// keys! {
///     /// A shelf of the store.
///     pub struct Shelf is "a shelf" {
///         /// What it is called.
///         name: Option<LocatedName> = text().required(),
///         /// How many parts there is room for, 1 to 50.
///         room as "places": Option<Located<i64>> = whole(1, 50),
///     }
/// }
///
/// let mut report = Report::default();
/// let text = linewright_text::document("plases = 3", &mut report).unwrap();
/// let shelf = Shelf::read_all(linewright_text::Fields::new(text.as_table(), 0..0, Shelf::WHAT), &mut report);
/// assert!(shelf.name.is_none() && shelf.room.is_some_and(|room| room.value == 3));
/// let problems = format!("{:#}", report.into_problems("shelf.toml", "plases = 3"));
/// assert!(problems.contains("a shelf needs `name`") && problems.contains("unknown key `plases`"));
/// ```
#[macro_export]
macro_rules! keys {
    (@key $field:ident) => { stringify!($field) };
    (@key $field:ident $key:literal) => { $key };
    ($(
        $(#[doc = $doc:literal])+
        $(#[derive($derive:ident)])?
        $vis:vis struct $name:ident is $what:literal {
            $(
                $(#[doc = $about:literal])+
                $field:ident $(as $key:literal)? : $type:ty = $kind:expr
            ),* $(,)?
        }
    )+) => {$(
        $(#[doc = $doc])+
        #[derive(Debug $(, $derive)?)]
        $vis struct $name {
            /// Its header, or all of it where it is written inline.
            #[allow(dead_code, reason = "not every rule is about a place")]
            pub at: $crate::TextRange,
            $($(#[doc = $about])+ pub $field: $type,)*
        }

        impl $crate::Keys for $name {
            const WHAT: &'static str = $what;
            const DOC: &'static [&'static str] = &[$($doc),+];

            fn read(fields: &mut $crate::Fields<'_>, report: &mut $crate::Report) -> Self {
                $name {
                    at: fields.at.clone(),
                    $($field: {
                        let kind: $crate::KeyKind<$type> = $kind;
                        fields.note(&[$($about),+]);
                        kind.read(fields, report, $crate::keys!(@key $field $($key)?))
                    },)*
                }
            }

            fn keys() -> Vec<$crate::Property> {
                let mut keys = Vec::new();
                $({
                    let kind: $crate::KeyKind<$type> = $kind;
                    kind.describe($crate::keys!(@key $field $($key)?), &[$($about),+], &mut keys);
                })*
                keys
            }
        }
    )+};
}
