//! `linewright run`: the whole line on this machine, from plant to operator.
//!
//! It starts the simulated plant, the coordinator and one node per station as processes of their own, brings the line
//! to auto as an operator would, shows it, and stops it at home. It commands and reads over the same ROS topics as any
//! user; the only addition is an observer of the CAN frames that looks for conflicts.

mod auto_once;
mod cell;
pub mod chart;
mod children;
mod directory;
mod ending;
mod observer;
mod start;
mod startup;
pub mod stopping;
mod tally;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Args as ClapArgs;
use linewright_canopen::Frame;
use linewright_coordinator_node::line::not_recorded;
use linewright_fieldbus::{Bus as CanBus, BusError, BusOptions, OwnBuses};
use linewright_line::{DeviceBus, Line};
use linewright_msgs::StationState;
use linewright_node_shell::{Claim, RosArgs};
use miette::{IntoDiagnostic, miette};
use tokio::sync::mpsc;

use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;
use crate::load;
use crate::nodes::DEFAULT_BUS;
use crate::parts::{PartList, at_least_1};
use crate::watch::{PICTURE_EVERY, Screen, WatchState};
use auto_once::AutoOnce;
use cell::CellRun;
use children::Children;
use directory::RunDirectory;
use observer::BusObserver;
use start::{addresses_are_free, arguments_fit, nothing_runs_yet, start_all, structure_holds};
use startup::StartUp;
use stopping::{StopStep, next_step};
use tally::{RunTally, standing};

/// Run a whole line on this machine, with simulated devices.
#[derive(Debug, ClapArgs)]
pub struct Args {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Cycles of the line after which to end, at home. After a fault an operator can go on; the exit code is 1 then.
    #[arg(long, value_parser = at_least_1)]
    cycles: Option<usize>,
    /// Make these parts of a cell and end, as A=2,B=1; may be repeated.
    #[arg(long, value_name = "TYPE=N", value_parser = PartList::read)]
    parts: Vec<PartList>,
    /// Print one JSON object at the end, and nothing else.
    #[arg(long)]
    json: bool,
    /// Leave the line at home in its first mode, to be operated from elsewhere.
    #[arg(long)]
    no_auto: bool,
    /// Nodes wait for the transitions configure and activate of a lifecycle manager, and the run gives no command.
    #[arg(long)]
    no_autostart: bool,
    /// Start a line that `check --structure` refuses.
    #[arg(long)]
    unchecked: bool,
    /// Start no simulated plant: the devices are real, or run elsewhere.
    #[arg(long)]
    no_plant: bool,
    /// The CAN interface of the line's bus.
    #[arg(long, default_value = DEFAULT_BUS)]
    bus: String,
    /// Directory of journals and logs, from which the run goes on; it gives no auto where the run before in it has not ended at home
    /// [default: a new temporary one].
    #[arg(long)]
    state_dir: Option<PathBuf>,
    /// Days for which the database keeps what happens; without this everything is kept.
    #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u32).range(1..=36_500))]
    retention: Option<u32>,
    /// Number of stations in each process.
    #[arg(long, default_value_t = 1, value_parser = at_least_1)]
    stations_per_process: usize,
    /// Longest time without progress, in seconds: with --cycles or --parts, the run fails when no cycle ends and no
    /// mode changes for so long; always, when the line is not at home so long after Ctrl-C [default: 30, or four times
    /// the durations of the chart's operations together if that is more].
    #[arg(long, value_parser = seconds)]
    patience: Option<f64>,
}

fn seconds(word: &str) -> Result<f64, String> {
    let seconds = word.parse().ok().filter(|seconds| (0.1..=1e6).contains(seconds));
    seconds.ok_or_else(|| "expected seconds from 0.1 to 1000000, without a unit, e.g. 30".to_owned())
}

/// Phase of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RunPhase {
    /// Waiting for coordinator and stations, then giving start and auto; with --no-auto until another has given them.
    Starting,
    /// In auto.
    Running,
    /// The line is being stopped, since then.
    Stopping(Instant),
}

/// Interval of the messages that name what a stop waits for.
const STOP_SAID_EVERY: Duration = Duration::from_secs(5);
/// Period at which a command is repeated until it takes effect: it is not latched, and discovery takes a moment.
const REPEAT: Duration = Duration::from_millis(300);

