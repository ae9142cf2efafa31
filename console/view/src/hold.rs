//! Buttons that act while they are held, and what is published of one.
//!
//! A press has a number that is used once. It is held while beats of this number come within [`BEAT_WITHIN`] of each other, each from a
//! page that shows what is at most [`SEEN_WITHIN`] old; whatever ends it, its number is dead. What is published begins with *released*,
//! so that controllers take it for a new press, and ends with *released*, several times, since one message may get lost.
//!
//! It is no barrier by itself: controllers count a held button as released when no message has come for `stale_ms`, and count it again only
//! after a release that they have received.

use std::time::Duration;

use linewright_line::{ButtonId, Line, StationId};
use linewright_recovery::PanelButton;

use crate::message::PageAct;

/// Longest time between two beats of a press.
pub const BEAT_WITHIN: Duration = Duration::from_millis(250);

/// Longest time for which a press is held. A pointer whose release never reaches the browser, as that of a remote desktop that was cut off,
/// goes on for ever otherwise.
pub const HELD_AT_MOST: Duration = Duration::from_secs(60);

/// Greatest age of what a page shows while something is commanded or held at it.
pub const SEEN_WITHIN: Duration = Duration::from_millis(500);

/// Period at which a held button is published.
pub const PUBLISH_EVERY: Duration = Duration::from_millis(50);

/// *Released* before a press, and after it.
const RELEASES_BEFORE: u8 = 2;
const RELEASES_AFTER: u8 = 3;

/// Resume, where no hand-mode button has that name.
pub const RESUME: &str = "resume";

/// A button that acts while it is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldButton {
    /// A hand-mode button of the console.
    Hand(ButtonId),
    /// What was stopped before its end goes on at every station.
    Resume,
    /// A button of a station's panel.
    Panel(StationId, PanelButton),
}

/// What is to be published of a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HoldMessage {
    pub button: HoldButton,
    pub is_held: bool,
}

/// Why a press has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HoldEnd {
    /// Let go.
    Released,
    /// No beat for so long.
    NoBeat(Duration),
    /// Held for [`HELD_AT_MOST`].
    TooLong,
    /// What it leads has arrived: held on, it would begin what comes next.
    Arrived,
    /// The page showed what was so old.
    Behind(Duration),
    /// Something else was done at the page meanwhile.
    Another,
    /// Control was lost, or the connection.
    NoControl,
    /// The button does not act any more; why.
    NotAllowed(String),
}

/// The one press that is held now, and the releases that are still to be published.
#[derive(Debug, Default)]
pub struct HoldMachine {
    live: Option<LivePress>,
    releases: Vec<(HoldButton, u8)>,
    next_at: Duration,
}

#[derive(Clone, Copy, Debug)]
struct LivePress {
    number: u64,
    button: HoldButton,
    /// *Released* that is still to be published before it.
    before: u8,
    begun_at: Duration,
    beat_at: Duration,
}

impl HoldButton {
    /// The button of this name, of a station's panel where one is named.
    pub fn named(line: &Line, station: Option<&str>, button: &str) -> Option<Self> {
        if let Some(station) = station {
            let side = [PanelButton::Advance, PanelButton::Return].into_iter().find(|side| side.name() == button)?;
            return line.station_named(station).map(|id| HoldButton::Panel(id, side));
        }
        let at = line.buttons.iter().position(|name| name == button);
        match at.and_then(|at| u16::try_from(at).ok()) {
            Some(at) => Some(HoldButton::Hand(ButtonId(at))),
            None => (button == RESUME).then_some(HoldButton::Resume),
        }
    }

    /// Its name, with that of its station.
    pub fn name(self, line: &Line) -> String {
        match self {
            HoldButton::Hand(id) => line.buttons.get(usize::from(id.0)).cloned().unwrap_or_default(),
            HoldButton::Resume => RESUME.to_owned(),
            HoldButton::Panel(id, side) => format!("{} of {}", side.name(), line.station(id).name),
        }
    }

