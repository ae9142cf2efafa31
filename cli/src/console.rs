//! `linewright console`: the page of a line for browsers on this machine.
//!
//! A ROS 2 node as that of `watch`, `mode` and `press`: the page is made of what the nodes publish, and what is done at it becomes the same
//! messages. What makes it, takes the states in and publishes held buttons is one loop; where that stands, no frame is sent, every page
//! shows that it is cut off, and no button is held any more.

mod commands;

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use clap::Args as ClapArgs;
use linewright_console_server::PageServer;
use linewright_console_view::{
    CellChoices, ConsoleInputs, ConsoleView, PageFeed, PageFrame, PlanPart, ReasonsByResource,
};
use linewright_fieldbus::Clock;
use linewright_line::{Line, StationId, Tick};
use linewright_msgs::{CycleTime, StationState};
use linewright_node_shell::{RosArgs, forward, qos};
use miette::miette;
use tokio::sync::{mpsc, watch};

use crate::cell::CellClient;
use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;
use crate::load;
use crate::recover::NewestPlan;
use crate::states::mode_name;
use crate::watch::next::look;
use commands::{PageCommands, PageSurroundings};

use crate::watch::{AskedReasons, REASONS_EVERY, next_of};

/// Show a running line in a browser on this machine.
#[derive(Debug, ClapArgs)]
#[command(
    after_help = "Prints the address to open, and serves until Ctrl-C. One page at a time has control and commands; the others read. It may be started before its line, and stays while the line is started again. Only loopback addresses are served; TLS and log-in are not built yet."
)]
pub struct Args {
    /// The directory of a line or cell, or its description file.
    line: PathBuf,
    /// Loopback address and port; port 0 chooses a free one.
    #[arg(long, default_value = "127.0.0.1:8080", value_parser = address)]
    listen: SocketAddr,
}

/// Period of frames.
const FRAME_EVERY: Duration = Duration::from_millis(100);
/// Period of the look at what is held: twice as often as it is published.
const LOOK_EVERY: Duration = Duration::from_millis(25);
/// Frames from one look for the steps back to auto to the next.
const LOOK_FRAMES: u64 = 5;
/// Time for which the steps found last are shown while others are looked for.
const SHOWN_FOR: Duration = Duration::from_secs(1);
/// What pages have sent and is not taken in yet.
const EVENTS: usize = 256;

fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| "expected an address with its port, e.g. 127.0.0.1:8080 or [::1]:8080".to_owned())
}

/// `linewright console`
pub async fn run(args: Args, ros: &RosArgs) -> miette::Result<ExitCode> {
    let (line, is_cell) = load::line_or_cell(&args.line)?;
    let server = PageServer::bind(args.listen).await.map_err(|error| miette!("{error}"))?;
    let mut client = OperatorClient::open(&line, &args.line, ros, "console")?;
    let mut cell = is_cell.then(|| CellClient::open(&line, ros, "console_cell")).transpose()?;
    let cycle = client.node().subscription("cycle_time", qos::latched_state()).map_err(|error| miette!("{error}"))?;
    let (to, mut cycles) = mpsc::channel(4);
    let _forward = forward(cycle, to, |message, _| Some(message));
    let mut commands = PageCommands::open(&mut client)?;
    let (frames, newest) = watch::channel(None);
    let (to, mut events) = mpsc::channel(EVENTS);
    crate::out::say!("{}", server.url());
    let _serving = tokio::spawn(server.run(newest, to));
    let names = names(&args.line, &line)?;
    let mut console = ConsoleLoop::new(&line, names);
    let mut looks = tokio::time::interval(LOOK_EVERY);
    looks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    let mut ticks = tokio::time::interval(FRAME_EVERY);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    let mut reasons = tokio::time::interval(REASONS_EVERY);
    let mut asked = AskedReasons::default();
    let mut interrupts = Interrupts::listen()?;
    let ended: miette::Result<()> = loop {
        // A release is taken in before what is held is published.
        while let Ok(event) = events.try_recv() {
            let now = console.now();
            commands.take(now, &mut console.around(&client, cell.as_ref()), event);
        }
        commands.publish(console.now(), &client);
        tokio::select! {
            biased;
            Some(event) = events.recv() => {
                let now = console.now();
                commands.take(now, &mut console.around(&client, cell.as_ref()), event);
            }
            is_none = commands.replied() => if let Some(cell) = cell.as_mut().filter(|_| is_none) {
                cell.give_up()?;
                // What is asked by the former callers keeps them, and what they would still send.
                asked = AskedReasons::default();
            },
            () = interrupts.next() => break Ok(()),
            _ = looks.tick() => {}
            _ = ticks.tick() => drop(frames.send_replace(Some(Arc::new(console.frame(&client, cell.as_ref(), &mut commands))))),
            heard = client.next() => match heard {
                Ok(StateUpdate::Station(id)) => console.station(&client, id),
                Ok(_) => {}
                Err(error) => break Err(error),
            },
            heard = next_of(&mut cell) => if let Err(error) = heard {
                break Err(error);
            },
            Some(cycle) = cycles.recv() => console.cycle = Some(cycle),
            known = asked.reply() => console.out_of_service = known,
            _ = reasons.tick() => asked.ask(cell.as_ref(), CellClient::heard_lately),
        }
    };
    commands.close(&console.clock, &client).await;
    ended.map(|()| ExitCode::SUCCESS)
}

