//! What may happen next, and what it is called.

use linewright_line::net::{Block, ControlMode};
use linewright_line::{OpId, StationId};
use linewright_station_logic::StationHappening;

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
    Forget(u8),
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
        if setting.forgets && world.astray.is_none() {
            out.push(Action::Forget(station));
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

/// Lets it happen; gives what the station concerned says about it.
pub fn apply(setting: &Setting, world: &mut World, action: Action) -> (usize, Vec<StationHappening>) {
    let mut events = Vec::new();
    let station = match action {
        Action::Mode(s, mode) => {
            world.set_mode(setting, s.into(), mode, &mut events);
            s.into()
        }
        Action::Key(s, key) => {
            world.set_key(setting, s.into(), key, &mut events);
            s.into()
        }
        Action::Button(s, button) => {
            world.set_button(setting, s.into(), button, &mut events);
            s.into()
        }
        Action::Arrive(s, op, block) => {
            let (complete, _) = bits_of(&setting.line, StationId(s.into()), op, block == Block::Recovery);
            world.pulse(setting, s.into(), Some(complete), &mut events);
            s.into()
        }
        Action::Fail(s, op, block) => {
            let (_, fault) = bits_of(&setting.line, StationId(s.into()), op, block == Block::Recovery);
            world.pulse(setting, s.into(), fault, &mut events);
            s.into()
        }
        Action::Deliver { link, nth } => {
            world.deliver(setting, link.into(), nth.into(), &mut events);
            setting.ends_of(link.into()).1
        }
        Action::Step(s) => {
            world.step(setting, s.into(), &mut events);
            s.into()
        }
        Action::Restart(s) => {
            world.restart(setting, s.into(), &mut events);
            s.into()
        }
        Action::Forget(s) => {
            world.forget(setting, s.into(), &mut events);
            s.into()
        }
    };
    world.settle_astray();
    (station, events)
}

/// The action in words.
pub fn text(setting: &Setting, action: Action) -> String {
    let name = |station: u8| setting.line.stations[usize::from(station)].name.as_str();
    let motion = |station: u8, op: OpId, block: Block| {
        let operation = &setting.line.operation((StationId(station.into()), op)).name;
        if block == Block::Recovery { format!("undoing {operation}") } else { operation.clone() }
    };
    match action {
        Action::Mode(s, mode) => format!("{} hears of {mode}", name(s)),
        Action::Key(s, Some(Key::Advance)) => format!("someone holds advance at {}", name(s)),
        Action::Key(s, Some(Key::Return)) => format!("someone holds return at {}", name(s)),
        Action::Key(s, None) => format!("they let go at {}", name(s)),
        Action::Button(s, Some(b)) => format!("{} hears {} held", name(s), setting.line.buttons[usize::from(b)]),
        Action::Button(s, None) => format!("{} hears the button released", name(s)),
        Action::Arrive(s, op, block) => format!("{}: {} arrives", name(s), motion(s, op, block)),
        Action::Fail(s, op, block) => format!("{}: {} fails", name(s), motion(s, op, block)),
        Action::Deliver { link, .. } => {
            let (writer, reader) = setting.ends_of(link.into());
            format!("{} hears {}", name(reader as u8), name(writer as u8))
        }
        Action::Step(s) => format!("{} takes a step", name(s)),
        Action::Restart(s) => format!("{} restarts", name(s)),
        Action::Forget(s) => format!("{} loses its memory and comes up without it", name(s)),
    }
}
