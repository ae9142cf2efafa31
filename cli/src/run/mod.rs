//! `linewright run`: the whole line on this machine, from plant to operator.
//!
//! It starts the simulated plant, the coordinator and one node per station as processes of their own, brings the line
//! to auto as an operator would, shows it, and stops it at home. It commands and reads over the same ROS topics
//! anybody can use; the only thing it has for itself is an observer of the CAN frames that looks for conflicts.

mod cell;
pub mod chart;
mod children;
mod observer;
mod tally;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args as ClapArgs;
use linewright_canopen::Frame;
use linewright_fieldbus::{Bus as CanBus, BusError, BusOptions, OwnBuses};
use linewright_line::{DeviceBus, Line};
use linewright_msgs::{LineState, StationState};
use linewright_node_shell::{Claim, RosArgs};
use miette::{IntoDiagnostic, WrapErr, miette};
use tokio::sync::mpsc;

use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;
use crate::load;
use crate::nodes::{DEFAULT_BUS, claim_coordinator, claim_station};
use crate::watch::{PICTURE_EVERY, Screen, WatchState};
use cell::CellRun;
use children::Children;
use observer::BusObserver;
use tally::RunTally;

/// Run a whole line on this machine, with simulated devices.
#[derive(Debug, ClapArgs)]
pub struct Args {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// End after this many cycles, at home.
    #[arg(long)]
    cycles: Option<usize>,
    /// Make these parts of a cell and end, as A=2,B=1.
    #[arg(long, value_delimiter = ',', value_parser = crate::simulate::parts)]
    parts: Vec<(String, u32)>,
    /// Print one JSON object at the end, and nothing else.
    #[arg(long)]
    json: bool,
    /// Leave the line at home, in the mode it comes up in; somebody else operates it.
    #[arg(long)]
    no_auto: bool,
    /// Start no simulated plant: the devices are real, or run elsewhere.
    #[arg(long)]
    no_plant: bool,
    /// The CAN interface of the line's bus.
    #[arg(long, default_value = DEFAULT_BUS)]
    bus: String,
    /// Keep journals and logs in this directory and go on from them; by default in a new temporary one.
    #[arg(long)]
    state_dir: Option<PathBuf>,
    /// Host this many stations per process.
    #[arg(long, default_value_t = 1)]
    stations_per_process: usize,
    /// Fail when no cycle ends for this many seconds; by default 30, or four times what the chart's operations take
    /// together if that is more.
    #[arg(long)]
    patience: Option<f64>,
}

/// Where the run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RunPhase {
    /// Waiting for everybody, then giving start and auto.
    Starting,
    /// In auto.
    Running,
    /// Master stop is given.
    Stopping,
}

/// How often a command is repeated until its effect is seen: it is not latched, and discovery takes a moment.
const REPEAT: Duration = Duration::from_millis(300);

/// `linewright run`
pub async fn run(args: Args, ros: RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, args.json)?;
    let cell = load::cell_of(&args.line, &line)?;
    match &cell {
        None if !args.parts.is_empty() => return Err(miette!("--parts is for cells; there is no cell.toml")),
        Some(_) if args.cycles.is_some() => return Err(miette!("a cell has no cycles; order parts with --parts")),
        Some(_) | None => {}
    }
    if args.cycles == Some(0) || args.stations_per_process == 0 {
        return Err(miette!("--cycles and --stations-per-process are at least 1"));
    }
    let _claim = Claim::line(&ros, &format!("/{}", line.name)).map_err(|error| miette!("{error}"))?;
    // Whose devices are its own has buses of its own; others' devices are on the buses that everybody shares.
    let about = crate::can::run_of(&line, &ros)?;
    let own = if args.no_plant { None } else { OwnBuses::create(&about).into_diagnostic()? };
    let bus = BusOptions { dir: own.as_ref().map(|own| own.dir().to_owned()), ..BusOptions::default() };
    let scratch = RunDirectory::new(args.state_dir.as_deref())?;
    nothing_runs_yet(&line, &args, &ros, &bus)?;
    let mut children = Children::new(&scratch.dir, own.as_ref().map(OwnBuses::dir));
    let mut session = Session::open(&line, &args, &ros, &scratch.dir, &bus).await?;
    session.cell = cell.map(|cell| CellRun::open(&line, &cell, &args.parts, &ros)).transpose()?;
    let outcome = match start_all(&mut children, &line, &args, &scratch.dir, session.virtual_bus) {
        Ok(()) => session.drive(&mut children).await,
        Err(error) => Err(error),
    };
    children.end().await;
    let code = session.report(&args, outcome, children.restarts())?;
    scratch.end(code == ExitCode::SUCCESS);
    Ok(code)
}