/// What operators name of a cell; none of a line.
fn names(path: &Path, line: &Line) -> miette::Result<Option<CellChoices>> {
    let Some(cell) = load::cell_of(path, line)? else { return Ok(None) };
    let products = cell.part_types.iter().map(|of| of.name.clone()).collect();
    let resources = cell.resources.iter().map(|of| of.name.clone()).collect();
    Ok(Some(CellChoices { products, resources }))
}

/// What the console keeps beside the newest states.
struct ConsoleLoop {
    clock: Clock,
    view: ConsoleView,
    feed: PageFeed,
    plan: NewestPlan,
    cycle: Option<CycleTime>,
    /// Life of the coordinator that `cycle` and `out_of_service` are of.
    coordinator: Option<u64>,
    out_of_service: ReasonsByResource,
    /// The steps back to auto that were found last, and when.
    steps: Option<(Duration, PlanPart)>,
    /// Whether they are those of what was received when they were looked for last.
    is_current: bool,
    frames: u64,
}

impl ConsoleLoop {
    fn new(line: &Line, names: Option<CellChoices>) -> Self {
        ConsoleLoop {
            clock: Clock::start(),
            view: ConsoleView::new(line, names, mode_name),
            feed: PageFeed::default(),
            plan: NewestPlan::default(),
            cycle: None,
            coordinator: None,
            out_of_service: ReasonsByResource::new(),
            steps: None,
            is_current: false,
            frames: 0,
        }
    }

    /// Looks for the steps back to auto. While a button is held they stay as they are: the one below the finger is to stay there.
    fn look(&mut self, client: &OperatorClient, cell: Option<&CellClient>, is_held: bool) {
        let is_on_way = |mode| !matches!(mode, StationState::MODE_AUTO | StationState::MODE_HOME);
        if !client.coordinator().is_some_and(|state| is_on_way(state.mode)) {
            self.steps = None;
        } else if !is_held {
            let now = self.now();
            let found = self.plan.look(client, cell);
            self.is_current = found.is_some();
            match found {
                Some(found) => self.steps = Some((now, PlanPart::of(client.line(), &found.plan, &found.reasons))),
                None => self.steps = self.steps.take().filter(|(at, _)| now.saturating_sub(*at) < SHOWN_FOR),
            }
        }
    }

    /// What a page's acts are about.
    fn around<'a>(&'a mut self, client: &'a OperatorClient, cell: Option<&'a CellClient>) -> PageSurroundings<'a> {
        PageSurroundings { client, cell, view: &mut self.view }
    }

    /// Time since the begin of the console, in which the machine may have slept.
    fn now(&self) -> Duration {
        self.clock.now().since(Tick::ZERO)
    }

    /// A station's state has come.
    fn station(&mut self, client: &OperatorClient, id: StationId) {
        if let Some(aged) = client.station_aged(id) {
            self.view.take_station(self.now(), id, aged.state);
        }
    }

    /// The frame of now.
    fn frame(&mut self, client: &OperatorClient, cell: Option<&CellClient>, commands: &mut PageCommands) -> PageFrame {
        let control = commands.part(self.now());
        self.frames += 1;
        if self.frames.is_multiple_of(LOOK_FRAMES) {
            self.look(client, cell, control.press.is_some());
        }
        let next = look(&mut self.plan, client, cell);
        let now = self.now();
        let life = client.coordinator_aged().map(|aged| aged.state.boot_id);
        if life != self.coordinator {
            // What another one has sent is of before.
            if self.coordinator.is_some() {
                (self.cycle, self.out_of_service) = (None, ReasonsByResource::new());
            }
            self.coordinator = life;
        }
        let page = self.view.page(&ConsoleInputs {
            now,
            line: client.coordinator_aged(),
            stations: client.line().station_ids().map(|id| client.station_aged(id)).collect(),
            cell: cell.and_then(CellClient::aged),
            cycle: self.cycle.as_ref(),
            next: next.as_ref(),
            out_of_service: &self.out_of_service,
            other_descriptions: client.other_descriptions(),
            plan: commands.plan(now, self.steps.as_ref().map(|(_, steps)| steps.clone()), self.is_current),
            control,
        });
        self.feed.frame(now, &page)
    }
}
