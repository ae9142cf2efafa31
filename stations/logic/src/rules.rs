//! The rules that make counts safe, each with a switch.
//!
//! They exist for the checker: an explorer that finds nothing wrong is worth believing only if it finds a collision
//! as soon as one rule is off. A controller runs with all of them; nothing in a description can turn one off.

/// Which rules hold. The default is all of them, and the only choice for a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// Internal variables are counted. Off: one Boolean per operation, on while it is done in its station's present
    /// cycle, as seed 002 §5.3 has it.
    pub counted: bool,
    /// A count goes back before the recovery motion starts. Off: when it is complete.
    pub withdraw_first: bool,
    /// A count goes back only when every station that could build on it has agreed. Off: at once.
    pub ask: bool,
    /// A request has a number that was never used before. Off: all have the same one.
    pub fresh_numbers: bool,
    /// Going home on a recovery path takes the round's counts back, and arriving is the end of the round before. Off:
    /// only what is undone on the way is taken back, and the home operation counts as in any other round.
    pub redo_round: bool,
    /// A recovery path is entered only if the arrows hold into everything it skips, and they go on holding until the
    /// station is home. Off: the home motion starts whatever the neighbours do.
    pub home_waits: bool,
}

impl Default for Rules {
    fn default() -> Self {
        Rules {
            counted: true,
            withdraw_first: true,
            ask: true,
            fresh_numbers: true,
            redo_round: true,
            home_waits: true,
        }
    }
}