    /// What a page does to press it. Number 0: the page puts its own in.
    pub(crate) fn act(self, line: &Line) -> PageAct {
        let (station, button) = match self {
            HoldButton::Hand(_) | HoldButton::Resume => (None, self.name(line)),
            HoldButton::Panel(id, side) => (Some(line.station(id).name.clone()), side.name().to_owned()),
        };
        PageAct::Press { number: 0, station, button }
    }

    /// Whether both are published as one message: then a release of the one is one of the other.
    fn shares_message(self, other: Self) -> bool {
        self == other || matches!((self, other), (HoldButton::Hand(_), HoldButton::Hand(_)))
    }
}

impl HoldEnd {
    /// Why it has ended, for the operator; none of a button that was let go.
    pub fn text(&self) -> Option<String> {
        Some(match self {
            HoldEnd::Released => return None,
            HoldEnd::NoBeat(silence) => format!(
                "released: nothing came from the page for {} ms; let go, then hold it again",
                silence.as_millis()
            ),
            HoldEnd::Behind(age) => {
                format!("released: the page showed what was {} ms old; let go, then hold it again", age.as_millis())
            }
            HoldEnd::TooLong => {
                format!("released: held for {} s; let go, then hold it again", HELD_AT_MOST.as_secs())
            }
            HoldEnd::Arrived => "released: it is at its end; let go, then hold it again for what comes next".to_owned(),
            HoldEnd::Another => "released: something else was touched meanwhile; let go, then hold it again".to_owned(),
            HoldEnd::NoControl => "released: this page has no control any more".to_owned(),
            HoldEnd::NotAllowed(why) => format!("released: {why}"),
        })
    }
}

impl HoldMachine {
    /// Begins a press. One that is live is ended by the caller before.
    pub fn press(&mut self, now: Duration, number: u64, button: HoldButton) {
        self.end(now);
        self.releases.retain(|(of, _)| !of.shares_message(button));
        self.live = Some(LivePress { number, button, before: RELEASES_BEFORE, begun_at: now, beat_at: now });
    }

    /// A beat of this number. One that comes too late ends its press, and one of another number does nothing.
    pub fn beat(&mut self, now: Duration, number: u64) -> Option<HoldEnd> {
        let end = self.expire(now);
        if let Some(live) = self.live.as_mut().filter(|live| live.number == number) {
            live.beat_at = now;
        }
        end
    }

    /// Ends the press that is live.
    pub fn end(&mut self, now: Duration) {
        let Some(live) = self.live.take() else { return };
        self.releases.retain(|(of, _)| !of.shares_message(live.button));
        self.releases.push((live.button, RELEASES_AFTER));
        // The first of them goes at once.
        self.next_at = now;
    }

    /// Ends the press that is live if no beat of it has come for too long, or if it was held for too long.
    fn expire(&mut self, now: Duration) -> Option<HoldEnd> {
        let live = self.live?;
        let silence = now.saturating_sub(live.beat_at);
        let end = match () {
            () if silence > BEAT_WITHIN => HoldEnd::NoBeat(silence),
            () if now.saturating_sub(live.begun_at) > HELD_AT_MOST => HoldEnd::TooLong,
            () => return None,
        };
        self.end(now);
        Some(end)
    }

    /// The press that is live: its number and its button.
    pub fn live(&self) -> Option<(u64, HoldButton)> {
        self.live.map(|live| (live.number, live.button))
    }

    /// What is to be published now, and the end of a press whose beats have not come. Nothing before the period since the last time is over.
    pub fn due(&mut self, now: Duration) -> (Vec<HoldMessage>, Option<HoldEnd>) {
        let end = self.expire(now);
        if now < self.next_at {
            return (Vec::new(), end);
        }
        let mut due: Vec<HoldMessage> =
            self.releases.iter().map(|(button, _)| HoldMessage { button: *button, is_held: false }).collect();
        self.releases.iter_mut().for_each(|(_, left)| *left -= 1);
        self.releases.retain(|(_, left)| *left > 0);
        if let Some(live) = &mut self.live {
            due.push(HoldMessage { button: live.button, is_held: live.before == 0 });
            live.before = live.before.saturating_sub(1);
        }
        if !due.is_empty() {
            self.next_at = now + PUBLISH_EVERY;
        }
        (due, end)
    }
}