/// `linewright run`
pub async fn run(args: Args, ros: RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, args.json)?;
    let cell = load::cell_of(&args.line, &line)?;
    arguments_fit(&line, cell.as_ref(), &args, &ros)?;
    if !args.unchecked {
        structure_holds(&line, &args.line)?;
    }
    let _claim = Claim::line(&ros, &format!("/{}", line.name)).map_err(|error| miette!("{error}"))?;
    // A run with its own devices has buses of its own; other devices are on the shared buses.
    let about = crate::can::run_of(&line, &ros)?;
    let own = if args.no_plant { None } else { OwnBuses::create(&about).into_diagnostic()? };
    let bus = BusOptions { dir: own.as_ref().map(|own| own.dir().to_owned()), ..BusOptions::default() };
    let scratch = RunDirectory::new(args.state_dir.as_deref(), &line)?;
    let lost = scratch.lost_journals(&line).filter(|_| cell.is_none());
    nothing_runs_yet(&line, &args, &ros, &bus)?;
    addresses_are_free(&line, &args).await?;
    let mut children = Children::new(&scratch.dir, own.as_ref().map(OwnBuses::dir), &load::files_of(&args.line))?;
    let mut session = Session::open(&line, &args, &ros, &scratch.dir, &bus).await?;
    if !args.no_plant {
        scratch.machine_note(&line).into_iter().for_each(|note| session.note(note));
    }
    for note in lost.into_iter().chain(scratch.unfinished().filter(|_| !args.no_auto)) {
        session.note(note);
        session.auto_once = AutoOnce::by_others();
    }
    scratch.begin()?;
    let dir = args.state_dir.as_deref().filter(|_| cell.is_none());
    if let Some(note) = dir.and_then(|dir| not_recorded(dir, &line)) {
        // It stands as long as the run, above the picture.
        session.view.head.push(note.clone());
        session.note(note);
    }
    session.cell = cell.map(|cell| CellRun::open(&line, &cell, PartList::sum(&args.parts), &ros)).transpose()?;
    let outcome = match start_all(&mut children, &line, &args, &ros, &scratch.dir, session.virtual_bus).await {
        Ok(()) => session.drive(&mut children).await,
        Err(error) => Err(error),
    };
    children.end().await;
    // Where not even a coordinator was received, it is as it was before.
    let at_home = outcome.as_ref().is_ok_and(|at_home| *at_home || scratch.unfinished().is_none());
    let code = session.report(&args, outcome.map(drop), children.restarts())?;
    scratch.end(at_home, code == ExitCode::SUCCESS);
    Ok(code)
}

struct Session {
    line: Line,
    client: OperatorClient,
    observer: BusObserver,
    frames: mpsc::Receiver<Result<(DeviceBus, Frame), BusError>>,
    tally: RunTally,
    view: WatchState,
    phase: RunPhase,
    startup: StartUp,
    target: Option<usize>,
    cell: Option<CellRun>,
    /// What it gives on the way to auto.
    auto_once: AutoOnce,
    /// Text of the command given last on the way to auto.
    given: String,
    /// One of the buses is virtual at least, and so may those of the nodes be.
    virtual_bus: bool,
    /// The picture is shown on a terminal.
    live: bool,
    json: bool,
    began: Instant,
    /// The mode, as it was printed last.
    mode_text: String,
    said: Option<Instant>,
    /// Time of the next message that names what a stop waits for.
    stop_said_at: Instant,
    progress: RunProgress,
    patience: Duration,
}

