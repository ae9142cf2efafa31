//! Actions possible next in the plain explorer.

use linewright_line::net::{Block, ControlMode};
use linewright_line::{OpId, StationId};

use super::world::{Key, Setting, World, bits_of};

/// One thing that happens. `u8`s are station and link numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Mode(u8, ControlMode),
    Key(u8, Option<Key>),
    Button(u8, Option<u16>),
    Arrive(u8, OpId, Block),
    Fail(u8, OpId, Block),
    Deliver {
        link: u8,
        nth: u8,
    },
    /// A step without anything new, where one may matter: a request is open.
    Step(u8),
    Restart(u8),
}

/// Everything that may happen in this state.
pub fn possible(setting: &Setting, world: &World, out: &mut Vec<Action>) {
    out.clear();
    for link in 0..setting.links() {
        out.extend((0..world.waiting(link)).map(|nth| Action::Deliver { link: link as u8, nth: nth as u8 }));
    }
    for (index, node) in world.nodes.iter().enumerate() {
        let station = index as u8;
        for place in node.controller.marking().filter(|p| p.is_operating()) {
            // A mechanism that is not driven stays where it is.
            let drives = actuator(setting, index, place.op, place.block);
            if node.outputs & drives != 0 {
                out.push(Action::Arrive(station, place.op, place.block));
            }
            out.push(Action::Fail(station, place.op, place.block));
        }
        if node.mode == ControlMode::Manual || !setting.tidy_hands {
            match node.key {
                None => out.extend([Key::Advance, Key::Return].map(|key| Action::Key(station, Some(key)))),
                Some(_) => out.push(Action::Key(station, None)),
            }
        }
        if node.key.is_none() || !setting.tidy_hands {
            let others = setting.modes.iter().filter(|&&mode| mode != node.mode);
            out.extend(others.map(|&mode| Action::Mode(station, mode)));
        }
        if setting.modes.contains(&ControlMode::Hand) && (node.mode == ControlMode::Hand || node.button.is_some()) {
            match node.button {
                Some(_) => out.push(Action::Button(station, None)),
                None => out.extend(buttons_of(setting, index).map(|b| Action::Button(station, Some(b)))),
            }
        }
        if node.controller.writer().open.is_some() {
            out.push(Action::Step(station));
        }
        if setting.restarts {
            out.push(Action::Restart(station));
        }
    }
}

fn actuator(setting: &Setting, station: usize, op: OpId, block: Block) -> u128 {
    let operation = setting.line.operation((StationId::at(station), op));
    let signals = match (&operation.module, block) {
        (linewright_line::OperationModule::Reversible { recovery, .. }, Block::Recovery) => recovery,
        _ => &operation.normal,
    };
    1 << signals.actuator.0
}

fn buttons_of(setting: &Setting, station: usize) -> impl Iterator<Item = u16> {
    let hands = setting.line.stations[station].operations.iter().map(|op| op.hand);
    let mut all: Vec<u16> = hands
        .flat_map(|hand| [Some(hand.forward()), hand.back(), hand.next()])
        .flatten()
        .map(|button| button.0)
        .collect();
    all.sort_unstable();
    all.dedup();
    all.into_iter()
}

/// Lets it happen.
pub fn apply(setting: &Setting, world: &mut World, action: Action) {
    let signals = |s: u8, op, block| bits_of(&setting.line, StationId(s.into()), op, block == Block::Recovery);
    match action {
        Action::Mode(s, mode) => world.set_mode(setting, s.into(), mode),
        Action::Key(s, key) => world.set_key(setting, s.into(), key),
        Action::Button(s, button) => world.set_button(setting, s.into(), button),
        Action::Arrive(s, op, block) => world.pulse(setting, s.into(), Some(signals(s, op, block).0)),
        Action::Fail(s, op, block) => world.pulse(setting, s.into(), signals(s, op, block).1),
        Action::Deliver { link, nth } => world.deliver(setting, link.into(), nth.into()),
        Action::Step(s) => world.step(setting, s.into()),
        Action::Restart(s) => world.restart(setting, s.into()),
    }
}
