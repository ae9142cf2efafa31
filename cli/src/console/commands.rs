//! What is done at a page as messages: the same as those of `mode` and `press`.

use std::time::Duration;

use linewright_console_server::{PageEvent, PageEventKind};
use linewright_console_view::{
    ControlDesk, ControlPart, DeskEffect, HoldButton, HoldMessage, OperateStates, PUBLISH_EVERY, PageAct, why_not,
};
use linewright_fieldbus::Clock;
use linewright_line::Tick;
use linewright_msgs::{Flag, Text};
use linewright_node_shell::Publisher;
use linewright_recovery::PanelButton;

use crate::client::OperatorClient;
use crate::operate::HeldMotions;
use crate::states::mode_name;

/// The desk, and the publishers of what is given at it.
pub struct PageCommands {
    desk: ControlDesk,
    resume: Publisher<Flag>,
    /// Of each station advance, return and the selector.
    panels: Vec<(Publisher<Flag>, Publisher<Flag>, Publisher<Text>)>,
    /// What the button of a panel that is held leads, with the number of its press.
    led: Option<(u64, HeldMotions)>,
}

/// Time in which the releases at the end of the console are sent.
const LAST_RELEASES: Duration = Duration::from_millis(200);

impl PageCommands {
    /// Opens the publishers.
    pub fn open(client: &mut OperatorClient) -> miette::Result<Self> {
        let desk = ControlDesk::new(client.line());
        let ids: Vec<_> = client.line().station_ids().collect();
        let mut panel = |id| {
            let buttons = (client.panel_button(id, "advance")?, client.panel_button(id, "return")?);
            Ok((buttons.0, buttons.1, client.panel_selector(id)?))
        };
        let panels = ids.into_iter().map(&mut panel).collect::<miette::Result<_>>()?;
        Ok(PageCommands { desk, resume: client.resume()?, panels, led: None })
    }

    /// Takes what has come from a page.
    pub fn take(&mut self, now: Duration, client: &OperatorClient, event: PageEvent) {
        let effects = match event.what {
            PageEventKind::Opened(address) => {
                self.desk.opened(event.connection, &address);
                Vec::new()
            }
            PageEventKind::Closed => self.desk.closed(now, event.connection),
            PageEventKind::Operated(operation) => {
                self.desk.take(now, event.connection, &operation, |act| refusal(client, act))
            }
        };
        self.perform(client, effects);
    }

    /// Ends what is held, and publishes its releases: a console that is ended in order leaves nothing to time limits.
    pub async fn close(&mut self, clock: &Clock, client: &OperatorClient) {
        let now = || clock.now().since(Tick::ZERO);
        let effects = self.desk.close(now());
        self.perform(client, effects);
        let end = now() + LAST_RELEASES;
        while now() < end {
            self.publish(now(), client);
            tokio::time::sleep(PUBLISH_EVERY).await;
        }
    }

    /// Ends the press of a panel's button whose motion has arrived: held on, it would begin the next operation.
    fn look_for_arrival(&mut self, now: Duration, client: &OperatorClient) {
        let Some((number, HoldButton::Panel(id, _))) = self.desk.live() else {
            self.led = None;
            return;
        };
        let state = client.station(id);
        let of_press = self.led.take().filter(|(of, _)| *of == number);
        let (_, motions) = self.led.insert(of_press.unwrap_or_else(|| (number, HeldMotions::before(state))));
        motions.look(state);
        if state.is_some_and(|state| motions.has_arrived(state)) {
            let effects = self.desk.arrived(now);
            self.perform(client, effects);
        }
    }

    /// Publishes what is held now, and releases.
    pub fn publish(&mut self, now: Duration, client: &OperatorClient) {
        self.look_for_arrival(now, client);
        let (messages, effects) = self.desk.due(now, |act| refusal(client, act));
        self.perform(client, effects);
        for HoldMessage { button, is_held } in messages {
            match button {
                HoldButton::Hand(_) if is_held => client.hold(&button.name(client.line())),
                HoldButton::Hand(_) => client.hold(""),
                HoldButton::Resume => self.resume.send(Flag { data: is_held }),
                HoldButton::Panel(id, side) => {
                    let (advance, back, _) = &self.panels[id.index()];
                    let of_side = if side == PanelButton::Advance { advance } else { back };
                    of_side.send(Flag { data: is_held });
                }
            }
        }
    }

    /// Control as it is now.
    pub fn part(&self, now: Duration) -> ControlPart {
        self.desk.part(now)
    }

    fn perform(&self, client: &OperatorClient, effects: Vec<DeskEffect>) {
        for effect in effects {
            match effect {
                DeskEffect::Command(words) => client.command(&words),
                DeskEffect::Select(id, manual) => {
                    self.panels[id.index()].2.send(Text::from(if manual { "manual" } else { "auto" }));
                }
                DeskEffect::Log(text) => tracing::info!("console: {text}"),
            }
        }
    }
}

/// Why an act would do nothing now.
fn refusal(client: &OperatorClient, act: &PageAct) -> Option<String> {
    let states = OperateStates {
        coordinator: client.coordinator(),
        stations: client.line().station_ids().map(|id| client.station(id)).collect(),
        is_other_description: !client.other_descriptions().is_empty(),
    };
    why_not(client.line(), &states, act, mode_name)
}