/// Progress of a run.
struct RunProgress {
    cycles: usize,
    mode: Option<u8>,
    /// Time of the last change.
    since: Instant,
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
            head.push((interface.clone(), listener.describe(), listener.is_virtual()));
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
        let mut head = startup::buses(&head);
        head.push(format!("logs and journals: {}", dir.display()));
        let live = !args.json && std::io::stdout().is_terminal();
        if !args.json && !live {
            crate::out::say!("{}", head.join("\n"));
        }
        let mut view = WatchState::new(line);
        view.head = head;
        let works = line.stations.iter().flat_map(|s| &s.operations).map(|o| o.duration.as_secs_f64()).sum::<f64>();
        Ok(Session {
            client: OperatorClient::open(line, &args.line, ros, "run")?,
            observer: BusObserver::new(line),
            frames,
            tally: RunTally::new(line),
            view,
            phase: RunPhase::Starting,
            startup: StartUp::default(),
            target: args.cycles,
            cell: None,
            given: String::new(),
            auto_once: if args.no_auto || args.no_autostart { AutoOnce::by_others() } else { AutoOnce::default() },
            virtual_bus,
            live,
            json: args.json,
            began: Instant::now(),
            mode_text: String::new(),
            said: None,
            stop_said_at: Instant::now(),
            progress: RunProgress { cycles: 0, mode: None, since: Instant::now() },
            patience: Duration::from_secs_f64(args.patience.unwrap_or_else(|| (works * 4.0).max(30.0)).clamp(0.1, 1e6)),
            line: line.clone(),
        })
    }

    /// Runs until the cycles are done, the operator ends it, or it fails. False if it ended before a coordinator was received.
    async fn drive(&mut self, children: &mut Children) -> miette::Result<bool> {
        self.print(&StartUp::text(&self.line));
        let mut screen = if self.live { Some(Screen::open()?) } else { None };
        let mut ticks = tokio::time::interval(PICTURE_EVERY);
        let mut interrupts = Interrupts::listen()?;
        loop {
            tokio::select! {
                heard = self.client.next() => self.take(&heard?),
                told = CellRun::next_of(&mut self.cell) => for line in told? {
                    self.note(line);
                },
                Some(frame) = self.frames.recv() => {
                    let (bus, frame) = frame.into_diagnostic()?;
                    let before = self.observer.conflicts().len();
                    self.observer.frame(&bus, &frame);
                    let reached = self.observer.conflicts()[before..].iter().map(|reached| format!("CONFLICT {reached}"));
                    for line in reached.collect::<Vec<_>>() {
                        self.note(line);
                    }
                }
                () = interrupts.next() => {
                    match self.phase {
                        RunPhase::Stopping(_) => {
                            return Err(miette!("ended before the line was at home: {}", self.reasons().join(", ")));
                        }
                        // No coordinator has come up: there is nothing to stop.
                        RunPhase::Starting if !self.client.has_heard_coordinator() => return Ok(false),
                        RunPhase::Starting | RunPhase::Running => self.begin_stop(),
                    }
                    let limit = self.patience.as_secs_f64();
                    self.note(format!("stopping at home, for {limit:.0} s at most; Ctrl-C again ends at once"));
                }
                _ = ticks.tick() => {
                    self.print_mode();
                    for name in children.revive()? {
                        self.note(format!("started again: {name}"));
                    }
                    for line in children.plant_reports() {
                        self.note(line);
                    }
                    if let Some(screen) = &mut screen {
                        let cell = self.cell.as_ref().and_then(CellRun::state);
                        self.view.look(&self.client, self.cell.as_ref().map(CellRun::client));
                        screen.show(&self.view.picture(&self.client, cell, Screen::size()))?;
                    }
                }
            }
            if self.phase == RunPhase::Running
                && let Some(cell) = &mut self.cell
            {
                cell.begin().await?;
                if cell.is_over() {
                    self.begin_stop();
                }
            }
            if self.advance()? {
                return Ok(true);
            }
        }
    }

    fn take(&mut self, heard: &StateUpdate) {
        if let (Some(line), StateUpdate::Event(_, event)) = (self.view.take(heard), heard)
            && !self.startup.leaves_out(event)
        {
            self.print(&line);
        }
        match heard {
            StateUpdate::Line => self.print_mode(),
            StateUpdate::Station(id) => {
                let id = *id;
                if let Some(state) = self.client.station(id).cloned() {
                    let before = self.tally.cycles();
                    self.tally.state(id, &state);
                    if self.tally.cycles() > before {
                        let of = self.target.map_or(String::new(), |target| format!(" of {target}"));
                        self.print(&format!("cycle {}{of} ended", self.tally.cycles()));
                    }
                    let begun = self.tally.begun(id, &state);
                    let is_enough = self.target.is_some_and(|target| begun >= target);
                    if is_enough && self.phase == RunPhase::Running {
                        self.begin_stop();
                    }
                }
            }
            StateUpdate::Event(id, event) => self.tally.event(*id, event),
        }
    }

    /// Shows a line of progress: among the messages of the picture, or printed where no picture is shown.
    fn note(&mut self, line: String) {
        if self.json {
            crate::out::complain!("{line}");
        }
        self.print(&line);
        self.view.say(line);
    }

    /// Prints a line of progress where no picture is shown, with the seconds since the run began. On standard error, which
    /// does not wait for its reader: a run whose output is not read still ends at Ctrl-C, and still revives its nodes.
    fn print(&self, line: &str) {
        if !self.live && !self.json {
            crate::out::complain!("{:8.1} s  {line}", self.began.elapsed().as_secs_f64());
        }
    }

    /// Prints the mode if it has changed. While everything comes up, what is missing changes many times within a second.
    fn print_mode(&mut self) {
        let is_complete = startup::is_complete(self.client.coordinator(), self.states());
        let Some(state) = self.client.coordinator() else { return };
        if self.startup.look(self.began.elapsed(), is_complete) && state.text != self.mode_text {
            let text = state.text.clone();
            self.print(&format!("mode: {text}"));
            self.mode_text = text;
        }
    }

    fn begin_stop(&mut self) {
        let now = Instant::now();
        (self.phase, self.said, self.stop_said_at) = (RunPhase::Stopping(now), None, now + STOP_SAID_EVERY);
    }

    /// Stops the line; true when it is at home.
    ///
    /// # Errors
    /// Why it cannot come home by itself, or has not within the time limit.
    fn stop(&mut self, since: Instant) -> miette::Result<bool> {
        let state = self.client.coordinator();
        let stations: Vec<_> = self.states().collect();
        match next_step(state, &stations) {
            StopStep::Home => return Ok(true),
            StopStep::Stands => {
                return Err(miette!("the stop ended in {}", self.why()));
            }
            StopStep::Command => _ = self.say("stop"),
            StopStep::Wait => {}
        }
        if since.elapsed() > self.patience {
            let limit = self.patience.as_secs_f64();
            return Err(miette!("not at home {limit:.0} s after the stop: {}", self.reasons().join(", ")));
        }
        if Instant::now() >= self.stop_said_at {
            self.stop_said_at = Instant::now() + STOP_SAID_EVERY;
            self.note(format!("stopping: {}", self.reasons().join(", ")));
        }
        Ok(false)
    }

    /// Gives the commands of the phase; true when the run is over.
    fn advance(&mut self) -> miette::Result<bool> {
        if let RunPhase::Stopping(since) = self.phase {
            return self.stop(since);
        }
        let Some(state) = self.client.coordinator().cloned() else { return self.wait() };
        match self.phase {
            RunPhase::Starting => self.begin(&state),
            RunPhase::Running | RunPhase::Stopping(_) => {}
        }
        self.wait()
    }

    /// Nothing to do now, within a limit of time that each change of the mode renews.
    fn wait(&mut self) -> miette::Result<bool> {
        let before = self.progress.mode;
        let cycles = self.tally.cycles();
        let mode = self.client.coordinator().map(|state| state.mode).or(before);
        if (cycles, mode) != (self.progress.cycles, before) {
            self.progress = RunProgress { cycles, mode, since: Instant::now() };
        }
        let limit = self.patience.as_secs_f64();
        let has_left_auto = self.phase == RunPhase::Running && mode != Some(StationState::MODE_AUTO);
        if has_left_auto && before == Some(StationState::MODE_AUTO) && self.ends() {
            let ends = format!("without a change of the mode the run ends in {limit:.0} s");
            self.note(format!("auto ended: {}. Recover the line and give auto; {ends}", self.why()));
        }
        let went_on = self.cell.as_ref().map_or(self.progress.since, |cell| self.progress.since.max(cell.since()));
        if self.ends() && went_on.elapsed() > self.patience {
            if has_left_auto {
                return Err(miette!("auto ended, and was not given again within {limit:.0} s: {}", self.why()));
            }
            return Err(miette!("nothing was done for {limit:.0} s: {}", self.reasons().join(", ")));
        }
        Ok(false)
    }

    /// Reasons why the line and each station wait.
    fn reasons(&self) -> Vec<String> {
        let mut reasons = match self.client.coordinator() {
            Some(state) => vec![format!("the mode is {}", state.text)],
            None => vec!["no state received from the coordinator".to_owned()],
        };
        reasons.extend(self.cell.iter().flat_map(CellRun::waits));
        for id in self.line.station_ids() {
            let name = &self.line.station(id).name;
            reasons.push(match self.client.station(id) {
                Some(state) if state.blocked_by.is_empty() => format!("{name}: {}", state.operation),
                Some(state) => format!("{name} waits for {}", state.blocked_by.join("; ")),
                None => format!("no state received from {name}"),
            });
        }
        reasons
    }

    /// Whether it is to end by itself.
    fn ends(&self) -> bool {
        self.target.is_some() || self.cell.as_ref().is_some_and(|cell| cell.made().1 > 0)
    }

    fn all_ready(&self) -> bool {
        self.line.station_ids().all(|id| self.client.station(id).is_some_and(|state| state.devices_valid))
    }

    /// The mode, and the faults that stand: what was recovered needs no answer any more.
    fn why(&self) -> String {
        let mode = self.client.coordinator().map_or("an unknown mode", |state| &state.text);
        let faults = standing(self.line.stations.iter().zip(self.states()));
        if faults.is_empty() { mode.to_owned() } else { format!("{mode} ({})", faults.join("; ")) }
    }

    /// States of all stations; `None` of one that is not received.
    fn states(&self) -> impl Iterator<Item = Option<&StationState>> {
        self.line.station_ids().map(|id| self.client.station(id))
    }

    /// Gives a command, unless that was a moment ago; whether it does.
    fn say(&mut self, word: &str) -> bool {
        let is_due = self.said.is_none_or(|at| at.elapsed() >= REPEAT);
        if is_due {
            self.said = Some(Instant::now());
            self.client.command(word);
        }
        is_due
    }
}
