//! Numbers of the elements of lists.

/// Makes ids, each for one list of a checked description: a newtype of `u16` with `index()` and `at(index)`.
///
/// ```
/// linewright_text::index_id! {
///     /// A shelf, by its place in the store.
///     ShelfId
/// }
/// assert_eq!(ShelfId::at(3).index(), 3);
/// ```
#[macro_export]
macro_rules! index_id {
    ($($(#[$doc:meta])* $name:ident)+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u16);

        impl $name {
            /// The id as an index into the vector it belongs to.
            pub const fn index(self) -> usize {
                self.0 as usize
            }

            /// The id of the element at `index`.
            ///
            /// # Panics
            /// When `index` exceeds `u16::MAX`, far above any bound the parser accepts.
            pub fn at(index: usize) -> Self {
                $name(u16::try_from(index).expect("the parser bounds every list below u16::MAX"))
            }
        }
    )+};
}