/// Looks whether what is about to be started is there already, so that nothing is started beside it. The nodes claim the
/// same again.
fn nothing_runs_yet(line: &Line, args: &Args, ros: &RosArgs, bus: &BusOptions) -> miette::Result<()> {
    let state_dir = args.state_dir.as_deref();
    let mut claims = vec![claim_coordinator(line, ros, &args.bus, state_dir, bus)?];
    for station in line.station_ids() {
        claims.push(claim_station(line, ros, station, state_dir, bus)?);
    }
    Ok(())
}

fn start_all(children: &mut Children, line: &Line, args: &Args, dir: &Path, virtual_bus: bool) -> miette::Result<()> {
    // A cell's description lies beside its line's, so nodes are given the directory.
    let path = if args.line.is_dir() { args.line.clone() } else { load::file_of(&args.line) };
    let description = path.canonicalize().into_diagnostic()?.display().to_string();
    let state = dir.display().to_string();
    let words = |more: &[&str]| -> Vec<String> {
        let mut words: Vec<String> = more.iter().map(|word| (*word).to_owned()).collect();
        words.extend(["--end-with-stdin".to_owned(), description.clone()]);
        words.extend(virtual_bus.then(|| "--virtual-bus".to_owned()));
        words.extend(forwarded_ros_args());
        words
    };
    if !args.no_plant {
        children.start("plant", words(&["plant", "--bus", &args.bus]))?;
    }
    children.start("coordinator", words(&["coordinator", "--bus", &args.bus, "--state-dir", &state]))?;
    for group in line.stations.chunks(args.stations_per_process) {
        let names: Vec<&str> = group.iter().map(|station| station.name.as_str()).collect();
        let mut more = vec!["station", "--state-dir", &state];
        for name in &names {
            more.extend(["--station", name]);
        }
        children.start(&names.join("+"), words(&more))?;
    }
    Ok(())
}

/// The ROS arguments this process was given, for the nodes it starts.
fn forwarded_ros_args() -> Vec<String> {
    let mut inside = false;
    let is_ros = |argument: &String| {
        inside = (inside && argument != "--") || argument == "--ros-args";
        inside
    };
    // Each stretch begins anew with --ros-args, so that it need not be ended.
    std::env::args().filter(is_ros).collect()
}

struct Session {
    line: Line,
    client: OperatorClient,
    observer: BusObserver,
    frames: mpsc::Receiver<Result<(DeviceBus, Frame), BusError>>,
    tally: RunTally,
    view: WatchState,
    phase: RunPhase,
    target: Option<usize>,
    cell: Option<CellRun>,
    no_auto: bool,
    /// One of the buses is virtual at least, and so may those of the nodes be.
    virtual_bus: bool,
    live: bool,
    said: Option<Instant>,
    progress: (usize, Instant),
    patience: Duration,
}

impl Session {
    async fn open(line: &Line, args: &Args, ros: &RosArgs, dir: &Path, options: &BusOptions) -> miette::Result<Self> {
        let (to, frames) = mpsc::channel(4096);
        let (mut head, mut virtual_bus) = (Vec::new(), false);
        let on_can = line.devices.iter().filter(|device| device.is_on_can());
        let mut buses: Vec<&DeviceBus> = on_can.map(|device| &device.bus).collect();
        buses.sort_by_key(|bus| bus.to_string());
        buses.dedup();
        for bus in buses {
            let interface = match bus {
                DeviceBus::Line => &args.bus,
                DeviceBus::Own(interface) => interface,
            };
            let mut listener = CanBus::open(interface, options).into_diagnostic()?;
            head.push(format!("CAN: {}", listener.describe()));
            virtual_bus |= listener.is_virtual();
            let (to, bus) = (to.clone(), bus.clone());
            tokio::spawn(async move {
                loop {
                    let frame = listener.recv().await.map(|frame| (bus.clone(), frame));
                    let is_gone = frame.is_err();
                    if to.send(frame).await.is_err() || is_gone {
                        break;
                    }
                }
            });
        }
        head.push(format!("logs and journals: {}", dir.display()));
        let live = !args.json && std::io::stdout().is_terminal();
        if !args.json && !live {
            crate::out::say!("{}", head.join("\n"));
        }
        let mut view = WatchState::new(line);
        view.head = head;
        let works = line.stations.iter().flat_map(|s| &s.operations).map(|o| o.duration.as_secs_f64()).sum::<f64>();
        Ok(Session {
            client: OperatorClient::open(line, ros, "run")?,
            observer: BusObserver::new(line),
            frames,
            tally: RunTally::new(line),
            view,
            phase: RunPhase::Starting,
            target: args.cycles,
            cell: None,
            no_auto: args.no_auto,
            virtual_bus,
            live,
            said: None,
            progress: (0, Instant::now()),
            patience: Duration::from_secs_f64(args.patience.unwrap_or_else(|| (works * 4.0).max(30.0)).clamp(0.1, 1e6)),
            line: line.clone(),
        })
    }

