//! The mode decision net: six places, one token, and the condition of every arc.
//!
//! The arcs of Figure 18 are lost. They follow from the seed's §2.3, §2.4 and §5.4:
//!
//! ```text
//!            start, away        auto
//!   home ──────────▶ stand-by ────────▶ auto ──(master stop, all at home)──▶ home
//!     ▲  stop, all     │  ▲ ▲  ◀────────  │ ▲
//!     └── at home ─────┘  │ │ trouble     │ │ auto
//!                     hand│ │             │ │
//!                         ▼ │ trouble     │ │
//!                        hand ────────────┼─┘
//!      selector manual  ┌──────────┐      │
//!   stand-by ─────────▶ │  manual  │ ◀────┼── e-stop, once reset and a selector stands at manual
//!            ◀───────── └──────────┘      │
//!      all selectors auto                 └──▶ (any place) ── e-stop ──▶ e-stop
//! ```
//!
//! *Away*: a coordinator that comes up while a station stands away from home, or a task-driven one between two rests, is in
//! stand-by, since home is only where every station is at its start.
//!
//! Every condition is over [`ModeFacts`], so that a test can try all of them: out of each place at most one arc is ever
//! allowed. Emergency stop comes before trouble, trouble before the operator's command.

use linewright_line::net::ControlMode;
use linewright_nets::{Net, NetBuilder};

/// Commands of an operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModeCommand {
    /// Master start: from home to stand-by; also takes a master stop back.
    Start,
    /// Master stop: halt at home.
    Stop,
    /// Run the chart.
    Auto,
    /// Step by step.
    Hand,
    /// As if every station's selector stood at manual.
    Manual,
    /// Emergency stop.
    EStop,
    /// Ends the emergency stop, once its button is out.
    Reset,
}

impl ModeCommand {
    /// All seven.
    pub const ALL: [ModeCommand; 7] = [
        ModeCommand::Start,
        ModeCommand::Stop,
        ModeCommand::Auto,
        ModeCommand::Hand,
        ModeCommand::Manual,
        ModeCommand::EStop,
        ModeCommand::Reset,
    ];

    /// The word an operator types: `start`, `stop`, `auto`, `hand`, `manual`, `estop`, `reset`.
    pub const fn name(self) -> &'static str {
        match self {
            ModeCommand::Start => "start",
            ModeCommand::Stop => "stop",
            ModeCommand::Auto => "auto",
            ModeCommand::Hand => "hand",
            ModeCommand::Manual => "manual",
            ModeCommand::EStop => "estop",
            ModeCommand::Reset => "reset",
        }
    }

    /// The command with this name; blanks around it and letter case do not matter, nor does a dash in `e-stop`.
    pub fn parse(word: &str) -> Option<Self> {
        let word = word.trim().to_ascii_lowercase().replace('-', "");
        ModeCommand::ALL.into_iter().find(|command| command.name() == word)
    }
}

/// Everything the decision depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ModeFacts {
    /// The command being judged.
    pub command: Option<ModeCommand>,
    /// The emergency stop is latched.
    pub estop: bool,
    /// A fault, an incomplete operation, or a station or device that is not received.
    pub trouble: bool,
    /// Master stop has been given.
    pub stopping: bool,
    /// Every station is at home, at the end of the same round.
    pub all_home: bool,
    /// Some station stands away from home, or from its rests.
    pub away: bool,
    /// No operation is moving.
    pub all_stopped: bool,
    /// Some selector stands at manual.
    pub any_manual: bool,
}

impl ModeFacts {
    /// Every combination of facts and command, for exhaustive tests.
    pub fn all() -> impl Iterator<Item = ModeFacts> {
        (0..1u32 << 7).flat_map(|bits| {
            let on = move |bit: u32| bits & (1 << bit) != 0;
            std::iter::once(None).chain(ModeCommand::ALL.map(Some)).map(move |command| ModeFacts {
                command,
                estop: on(0),
                trouble: on(1),
                stopping: on(2),
                all_home: on(3),
                all_stopped: on(4),
                any_manual: on(5),
                away: on(6),
            })
        })
    }
}

