//! Commands: the coordinator's order and the station's own panel, with their leases.
//!
//! Buttons are hold-to-run. A level counts only while it is refreshed, and only after it has been seen *off* in the
//! mode in force: a button that was already down when the mode changed, or when its sender came back, moves nothing
//! until it is released and pressed again.

use std::time::Duration;

use linewright_line::Tick;
use linewright_line::net::ControlMode;

use crate::ignored::Ignored;
use crate::program::bit;

/// The coordinator's order of the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModeOrder {
    /// Boot id of the coordinator that gives it.
    pub boot_id: u64,
    /// Grows with every change of mode; an older one is refused.
    pub epoch: u64,
    pub mode: ControlMode,
    /// Every station has acknowledged the epoch: a mode that enables motion may be acted on.
    pub enabled: bool,
    /// Master stop: halt at the home place at the end of this round. A round is counted each time the station comes
    /// home. Halting at home at once would leave others waiting, away from home, for an operation that never comes.
    pub master_stop: Option<i32>,
    /// Every station's panel counts as switched to manual.
    pub manual_all: bool,
    /// Hand-mode buttons held, a bit each.
    pub buttons: u32,
    /// *Resume* is held at a console: what was stopped before its end goes on (see `resume`).
    pub resume: bool,
    /// The order holds for this long after its arrival.
    pub lease: Duration,
    /// The generation that is founded, never 0: a station at home counts anew. Only an order that names the station's present life
    /// reaches it.
    pub found: Option<u64>,
    /// Boot id of the station it is for, as the coordinator has received it last; 0 for none. A shell follows no order that was
    /// decided without it.
    pub station_life: u64,
    /// The mode is this station's alone: the others are in auto while a person leads it. Its place is not confirmed meanwhile,
    /// since the others rely on where it stands by its report.
    pub single: bool,
}

impl ModeOrder {
    /// A lease that no exploration and no simulation outlives.
    pub const FOR_GOOD: Duration = Duration::from_secs(365 * 24 * 3600);

    /// An enabled order of this mode, with nothing else in it.
    pub fn of(boot_id: u64, epoch: u64, mode: ControlMode, lease: Duration) -> Self {
        ModeOrder {
            boot_id,
            epoch,
            mode,
            enabled: true,
            master_stop: None,
            manual_all: false,
            buttons: 0,
            resume: false,
            lease,
            found: None,
            station_life: 0,
            single: false,
        }
    }
}

/// Two coordinators give orders: none is in force, except an emergency stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RivalCoordinators {
    /// Boot ids of the one that is followed and of the other one.
    pub lives: (u64, u64),
    /// Until then, if the other one is not received again.
    pub until: Tick,
}

/// A command of the station's panel that came by message instead of by wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelCommand {
    /// Advance held or released. Held must be refreshed.
    Advance(bool),
    /// Return held or released. Held must be refreshed.
    Retract(bool),
    /// The selector: true is station-manual. Stays as it was set.
    Selector(bool),
}

/// A button held by message: it counts while it is refreshed.
///
/// A refresh that comes late finds the motion stopped. It must not start it again, however long the silence was: the finger
/// may never have left the button. Only a release that was received makes the next message a new press.
#[derive(Clone, Copy, Debug, Default)]
struct HeldButton {
    until: Tick,
    /// Ran out while it was held, and no release received since.
    unreleased: bool,
}

impl HeldButton {
    fn hear(&mut self, now: Tick, held: bool, term: Duration) {
        let ran_out = self.until != Tick::ZERO && now >= self.until;
        self.unreleased = held && (self.unreleased || ran_out);
        self.until = if held { now + term } else { Tick::ZERO };
    }