    /// Runs until the cycles are done, the operator ends it, or it fails.
    async fn drive(&mut self, children: &mut Children) -> miette::Result<()> {
        let mut screen = if self.live { Some(Screen::open()?) } else { None };
        let mut ticks = tokio::time::interval(PICTURE_EVERY);
        let mut interrupts = Interrupts::listen()?;
        loop {
            tokio::select! {
                heard = self.client.next() => self.take(&heard?),
                told = next_of(&mut self.cell) => for line in told? {
                    if !self.live {
                        crate::out::complain!("{line}");
                    }
                    self.view.say(line);
                },
                Some(frame) = self.frames.recv() => {
                    let (bus, frame) = frame.into_diagnostic()?;
                    let before = self.observer.conflicts().len();
                    self.observer.frame(&bus, &frame);
                    for conflict in &self.observer.conflicts()[before..] {
                        self.view.say(format!("CONFLICT {conflict}"));
                    }
                }
                () = interrupts.next() => {
                    if self.phase != RunPhase::Running {
                        return Ok(());
                    }
                    self.phase = RunPhase::Stopping;
                    self.said = None;
                    self.view.say("stopping at home; Ctrl-C again ends at once".to_owned());
                }
                _ = ticks.tick() => {
                    for name in children.revive()? {
                        self.view.say(format!("started again: {name}"));
                        if !self.live {
                            crate::out::complain!("started again: {name}");
                        }
                    }
                    if let Some(screen) = &mut screen {
                        screen.show(&self.view.picture(&self.client, Screen::width()))?;
                    }
                }
            }
            if self.phase == RunPhase::Running
                && let Some(cell) = &mut self.cell
            {
                cell.begin().await?;
                if cell.is_over() {
                    self.phase = RunPhase::Stopping;
                    self.said = None;
                }
            }
            if self.advance()? {
                return Ok(());
            }
        }
    }

    fn take(&mut self, heard: &StateUpdate) {
        self.view.take(heard);
        match heard {
            StateUpdate::Line => {}
            StateUpdate::Station(id) => {
                let id = *id;
                if let Some(state) = self.client.station(id).cloned() {
                    self.tally.state(id, &state);
                    let begun = self.tally.begun(id, &state);
                    if self.phase == RunPhase::Running && self.target.is_some_and(|target| begun >= target) {
                        self.phase = RunPhase::Stopping;
                        self.said = None;
                    }
                }
            }
            StateUpdate::Event(id, event) => self.tally.event(*id, event),
        }
    }

    /// Gives the commands the phase asks for; true when the run is over.
    fn advance(&mut self) -> miette::Result<bool> {
        let Some(state) = self.client.coordinator().cloned() else { return self.wait() };
        match self.phase {
            RunPhase::Starting if !self.no_auto => match state.mode {
                StationState::MODE_HOME if self.all_ready() => self.say("start"),
                StationState::MODE_STANDBY if self.all_ready() => self.say("auto"),
                StationState::MODE_AUTO if state.enabled => {
                    self.tally.begin(&state.header);
                    self.progress.1 = Instant::now();
                    self.phase = RunPhase::Running;
                }
                _ => {}
            },
            // Somebody else operates it; the cycles are counted all the same.
            RunPhase::Starting if state.mode == StationState::MODE_AUTO && state.enabled => {
                self.tally.begin(&state.header)
            }
            RunPhase::Starting => {}
            RunPhase::Running if state.mode == StationState::MODE_STANDBY && self.ends() => {
                return Err(miette!("auto ended: {}", self.why(&state)));
            }
            RunPhase::Running => {}
            RunPhase::Stopping => match state.mode {
                StationState::MODE_AUTO if state.master_stop => {}
                StationState::MODE_AUTO | StationState::MODE_HAND => self.say("stop"),
                // The coordinator may be heard before the states that it has decided by.
                StationState::MODE_HOME if self.all_home() => return Ok(true),
                StationState::MODE_HOME => {}
                _ if self.ends() => return Err(miette!("the stop ended in {}", self.why(&state))),
                // The operator recovers it first; a second Ctrl-C ends at once.
                _ => {}
            },
        }
        self.wait()
    }