/// An arc of the mode decision net.
#[derive(Clone, Copy, Debug)]
pub struct ModeArc {
    pub from: ControlMode,
    pub to: ControlMode,
    /// Condition.
    pub when: fn(&ModeFacts) -> bool,
}

/// Every arc of the net.
pub const ARCS: [ModeArc; 16] = [
    ModeArc { from: ControlMode::Home, to: ControlMode::EStop, when: |f| f.estop },
    ModeArc { from: ControlMode::StandBy, to: ControlMode::EStop, when: |f| f.estop },
    ModeArc { from: ControlMode::Auto, to: ControlMode::EStop, when: |f| f.estop },
    ModeArc { from: ControlMode::Hand, to: ControlMode::EStop, when: |f| f.estop },
    ModeArc { from: ControlMode::Manual, to: ControlMode::EStop, when: |f| f.estop },
    ModeArc {
        from: ControlMode::Home,
        to: ControlMode::StandBy,
        when: |f| !f.estop && (f.command == Some(ModeCommand::Start) || f.away),
    },
    ModeArc {
        from: ControlMode::StandBy,
        to: ControlMode::Home,
        when: |f| !f.estop && !f.any_manual && f.command == Some(ModeCommand::Stop) && f.all_home && f.all_stopped,
    },
    ModeArc {
        from: ControlMode::StandBy,
        to: ControlMode::Auto,
        when: |f| !f.estop && !f.any_manual && !f.trouble && f.command == Some(ModeCommand::Auto),
    },
    ModeArc {
        from: ControlMode::StandBy,
        to: ControlMode::Hand,
        when: |f| !f.estop && !f.any_manual && !f.trouble && f.all_stopped && f.command == Some(ModeCommand::Hand),
    },
    ModeArc {
        from: ControlMode::StandBy,
        to: ControlMode::Manual,
        when: |f| !f.estop && f.any_manual && f.all_stopped,
    },
    ModeArc { from: ControlMode::Auto, to: ControlMode::StandBy, when: |f| !f.estop && (f.trouble || f.any_manual) },
    ModeArc {
        from: ControlMode::Auto,
        to: ControlMode::Home,
        when: |f| !f.estop && !f.trouble && !f.any_manual && f.stopping && f.all_home && f.all_stopped,
    },
    ModeArc {
        from: ControlMode::Hand,
        to: ControlMode::StandBy,
        when: |f| !f.estop && (f.trouble || f.any_manual || f.command == Some(ModeCommand::Stop)),
    },
    ModeArc {
        from: ControlMode::Hand,
        to: ControlMode::Auto,
        when: |f| !f.estop && !f.trouble && !f.any_manual && f.command == Some(ModeCommand::Auto),
    },
    ModeArc { from: ControlMode::Manual, to: ControlMode::StandBy, when: |f| !f.estop && !f.any_manual },
    ModeArc { from: ControlMode::EStop, to: ControlMode::Manual, when: |f| !f.estop && f.any_manual && f.all_stopped },
];

/// The mode the net goes to from `mode`, if an arc allows it.
pub fn next(mode: ControlMode, facts: &ModeFacts) -> Option<ControlMode> {
    let mut allowed = ARCS.iter().filter(|arc| arc.from == mode && (arc.when)(facts));
    let first = allowed.next()?;
    debug_assert!(allowed.next().is_none(), "the arcs out of {mode} are exclusive");
    Some(first.to)
}

/// The decision as a Petri net: its initial marking is the home position (seed 002 Definition 7).
pub fn net() -> Net {
    let mut builder = NetBuilder::new("mode decision");
    let places = ControlMode::ALL.map(|mode| builder.place(mode.name(), u32::from(mode == ControlMode::Home)));
    for arc in ARCS {
        let transition = builder.transition(format!("{} -> {}", arc.from, arc.to));
        builder.input(transition, places[arc.from as usize], 1);
        builder.output(transition, places[arc.to as usize], 1);
    }
    match builder.build() {
        Ok(net) => net,
        Err(errors) => unreachable!("six places and their arcs have distinct names: {errors:?}"),
    }
}
