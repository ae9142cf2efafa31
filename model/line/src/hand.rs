//! Hand mode: the types of operations within a sequence, and the buttons of each (seed 002 Figure 21 and Table 3).

use crate::ButtonId;

macro_rules! hand_types {
    ($($(#[$doc:meta])* $name:ident = $number:literal,)+) => {
        /// Part of a hand-mode sequence that an operation is, by the seed's number.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum HandType {
            $($(#[$doc])* $name = $number,)+
        }

        impl HandType {
            /// All types, ascending.
            pub const ALL: &[HandType] = &[$(HandType::$name),+];
        }
    };
}

hand_types! {
    Sequence = 1,
    SequenceEnd = 2,
    ReversedStart = 3,
    ReversedMiddle = 4,
    ReversedEnd = 5,
    Single = 6,
}

impl HandType {
    /// The type with that number.
    pub fn numbered(number: i64) -> Option<HandType> {
        HandType::ALL.iter().copied().find(|kind| *kind as i64 == number)
    }

    /// The type's purpose, for hints.
    pub(crate) fn purpose(self) -> &'static str {
        match self {
            HandType::Sequence => "the first or an intermediate operation of a sequence that is never reversed",
            HandType::SequenceEnd => "the last operation of a sequence that is never reversed",
            HandType::ReversedStart => "the first operation of a reversed sequence",
            HandType::ReversedMiddle => "an intermediate operation of a reversed sequence",
            HandType::ReversedEnd => "the last operation of a reversed sequence",
            HandType::Single => "an operation on its own, started by one button and reversed by another",
        }
    }

    /// Whether the type has a button that runs it back.
    pub(crate) fn has_back(self) -> bool {
        match self {
            HandType::Sequence | HandType::SequenceEnd => false,
            HandType::ReversedStart | HandType::ReversedMiddle | HandType::ReversedEnd | HandType::Single => true,
        }
    }

    /// Whether the type has a button that starts what follows.
    pub(crate) fn has_next(self) -> bool {
        self.followed_by().is_none()
    }

    /// The types of which one follows in the same sequence, the last one being its end; none where a sequence ends.
    pub(crate) fn followed_by(self) -> Option<[HandType; 2]> {
        match self {
            HandType::Sequence => Some([HandType::Sequence, HandType::SequenceEnd]),
            HandType::ReversedStart | HandType::ReversedMiddle => {
                Some([HandType::ReversedMiddle, HandType::ReversedEnd])
            }
            HandType::SequenceEnd | HandType::ReversedEnd | HandType::Single => None,
        }
    }

    /// The types of which one comes before in the same sequence; none where a sequence may begin.
    pub(crate) fn preceded_by(self) -> Option<[HandType; 2]> {
        match self {
            HandType::ReversedMiddle | HandType::ReversedEnd => {
                Some([HandType::ReversedStart, HandType::ReversedMiddle])
            }
            HandType::Sequence | HandType::SequenceEnd | HandType::ReversedStart | HandType::Single => None,
        }
    }

    /// An entry of this type; `None` without a button that it needs.
    pub fn with(self, forward: ButtonId, back: Option<ButtonId>, next: Option<ButtonId>) -> Option<HandMode> {
        Some(match self {
            HandType::Sequence => HandMode::Sequence { forward },
            HandType::SequenceEnd => HandMode::SequenceEnd { forward, next: next? },
            HandType::ReversedStart => HandMode::ReversedStart { forward, back: back? },
            HandType::ReversedMiddle => HandMode::ReversedMiddle { forward, back: back? },
            HandType::ReversedEnd => HandMode::ReversedEnd { forward, back: back?, next: next? },
            HandType::Single => HandMode::Single { forward, back: back?, next: next? },
        })
    }
}

impl std::fmt::Display for HandType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (*self as u8).fmt(f)
    }
}

/// Hand mode of one operation: its type and operator commands.
///
/// The types are those of seed 002 Figure 21. In a *sequence* one held button runs several operations one after the
/// other; a *reversed* sequence can be run backwards by a second button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandMode {
    /// Type 1: first or intermediate operation of a sequence that is never reversed.
    Sequence {
        /// `h_a`: held to run.
        forward: ButtonId,
    },
    /// Type 2: last operation of a sequence that is never reversed.
    SequenceEnd {
        /// `h_a`: held to run.
        forward: ButtonId,
        /// `h_c`: pressed to start what follows.
        next: ButtonId,
    },
    /// Type 3: first operation of a reversed sequence.
    ReversedStart {
        /// `h_a`: held to run.
        forward: ButtonId,
        /// `h_b`: held to run back.
        back: ButtonId,
    },
    /// Type 4: intermediate operation of a reversed sequence.
    ReversedMiddle {
        /// `h_a`: held to run.
        forward: ButtonId,
        /// `h_b`: held to run back.
        back: ButtonId,
    },
    /// Type 5: last operation of a reversed sequence.
    ReversedEnd {
        /// `h_a`: held to run.
        forward: ButtonId,
        /// `h_b`: held to run back.
        back: ButtonId,
        /// `h_c`: pressed to start what follows.
        next: ButtonId,
    },
    /// Type 6: started by one command and reversed by another.
    Single {
        /// `h_a`: held to run.
        forward: ButtonId,
        /// `h_b`: held to run back.
        back: ButtonId,
        /// `h_c`: pressed to start what follows.
        next: ButtonId,
    },
}

impl HandMode {
    /// Part of a sequence that the operation is.
    pub fn kind(&self) -> HandType {
        match self {
            HandMode::Sequence { .. } => HandType::Sequence,
            HandMode::SequenceEnd { .. } => HandType::SequenceEnd,
            HandMode::ReversedStart { .. } => HandType::ReversedStart,
            HandMode::ReversedMiddle { .. } => HandType::ReversedMiddle,
            HandMode::ReversedEnd { .. } => HandType::ReversedEnd,
            HandMode::Single { .. } => HandType::Single,
        }
    }

    /// The seed's number of the type, 1 to 6.
    pub fn number(&self) -> u8 {
        self.kind() as u8
    }

    /// `h_a`, the button that runs the operation.
    pub fn forward(&self) -> ButtonId {
        match *self {
            HandMode::Sequence { forward }
            | HandMode::SequenceEnd { forward, .. }
            | HandMode::ReversedStart { forward, .. }
            | HandMode::ReversedMiddle { forward, .. }
            | HandMode::ReversedEnd { forward, .. }
            | HandMode::Single { forward, .. } => forward,
        }
    }

    /// `h_b`, the button that runs it back, where the type has one.
    pub fn back(&self) -> Option<ButtonId> {
        match *self {
            HandMode::Sequence { .. } | HandMode::SequenceEnd { .. } => None,
            HandMode::ReversedStart { back, .. }
            | HandMode::ReversedMiddle { back, .. }
            | HandMode::ReversedEnd { back, .. }
            | HandMode::Single { back, .. } => Some(back),
        }
    }

    /// `h_c`, the button that starts what follows, where it is not `h_a`. At the end of a task several may follow: it
    /// is that of the first one listed.
    pub fn next(&self) -> Option<ButtonId> {
        match *self {
            HandMode::Sequence { .. } | HandMode::ReversedStart { .. } | HandMode::ReversedMiddle { .. } => None,
            HandMode::SequenceEnd { next, .. } | HandMode::ReversedEnd { next, .. } | HandMode::Single { next, .. } => {
                Some(next)
            }
        }
    }
}
