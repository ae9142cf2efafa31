//! What is done at a page as messages: the same as those of `mode` and `press`.

use std::time::Duration;

use futures::future::LocalBoxFuture;
use futures::stream::FuturesUnordered;
use futures::{FutureExt, StreamExt};
use linewright_console_server::{PageEvent, PageEventKind};
use linewright_console_view::{
    ConnectionNumber, ConsoleView, ControlDesk, ControlPart, DeskEffect, HoldButton, HoldMessage, OperateStates,
    PUBLISH_EVERY, PageAct, PlanPart, why_not,
};
use linewright_fieldbus::Clock;
use linewright_line::Tick;
use linewright_msgs::{Flag, Text};
use linewright_node_shell::Publisher;
use linewright_recovery::PanelButton;

use crate::cell::{CellClient, CellReply, REPLY_WITHIN};
use crate::client::OperatorClient;
use crate::operate::HeldMotions;
use crate::states::mode_name;

/// A reply that is awaited, with the connection that has asked.
type AwaitedReply = LocalBoxFuture<'static, (ConnectionNumber, CellReply)>;

/// The desk, and the publishers of what is given at it.
pub struct PageCommands {
    desk: ControlDesk,
    awaited: FuturesUnordered<AwaitedReply>,
    resume: Publisher<Flag>,
    /// Of each station advance, return and the selector.
    panels: Vec<(Publisher<Flag>, Publisher<Flag>, Publisher<Text>)>,
    /// What the button of a panel that is held leads, with the number of its press.
    led: Option<(u64, HeldMotions)>,
}

/// What a page's acts are about.
pub struct PageSurroundings<'a> {
    pub client: &'a OperatorClient,
    /// Of a flexible cell.
    pub cell: Option<&'a CellClient>,
    pub view: &'a mut ConsoleView,
}

/// Most replies that are awaited at one time.
const AWAITED_MAX: usize = 64;

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
        Ok(PageCommands { desk, awaited: FuturesUnordered::new(), resume: client.resume()?, panels, led: None })
    }

    /// Takes what has come from a page.
    pub fn take(&mut self, now: Duration, of: &mut PageSurroundings<'_>, event: PageEvent) {
        let effects = match event.what {
            PageEventKind::Opened(address) => {
                self.desk.opened(event.connection, &address);
                Vec::new()
            }
            PageEventKind::Closed => self.desk.closed(now, event.connection),
            PageEventKind::Operated(operation) => {
                let (client, cell) = (of.client, of.cell);
                self.desk.take(now, event.connection, &operation, |act| refusal(client, cell, act))
            }
        };
        for effect in effects {
            match effect {
                DeskEffect::Acknowledge { connection, shown, by, note } => {
                    let log = format!("acknowledged by {by}: {note}");
                    match of.view.acknowledge(now, shown, by, note) {
                        Ok(alarm) => tracing::info!("console: alarm `{alarm}` {log}"),
                        Err(why) => self.desk.not_acknowledged(connection, &why),
                    }
                }
                DeskEffect::Ask { connection, request } => match of.cell {
                    // Pages that have gone leave theirs behind until these are given up.
                    Some(_) if self.awaited.len() >= AWAITED_MAX => {
                        drop(
                            self.desk
                                .answered(connection, Err("not given: too many requests; give it again".to_owned())),
                        );
                    }
                    Some(cell) => {
                        let reply = cell.request(request);
                        self.awaited.push(async move { (connection, reply.await) }.boxed_local());
                    }
                    // The desk asks of cells only what their state permits.
                    None => drop(self.desk.answered(connection, Err("this is no cell".to_owned()))),
                },
                other => self.perform(of.client, vec![other]),
            }
        }
    }

    /// Waits for the next reply of the coordinator, for ever where none is awaited, and takes it. Gives whether nothing has come: then what
    /// was asked is to be given up. Cancel safe.
    pub async fn replied(&mut self) -> bool {
        let Some((connection, reply)) = self.awaited.next().await else { return std::future::pending().await };
        let is_none = matches!(reply, CellReply::None);
        let reply = match reply {
            CellReply::Done(text) => Ok(text),
            CellReply::Refused(why) => Err(why),
            CellReply::None => Err(format!(
                "no reply within {} s; it is not asked again, and whether it was done is shown by the state of the cell",
                REPLY_WITHIN.as_secs()
            )),
        };
        for effect in self.desk.answered(connection, reply) {
            if let DeskEffect::Log(text) = effect {
                tracing::info!("console: {text}");
            }
        }
        is_none
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
        // No button that is held is one of a cell alone.
        let (messages, effects) = self.desk.due(now, |act| refusal(client, None, act));
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

    /// The steps back to auto as pages show them from now on (see [`ControlDesk::plan`]).
    pub fn plan(&mut self, now: Duration, plan: Option<PlanPart>, is_current: bool) -> Option<PlanPart> {
        self.desk.plan(now, plan, is_current)
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
                // What is asked at a page is done where that is taken.
                DeskEffect::Acknowledge { .. } | DeskEffect::Ask { .. } => {}
            }
        }
    }
}

/// Why an act would do nothing now.
fn refusal(client: &OperatorClient, cell: Option<&CellClient>, act: &PageAct) -> Option<String> {
    let states = OperateStates {
        coordinator: client.coordinator(),
        stations: client.line().station_ids().map(|id| client.station(id)).collect(),
        is_other_description: !client.other_descriptions().is_empty(),
        cell: cell.and_then(CellClient::heard_lately),
    };
    why_not(client.line(), &states, act, mode_name)
}
