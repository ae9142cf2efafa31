//! The rules that stand between messages and a controller, each with a switch.
//!
//! They exist for the fault simulation, which is credible only if it finds what happens as soon as one rule is off. A node runs
//! with all of them; nothing in a description can turn one off.

/// Rules in force. The default is all of them, and the only choice for a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShellRules {
    /// An order or a state with an epoch that no coordinator can have given is not followed. Off: it is.
    pub epochs: bool,
    /// An order with a longer lease than the description's is not followed. Off: it is.
    pub leases: bool,
    /// An order that does not name this life of the station is not followed. Off: it is.
    pub lives: bool,
    /// Of the messages of one life the one with the greatest number counts. Off: the last one that arrived.
    pub numbers: bool,
    /// While two coordinators give orders nothing starts, and the second one ends. Off: neither is noticed.
    pub rivals: bool,
    /// After a standstill of the process what was received before it is too old. Off: its age is what its arrival says.
    pub gaps: bool,
    /// What was decided before a record that took long is decided again. Off: it is put out.
    pub late: bool,
    /// What goes off goes off before the record. Off: with everything else, after it.
    pub off_first: bool,
}

impl ShellRules {
    /// All rules in force, as in a machine.
    pub const ALL: ShellRules = ShellRules {
        epochs: true,
        leases: true,
        lives: true,
        numbers: true,
        rivals: true,
        gaps: true,
        late: true,
        off_first: true,
    };
}

impl Default for ShellRules {
    fn default() -> Self {
        ShellRules::ALL
    }
}
