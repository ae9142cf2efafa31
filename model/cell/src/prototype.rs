//! The prototypes that resources are instances of, and what each can do.
//!
//! The only module with the actions of each prototype and the meaning of its capacity; the places and arcs of an
//! instance are in [`crate::net`]. The machine is the one of seed 001 (L68-70, Figs. 2 and 3).

/// Prototype of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Prototype {
    /// Works on parts: available-capacity, loaded, unload-ready.
    Machine,
    /// A machine that can also carry: one token for all work.
    Human,
    /// Keeps parts, and gives back any of them.
    RandomAccessStore,
    /// Keeps parts in a row: in at one end, out at the other.
    FifoBuffer,
    /// A stack: the part that came last goes first.
    LifoBuffer,
    /// Carries one part at a time.
    Robot,
    /// Carries several parts at a time.
    Conveyor,
}

/// Action of a resource when an activity happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ResourceAction {
    /// A machine takes a part.
    Load,
    /// A machine works on the part it has.
    Process,
    /// A machine gives the part it has worked on.
    Unload,
    /// A store takes a part.
    Store,
    /// A store gives a part.
    Retrieve,
    /// A robot brings a part from one place to another.
    PickAndPlace,
    /// A part comes into the cell.
    In,
    /// A part leaves the cell.
    Out,
}

/// Role of an action for the part that an activity moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The part is there before.
    Source,
    /// The part is there afterwards.
    Target,
    /// It brings the part over.
    Carrier,
    /// The part stays, and is another afterwards.
    Worker,
}

impl Prototype {
    /// All prototypes, with their words in descriptions.
    pub const ALL: [Prototype; 7] = [
        Prototype::Machine,
        Prototype::Human,
        Prototype::RandomAccessStore,
        Prototype::FifoBuffer,
        Prototype::LifoBuffer,
        Prototype::Robot,
        Prototype::Conveyor,
    ];

    /// Name in a description.
    pub const fn name(self) -> &'static str {
        match self {
            Prototype::Machine => "machine",
            Prototype::Human => "human",
            Prototype::RandomAccessStore => "random-access-store",
            Prototype::FifoBuffer => "fifo-buffer",
            Prototype::LifoBuffer => "lifo-buffer",
            Prototype::Robot => "robot",
            Prototype::Conveyor => "conveyor",
        }
    }

    /// Actions.
    pub const fn actions(self) -> &'static [ResourceAction] {
        match self {
            Prototype::Machine => &[ResourceAction::Load, ResourceAction::Process, ResourceAction::Unload],
            Prototype::Human => {
                &[ResourceAction::Load, ResourceAction::Process, ResourceAction::Unload, ResourceAction::PickAndPlace]
            }
            Prototype::RandomAccessStore | Prototype::FifoBuffer | Prototype::LifoBuffer => {
                &[ResourceAction::Store, ResourceAction::Retrieve]
            }
            Prototype::Robot | Prototype::Conveyor => &[ResourceAction::PickAndPlace],
        }
    }

    /// Default capacity; none where it must be given, or has no meaning.
    pub const fn usual_capacity(self) -> Option<u32> {
        match self {
            Prototype::Machine | Prototype::Human | Prototype::Robot => Some(1),
            Prototype::RandomAccessStore | Prototype::FifoBuffer | Prototype::LifoBuffer | Prototype::Conveyor => None,
        }
    }

    /// The most that an instance may hold; none where there is no capacity to give.
    pub const fn capacity_max(self) -> Option<u32> {
        match self {
            Prototype::Machine | Prototype::Human | Prototype::RandomAccessStore | Prototype::Conveyor => Some(10_000),
            // Each position is a place of its own, or a tone.
            Prototype::FifoBuffer | Prototype::LifoBuffer => Some(100),
            Prototype::Robot => None,
        }
    }

    /// Whether it works on parts.
    pub fn processes(self) -> bool {
        self.actions().contains(&ResourceAction::Process)
    }

    /// Whether a part has a position in it that orders can name; of a `fifo-buffer` only the ends are reached.
    pub fn has_positions(self) -> bool {
        matches!(self, Prototype::RandomAccessStore | Prototype::LifoBuffer)
    }

    /// Whether parts stay in it between activities without being worked on.
    pub fn stores(self) -> bool {
        self.actions().contains(&ResourceAction::Store)
    }
}

impl ResourceAction {
    /// Name in a description.
    pub const fn name(self) -> &'static str {
        match self {
            ResourceAction::Load => "load",
            ResourceAction::Process => "process",
            ResourceAction::Unload => "unload",
            ResourceAction::Store => "store",
            ResourceAction::Retrieve => "retrieve",
            ResourceAction::PickAndPlace => "pick-and-place",
            ResourceAction::In => "in",
            ResourceAction::Out => "out",
        }
    }

    /// Its role for the part that moves.
    pub const fn role(self) -> Role {
        match self {
            ResourceAction::Unload | ResourceAction::Retrieve | ResourceAction::In => Role::Source,
            ResourceAction::Load | ResourceAction::Store | ResourceAction::Out => Role::Target,
            ResourceAction::PickAndPlace => Role::Carrier,
            ResourceAction::Process => Role::Worker,
        }
    }
}
