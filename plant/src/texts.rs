//! The texts and words of the plant for operators. All of them are here; `tests/texts.rs` keeps a list of them.

use linewright_line::{Grip, HolderId, Line};

use crate::by_hand::{PartByHand, PartRefusal};
use crate::fault::{InputFault, MotionFault};
use crate::parts::{FallCause, NestPosition, PartFault};
use crate::plant::Plant;

/// The word for the end of a fault, in scenarios and in `linewright fail`.
pub const CLEAR_WORD: &str = "clear";

impl InputFault {
    /// The word for it, in scenarios and in `linewright fail`.
    pub const fn name(self) -> &'static str {
        match self {
            InputFault::StuckOn => "stuck-on",
            InputFault::StuckOff => "stuck-off",
        }
    }

    /// Effect of the fault, in words.
    pub const fn about(self) -> &'static str {
        match self {
            InputFault::StuckOn => "The input stays on, whatever the machine does.",
            InputFault::StuckOff => "The input stays off, whatever the machine does.",
        }
    }
}

impl MotionFault {
    /// The word for it, in scenarios and in `linewright fail`.
    pub const fn name(self) -> &'static str {
        match self {
            MotionFault::Stick => "stick",
            MotionFault::Slip => "slip",
            MotionFault::Break => "break",
            MotionFault::SlipBack => "slip-back",
            MotionFault::Miss => "miss",
            MotionFault::Drop => "drop",
        }
    }

    /// Effect of the fault on a drive; none where a drive has no such fault.
    pub const fn about_drive(self) -> Option<&'static str> {
        match self {
            MotionFault::Stick => {
                Some("It holds the axis where it is, and fails by its following error once it is ordered to move.")
            }
            MotionFault::Break => Some(
                "Its encoder is broken: it fails at once, at rest as well, and stays so until `clear`; a reset does not end it.",
            ),
            MotionFault::Slip | MotionFault::SlipBack | MotionFault::Miss | MotionFault::Drop => None,
        }
    }

    /// Effect of the fault, in words.
    pub const fn about(self) -> &'static [&'static str] {
        match self {
            MotionFault::Stick => &["The mechanism does not move."],
            MotionFault::Slip => &["It moves at a quarter of its speed."],
            MotionFault::Break => &["It does not move, and its fault signal comes on."],
            MotionFault::SlipBack => &["It moves the wrong way."],
            MotionFault::Miss => &["It moves, but the gripper that it closes takes nothing."],
            MotionFault::Drop => &["It moves, but the gripper that it has closed holds nothing fast."],
        }
    }
}

impl PartByHand {
    /// The word for it, in scenarios and for `linewright part`.
    pub const fn name(self) -> &'static str {
        match self {
            PartByHand::Take => "take",
            PartByHand::Put => "put",
        }
    }

    /// What is done, in words.
    pub const fn about(self) -> &'static str {
        match self {
            PartByHand::Take => "The part there is taken out.",
            PartByHand::Put => "A part is put in there.",
        }
    }

    /// That it has been done at a place.
    pub fn done(self, line: &Line, at: NestPosition) -> String {
        let place = spot_name(line, at);
        match self {
            PartByHand::Take => format!("{place}: the part is taken out"),
            PartByHand::Put => format!("{place}: a part is put in"),
        }
    }
}

impl PartRefusal {
    /// Why it cannot be done at a place, and what would make it possible.
    pub fn text(self, line: &Line, at: NestPosition) -> String {
        let (place, holder) = (spot_name(line, at), line.handling.holder(at.nest));
        match self {
            PartRefusal::NoSuchSpot if holder.is_hand() => {
                format!("nothing is put into gripper {place}: put the part where it grips it")
            }
            PartRefusal::NoSuchSpot => {
                format!("`{}` has no position {}: it has {}", holder.name, at.position, places(holder.places))
            }
            PartRefusal::Occupied => format!("{place} has a part already"),
            PartRefusal::Held => match holder.grip {
                Grip::Clamp(_) => format!("{place} is closed: open it first, in manual at its panel or in hand mode"),
                Grip::Hand(_) | Grip::Loose => {
                    format!("a gripper or a closed clamp holds the part of {place}: open that first")
                }
            },
            PartRefusal::Known => "the part is there already".to_owned(),
            PartRefusal::Unknown => "there is no such part".to_owned(),
            PartRefusal::Empty => format!("{place} has no part"),
        }
    }
}

fn places(count: u16) -> String {
    if count == 1 { "one place".to_owned() } else { format!("positions 1 to {count}") }
}

impl PartFault {
    /// The mishap, with where it was. Parts have no numbers here: those of the plant are not the coordinator's.
    pub fn text(&self, line: &Line, plant: &Plant) -> String {
        let name = |holder: HolderId| format!("`{}`", line.handling.holder(holder).name);
        let gripper = |hand: HolderId| format!("gripper {}", name(hand));
        match *self {
            PartFault::Fell { hand, cause, .. } => {
                let hand_name = gripper(hand);
                let why = match cause {
                    FallCause::OverNothing => {
                        format!("{hand_name} opened over no place for parts{}", axes(line, plant, hand))
                    }
                    FallCause::NoPosition { nest, number } => format!(
                        "{hand_name} opened over {}, and the outputs with the position give {number}; positions are 1 to {}",
                        name(nest),
                        line.handling.holder(nest).places
                    ),
                    FallCause::Taken(spot) => {
                        format!("{hand_name} opened over {}, where another part lies", spot_name(line, spot))
                    }
                    FallCause::Shut(spot) => {
                        format!("{hand_name} opened over {}, which is closed", spot_name(line, spot))
                    }
                    FallCause::NotHeld => {
                        format!("{hand_name} did not hold it fast{}", axes(line, plant, hand))
                    }
                };
                format!("a part has fallen down and is gone: {why}")
            }
            PartFault::Torn { hand, .. } => {
                format!("{} has left without its part, which a closed clamp holds", gripper(hand))
            }
            PartFault::Blocked { hand, spot, .. } => {
                format!(
                    "{} has brought a part to {}, which is closed or has another part",
                    gripper(hand),
                    spot_name(line, spot)
                )
            }
        }
    }
}

/// A nest, with the position where it has several.
fn spot_name(line: &Line, spot: NestPosition) -> String {
    let nest = line.handling.holder(spot.nest);
    if nest.places > 1 { format!("position {} of `{}`", spot.position, nest.name) } else { format!("`{}`", nest.name) }
}

/// Where the axes stand that carry a hand; empty where there are none.
fn axes(line: &Line, plant: &Plant, hand: HolderId) -> String {
    let Grip::Hand(grip) = line.handling.holder(hand).grip else { return String::new() };
    let mut carrying: Vec<_> =
        line.handling.reaches.iter().filter(|reach| reach.hand == hand).flat_map(|reach| &reach.when).collect();
    carrying.retain(|stand| (stand.station, stand.axis) != (grip.station, grip.axis));
    let mut at: Vec<String> = carrying
        .iter()
        .map(|stand| {
            let name = &line.station(stand.station).axes[stand.axis.index()].name;
            format!("{name} at {:.1}", plant.position(stand.station, stand.axis))
        })
        .collect();
    at.sort();
    at.dedup();
    if at.is_empty() { String::new() } else { format!(" ({})", at.join(", ")) }
}
