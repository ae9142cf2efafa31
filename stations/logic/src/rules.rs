//! The rules that make counts safe, each with a switch.
//!
//! They exist for the checker: an explorer without findings is credible only if it finds a collision as soon as one
//! rule is off. A controller runs with all of them; nothing in a description can turn one off.

/// Rules in force. The default is all of them, and the only choice for a machine.
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
    /// Counts of another generation, of a station whose position is lost, and of one further ahead than the arrows allow, are
    /// unknown. Off: counts are compared whatever becomes of a memory.
    pub generations: bool,
    /// Measured positions are the second barrier (see `interlock`). Off: counts alone.
    pub positions: bool,
    /// An axis that stands still by the chart is measured there (see `interlock`). Off: wherever it is.
    pub rests: bool,
    /// A switch at another place of an axis contradicts the one that measures it clear. Off: the one is believed.
    pub contradicted: bool,
    /// In manual a motion that relies on measured positions alone starts by agreement (see `entry`). Off: two stations may start
    /// within the time that a report takes.
    pub entry: bool,
    /// Arrows are observed. Off, the second barrier stands alone: arrows are not waited for, and a count is taken back
    /// without agreement.
    pub arrows: bool,
    /// A switch completes a motion only if it was seen off since the motion began. Off: one that sticks completes it at once.
    pub seen_off: bool,
    /// An index that is complete in less than half its time is in doubt. Off: for callers that keep the clock still.
    pub timely: bool,
}

impl Rules {
    /// The counts by themselves, within one generation: the first barrier without its protection from lost memories.
    pub const COUNTS: Rules = Rules { generations: false, positions: false, timely: false, ..Rules::ALL };

    /// All rules in force, as in a machine.
    pub const ALL: Rules = Rules {
        counted: true,
        withdraw_first: true,
        ask: true,
        fresh_numbers: true,
        redo_round: true,
        home_waits: true,
        generations: true,
        positions: true,
        rests: true,
        contradicted: true,
        entry: true,
        arrows: true,
        seen_off: true,
        timely: true,
    };
}

/// Rules of orders in force, of a task-driven station. As with [`Rules`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OrderRules {
    /// An order whose time is over has not ended before the station stands. Off: it ends at once, and the station goes back.
    pub ends_standing: bool,
    /// A station goes back from an ended order once. Off: with every copy of the message.
    pub secures_once: bool,
    /// No key is done twice, and none that is older than the newest. Off: every order is done.
    pub does_once: bool,
    /// An order that is meant for another memory is refused. Off: it is done.
    pub own_memory: bool,
    /// Ordered to stop it stands at once, and copies of a message to go back move nothing later. Off: it goes back.
    pub stops_at_once: bool,
}

impl Default for OrderRules {
    fn default() -> Self {
        OrderRules { ends_standing: true, secures_once: true, does_once: true, own_memory: true, stops_at_once: true }
    }
}

impl Default for Rules {
    fn default() -> Self {
        Rules::ALL
    }
}