    fn is_held(&self, now: Tick) -> bool {
        now < self.until && !self.unreleased
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct EmergencyStopInForce {
    /// Life and epoch in which the coordinator that is followed has ordered it. Only a later epoch of that life ends it:
    /// another coordinator may not have received it.
    ordered: Option<(u64, u64)>,
    /// Last received from these lives of coordinators that were not followed; it counts as still given until then, or until
    /// such a life is the one that is followed: then its orders since count.
    others: [(u64, Tick); OTHERS_MAX],
}

/// Coordinators kept apart beside the one that is followed; of more the latest are.
const OTHERS_MAX: usize = 3;

impl EmergencyStopInForce {
    fn is_given_by_another(&self, followed: u64, now: Tick) -> bool {
        self.others.iter().any(|&(life, until)| now < until && life != followed)
    }

    fn hear_another(&mut self, life: u64, until: Tick) {
        let known = self.others.iter().position(|&(known, _)| known == life);
        let oldest = (0..OTHERS_MAX).min_by_key(|&at| self.others[at].1).unwrap_or(0);
        self.others[known.unwrap_or(oldest)] = (life, until);
    }
}

/// The commands in force.
#[derive(Clone, Debug)]
pub(crate) struct Commands {
    order: Option<ModeOrder>,
    order_until: Tick,
    contest: Option<RivalCoordinators>,
    stop: Option<EmergencyStopInForce>,
    advance: HeldButton,
    retract: HeldButton,
    /// Held at a console; by order.
    resume: HeldButton,
    /// Until then `blocked_by` names two consoles at the panel.
    two_consoles: Tick,
    selector: bool,
    /// From the station's own inputs: manual, advance, return.
    wired: (bool, bool, bool),
    /// Levels that have been seen off in the mode in force.
    armed: u128,
    mode: ControlMode,
    panel_is_live: bool,
}

impl Commands {
    pub(crate) fn new() -> Self {
        Commands {
            order: None,
            order_until: Tick::ZERO,
            contest: None,
            stop: None,
            advance: HeldButton::default(),
            retract: HeldButton::default(),
            resume: HeldButton::default(),
            two_consoles: Tick::ZERO,
            selector: false,
            wired: (false, false, false),
            armed: 0,
            mode: ControlMode::StandBy,
            panel_is_live: false,
        }
    }

    /// Takes an order unless it is older than the one in force. A new coordinator's epochs start above all it received,
    /// so the epoch alone decides. An emergency stop is obeyed in any epoch; one that is not followed lasts for `term`.
    pub(crate) fn order(&mut self, now: Tick, order: ModeOrder, term: Duration) -> Result<(), Ignored> {
        let is_stop = order.mode == ControlMode::EStop;
        if self.order.is_some_and(|current| order.epoch < current.epoch) {
            if !is_stop {
                return Err(Ignored::OlderEpoch);
            }
            self.stop(now, (order.boot_id, None), term);
            return Ok(());
        }
        // A button that another coordinator holds down was not pressed now.
        if self.order.is_some_and(|current| order.boot_id != current.boot_id) {
            self.disarm(bit::HELD | bit::RESUME);
        }
        let given = (order.boot_id, order.epoch);
        if is_stop {
            self.stop.get_or_insert_default().ordered = Some(given);
        } else if self.stop.is_some_and(|stop| {
            let is_ended = stop.ordered.is_some_and(|(life, epoch)| life == given.0 && epoch < given.1);
            is_ended && !stop.is_given_by_another(order.boot_id, now)
        }) {
            self.stop = None;
        }
        self.order = Some(order);
        self.order_until = now + order.lease;
        // No longer than any other button that is held by message, however long the lease.
        self.resume.hear(now, order.resume, term);
        Ok(())
    }

    /// An emergency stop that is no newer order, of this life of a coordinator. With an epoch, and while no order was followed yet, a
    /// later one of that life ends it.
    pub(crate) fn stop(&mut self, now: Tick, (life, epoch): (u64, Option<u64>), term: Duration) {
        let stop = self.stop.get_or_insert_default();
        if self.order.is_none() && stop.ordered.is_none() {
            stop.ordered = epoch.map(|epoch| (life, epoch));
        }
        if self.order.is_none_or(|order| order.boot_id != life) {
            stop.hear_another(life, now + term);
        }
    }

    /// The order in force counts as not renewed. An emergency stop does not end by this.
    pub(crate) fn end_lease(&mut self, now: Tick) {
        self.order_until = self.order_until.min(now);
    }

    pub(crate) fn contest(&mut self, contest: Option<RivalCoordinators>) {
        self.contest = contest;
    }

    /// The two coordinators that give orders, if there are two.
    pub(crate) fn contested(&self, now: Tick) -> Option<(u64, u64)> {
        self.contest.filter(|contest| now < contest.until).map(|contest| contest.lives)
    }

    /// Whether the order in force holds: its lease runs, and no other coordinator gives orders.
    fn is_live(&self, now: Tick) -> bool {
        now < self.order_until && self.contested(now).is_none()
    }

    pub(crate) fn followed(&self) -> u64 {
        self.order.map_or(0, |order| order.boot_id)
    }

    pub(crate) fn epoch(&self) -> u64 {
        self.order.map_or(0, |order| order.epoch)
    }

    /// A held level lasts until `now + stale`.
    pub(crate) fn panel(&mut self, now: Tick, command: PanelCommand, stale: Duration) {
        match command {
            PanelCommand::Advance(held) => self.advance.hear(now, held, stale),
            PanelCommand::Retract(held) => self.retract.hear(now, held, stale),
            PanelCommand::Selector(manual) => self.selector = manual,
        }
    }

    pub(crate) fn hear_two_consoles(&mut self, until: Tick) {
        self.two_consoles = until;
    }

    /// Whether two consoles send a button of the panel.
    pub(crate) fn has_two_consoles(&self, now: Tick) -> bool {
        now < self.two_consoles
    }

    pub(crate) fn wired(&mut self, manual: bool, advance: bool, retract: bool) {
        self.wired = (manual, advance, retract);
    }

    pub(crate) fn selector_manual(&self) -> bool {
        self.selector || self.wired.0
    }

    /// These buttons must be seen off again before they count.
    pub(crate) fn disarm(&mut self, levels: u128) {
        self.armed &= !levels;
    }

    pub(crate) fn panel_is_live(&self) -> bool {
        self.panel_is_live
    }

    pub(crate) fn mode(&self) -> ControlMode {
        self.mode
    }

    /// Whether the mode ordered is this station's alone.
    pub(crate) fn is_single(&self) -> bool {
        self.order.is_some_and(|order| order.single)
    }

    /// Whether master stop has been given, whatever the round.
    pub(crate) fn is_stopping(&self) -> bool {
        self.order.is_some_and(|order| order.master_stop.is_some())
    }

    /// Whether a lease is running, and the mode it grants.
    pub(crate) fn granted(&self, now: Tick) -> ControlMode {
        if self.stop.is_some() {
            // It outlives its lease: it ends by order only.
            return ControlMode::EStop;
        }
        match self.order {
            Some(order) if self.is_live(now) => {
                if order.mode.enables_motion() && !order.enabled {
                    ControlMode::StandBy
                } else {
                    order.mode
                }
            }
            // The lease has run out, no coordinator was ever received, or two are: finish what runs, start nothing.
            Some(_) | None => ControlMode::StandBy,
        }
    }

    /// Whether master stop holds a station that has come home `round` times.
    pub(crate) fn stops_at(&self, round: i32) -> bool {
        self.order.and_then(|order| order.master_stop).is_some_and(|stop| round >= stop)
    }

    /// Brings mode and levels up to `now`; returns the bits of command levels.
    pub(crate) fn refresh(&mut self, now: Tick) -> u128 {
        let mode = self.granted(now);
        let live = self.is_live(now);
        let panel_is_live =
            mode == ControlMode::Manual && (self.selector_manual() || self.order.is_some_and(|o| o.manual_all));
        // Nothing new starts in a mode that enables no motion, so what was armed may stay: a motion of hand mode that
        // is to finish in stand-by goes on while its button is held.
        if (mode != self.mode && mode.enables_motion()) || panel_is_live != self.panel_is_live || !live {
            self.armed = 0;
        }
        self.mode = mode;
        self.panel_is_live = panel_is_live;

        let mut raw = 0;
        if let Some(order) = self.order.filter(|_| live) {
            raw |= u128::from(order.buttons) << bit::HELD_0;
        }
        let advance = self.wired.1 || self.advance.is_held(now);
        let retract = self.wired.2 || self.retract.is_held(now);
        raw |= if advance { bit::ADVANCE } else { 0 } | if retract { bit::RETRACT } else { 0 };
        raw |= if live && self.resume.is_held(now) { bit::RESUME } else { 0 };
        if live {
            self.armed |= !raw;
        }
        // Held together the two mean neither, and the release of one is no command to the other.
        if advance && retract {
            self.disarm(bit::PANEL);
        }
        // The panel comes first: where its selector stands at manual or its button is down, the console has to let go of resume.
        if advance || retract || self.selector_manual() {
            self.disarm(bit::RESUME);
        }
        let in_force = if panel_is_live { bit::PANEL | bit::HELD | bit::RESUME } else { bit::HELD };
        raw & self.armed & in_force
    }

    /// See [`crate::Controller::situation`].
    pub(crate) fn situation(&self, now: Tick, out: &mut Vec<i64>) {
        let live = self.is_live(now);
        let order = self.order.map(|o| (o.mode as i64, o.enabled, o.manual_all, o.buttons, o.master_stop));
        let (mode, enabled, manual_all, buttons, stop) = order.unwrap_or((-1, false, false, 0, None));
        let resume = i64::from(self.resume.is_held(now)) << 32;
        out.extend([mode, i64::from(buttons) | resume, stop.map_or(i64::MIN, i64::from)]);
        let by_another = |stop: &EmergencyStopInForce| stop.is_given_by_another(self.followed(), now);
        let stop = self.stop.map(|stop| (stop.ordered.is_some(), by_another(&stop)));
        out.push(stop.map_or(-1, |(ordered, other)| i64::from(ordered) * 2 + i64::from(other)));
        out.extend([live, enabled, manual_all, self.panel_is_live, self.selector_manual()].map(i64::from));
        let levels = [self.wired.1, self.wired.2, self.advance.is_held(now), self.retract.is_held(now)];
        out.extend(levels.map(i64::from));
        out.extend([self.armed & (bit::PANEL | bit::HELD | bit::RESUME)].map(|bits| bits as i64));
    }

    /// Time of the next expiry in here, if nothing is received until then.
    pub(crate) fn deadline(&self, now: Tick) -> Tick {
        let contest = self.contest.map_or(Tick::ZERO, |contest| contest.until);
        [self.order_until, contest, self.advance.until, self.retract.until, self.resume.until]
            .into_iter()
            .filter(|&t| t > now)
            .min()
            .unwrap_or(Tick::NEVER)
    }
}