    /// Nothing to do now; but not for ever where nobody is looking.
    fn wait(&mut self) -> miette::Result<bool> {
        if self.tally.cycles() != self.progress.0 {
            self.progress = (self.tally.cycles(), Instant::now());
        }
        let went_on = self.cell.as_ref().map_or(self.progress.1, |cell| self.progress.1.max(cell.since()));
        if self.ends() && went_on.elapsed() > self.patience {
            let mut reasons = match self.client.coordinator() {
                Some(state) => vec![format!("the mode is {}", state.text)],
                None => vec!["no state received from the coordinator".to_owned()],
            };
            reasons.extend(self.cell.iter().flat_map(CellRun::waits));
            for id in self.line.station_ids() {
                let name = &self.line.station(id).name;
                match self.client.station(id) {
                    Some(state) if state.blocked_by.is_empty() => reasons.push(format!("{name}: {}", state.operation)),
                    Some(state) => reasons.push(format!("{name} waits for {}", state.blocked_by.join("; "))),
                    None => reasons.push(format!("no state received from {name}")),
                }
            }
            return Err(miette!("nothing was done for {:.0} s: {}", self.patience.as_secs_f64(), reasons.join(", ")));
        }
        Ok(false)
    }

    /// Whether it is to end by itself.
    fn ends(&self) -> bool {
        self.target.is_some() || self.cell.as_ref().is_some_and(|cell| cell.made().1 > 0)
    }

    fn all_ready(&self) -> bool {
        self.line.station_ids().all(|id| self.client.station(id).is_some_and(|state| state.devices_valid))
    }

    /// Whether every station that is heard has obeyed, and so has said all it did before.
    fn all_home(&self) -> bool {
        let is_home = |state: &StationState| state.mode == StationState::MODE_HOME;
        self.line.station_ids().all(|id| self.client.station(id).is_none_or(is_home))
    }

    fn why(&self, state: &LineState) -> String {
        let faults = self.tally.fault_texts();
        if faults.is_empty() { state.text.clone() } else { format!("{} ({})", state.text, faults.join("; ")) }
    }

    fn say(&mut self, word: &str) {
        if self.said.is_none_or(|at| at.elapsed() >= REPEAT) {
            self.said = Some(Instant::now());
            self.client.command(word);
        }
    }

    fn report(&self, args: &Args, outcome: miette::Result<()>, restarts: u32) -> miette::Result<ExitCode> {
        let faults = self.tally.faults();
        let parts = self.cell.as_ref().map(CellRun::made).filter(|(_, wanted)| *wanted > 0);
        let short = self.target.is_some_and(|target| self.tally.cycles() < target);
        let short = short || parts.is_some_and(|(made, wanted)| made < wanted);
        let conflicts = self.observer.conflicts();
        let ok = outcome.is_ok() && !short && conflicts.is_empty() && (!self.ends() || faults == 0);
        let error = match &outcome {
            Err(error) => Some(error.to_string()),
            Ok(()) if let Some((made, wanted)) = parts.filter(|_| short) => {
                Some(format!("{made} of {wanted} parts finished"))
            }
            Ok(()) if short => Some(format!("{} of {} cycles ended", self.tally.cycles(), args.cycles.unwrap_or(0))),
            Ok(()) => None,
        };
        let mode = self.client.coordinator().map_or("no state received", |state| mode_name(state.mode));
        let mut report = self.tally.report(mode, &self.observer, restarts, error.clone());
        (report.parts_made, report.parts_wanted) = parts.unzip();
        if args.json {
            crate::out::say!("{}", serde_json::to_string(&report).into_diagnostic()?);
        } else {
            let done = match parts {
                Some((made, wanted)) => format!("{made} of {wanted} parts"),
                None => format!("{} cycles", report.cycles),
            };
            crate::out::say!(
                "{done}, {faults} faults, {} conflicts seen in {} CAN frames",
                conflicts.len(),
                report.frames_seen
            );
            for conflict in &report.conflicts_seen {
                crate::out::say!("conflict: {conflict}");
            }
            for conflict in &report.conflicts_not_watched {
                crate::out::say!("not watched, its switches are in frames this observer does not read: {conflict}");
            }
            if let Some(error) = error {
                crate::out::complain!("linewright: {error}");
            }
        }
        Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

async fn next_of(cell: &mut Option<CellRun>) -> miette::Result<Vec<String>> {
    match cell {
        Some(cell) => cell.next().await,
        None => std::future::pending().await,
    }
}

fn mode_name(code: u8) -> &'static str {
    linewright_node_line::mode_from_code(code).map_or("unknown", |mode| mode.name())
}

/// The directory of this run's journals and logs.
struct RunDirectory {
    dir: PathBuf,
    temporary: bool,
}

impl RunDirectory {
    fn new(given: Option<&Path>) -> miette::Result<Self> {
        let dir = match given {
            Some(dir) => dir.to_owned(),
            None => std::env::temp_dir().join(format!("linewright-run-{}", std::process::id())),
        };
        std::fs::create_dir_all(&dir).into_diagnostic().wrap_err_with(|| format!("cannot use {}", dir.display()))?;
        Ok(RunDirectory { dir, temporary: given.is_none() })
    }

    /// A temporary directory is kept only if somebody will want to read the logs.
    fn end(self, ok: bool) {
        if self.temporary && ok {
            let _ = std::fs::remove_dir_all(&self.dir);
        }
    }
}
