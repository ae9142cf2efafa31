//! The live view: mode, stations, bar chart, faults, and what each blocked station waits for.
//!
//! `watch` shows it for a line that runs anywhere; `run` shows the same for the line it has started.

use std::collections::VecDeque;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::Args as ClapArgs;
use crossterm::{cursor, execute, queue, terminal};
use linewright_line::{Line, StationId};
use linewright_msgs::StationEvent;
use linewright_node_shell::RosArgs;
use miette::IntoDiagnostic;

use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;
use crate::load;
use crate::run::chart::RollingChart;

/// Show the line as it runs.
#[derive(Debug, ClapArgs)]
pub struct Args {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Print one picture and end.
    #[arg(long)]
    once: bool,
}

/// `linewright watch`
pub async fn run(args: Args, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let mut client = OperatorClient::open(&line, ros, "watch")?;
    client.until_connected(Duration::from_secs(5)).await?;
    let mut view = WatchState::new(&line);
    if args.once || !std::io::stdout().is_terminal() {
        let until = tokio::time::Instant::now() + line.timing.refresh * 4;
        while let Ok(heard) = tokio::time::timeout_at(until, client.next()).await {
            view.take(&heard?);
        }
        crate::out::say!("{}", view.picture(&client, 100).join("\n"));
        return Ok(ExitCode::SUCCESS);
    }
    let mut screen = Screen::open()?;
    let mut ticks = tokio::time::interval(PICTURE_EVERY);
    let mut interrupts = Interrupts::listen()?;
    loop {
        tokio::select! {
            heard = client.next() => view.take(&heard?),
            _ = ticks.tick() => screen.show(&view.picture(&client, Screen::width()))?,
            () = interrupts.next() => break,
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Often enough for an eye.
pub const PICTURE_EVERY: Duration = Duration::from_millis(100);
/// How much time the bar chart shows.
const CHART_SECONDS: f64 = 12.0;
/// How many of the last messages are shown.
const MESSAGES: usize = 6;

/// What the view remembers beside the newest states.
pub struct WatchState {
    line: Line,
    chart: RollingChart,
    messages: VecDeque<String>,
    /// Lines above the picture, e.g. where the buses are.
    pub head: Vec<String>,
}

/// Seconds since the Unix epoch, as the stamps count them.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
}

impl WatchState {
    /// An empty view.
    pub fn new(line: &Line) -> Self {
        WatchState { line: line.clone(), chart: RollingChart::new(line), messages: VecDeque::new(), head: Vec::new() }
    }

    /// Adds a line to the last messages.
    pub fn say(&mut self, message: String) {
        self.messages.push_back(message);
        while self.messages.len() > MESSAGES {
            self.messages.pop_front();
        }
    }

    /// Takes what the client heard.
    pub fn take(&mut self, heard: &StateUpdate) {
        if let StateUpdate::Event(id, event) = heard {
            self.event(*id, event);
        }
    }

    fn event(&mut self, id: StationId, event: &StationEvent) {
        let at = f64::from(event.header.stamp.sec) + f64::from(event.header.stamp.nanosec) * 1e-9;
        let op = self.line.station(id).operation_named(&event.operation);
        match (event.kind, op) {
            (StationEvent::KIND_STARTED, Some(op)) => self.chart.started(id, op, at, false),
            (StationEvent::KIND_UNDO_STARTED, Some(op)) => self.chart.started(id, op, at, true),
            (StationEvent::KIND_COMPLETED | StationEvent::KIND_UNDONE, Some(op)) => self.chart.ended(id, op, at, false),
            (StationEvent::KIND_FAULT | StationEvent::KIND_STOPPED, Some(op)) => {
                self.chart.ended(id, op, at, true);
                self.say(format!("{} {}", event.station, event.text));
            }
            (StationEvent::KIND_MODE | StationEvent::KIND_IGNORED, _) => {}
            (_, _) => self.say(format!("{} {}", event.station, event.text)),
        }
    }

    /// The picture, as lines of text.
    pub fn picture(&self, client: &OperatorClient, width: usize) -> Vec<String> {
        let mut lines = self.head.clone();
        match client.coordinator() {
            Some(state) => {
                lines.push(format!("{} — mode: {}", self.line.title, state.text));
                if !state.refusal.is_empty() {
                    lines.push(format!("last refusal: {}", state.refusal));
                }
            }
            None => lines.push(format!("{}: no state received from the coordinator", self.line.title)),
        }
        lines.push(String::new());
        for id in self.line.station_ids() {
            lines.extend(self.station(client, id));
        }
        // One picture (`watch --once`) has seen too little for a chart.
        if !self.chart.is_empty() {
            lines.push(String::new());
            let chart_width = width.saturating_sub(48).clamp(20, 160);
            lines.extend(self.chart.draw(now(), CHART_SECONDS, chart_width));
            lines.push(format!("{:>w$}", format!("last {CHART_SECONDS:.0} s ▏now"), w = chart_width + 44));
        }
        lines.push(String::new());
        lines.extend(self.messages.iter().cloned());
        lines
    }

    fn station(&self, client: &OperatorClient, id: StationId) -> Vec<String> {
        let name = &self.line.station(id).name;
        let Some(state) = client.station(id) else { return vec![format!("{name:12} no state received")] };
        let mut lines = vec![format!("{name:12} cycle {:<4} {}", state.cycle, state.operation)];
        if !state.fault.is_empty() {
            lines.push(format!("{:12} FAULT {}", "", state.fault));
        }
        if !state.blocked_by.is_empty() {
            lines.push(format!("{:12} waits for {}", "", state.blocked_by.join("; ")));
        }
        lines
    }
}

/// The terminal, given back as it was when this is dropped.
pub struct Screen;

impl Screen {
    /// Takes the terminal's alternate screen.
    pub fn open() -> miette::Result<Self> {
        execute!(std::io::stdout(), terminal::EnterAlternateScreen, cursor::Hide).into_diagnostic()?;
        Ok(Screen)
    }

    /// Its width in characters.
    pub fn width() -> usize {
        terminal::size().map_or(100, |(width, _)| usize::from(width))
    }

    /// Shows a picture; lines that do not fit are cut.
    pub fn show(&mut self, lines: &[String]) -> miette::Result<()> {
        let (width, height) = terminal::size().unwrap_or((100, 40));
        let mut out = std::io::stdout().lock();
        queue!(out, cursor::MoveTo(0, 0)).into_diagnostic()?;
        for line in lines.iter().take(usize::from(height).saturating_sub(1)) {
            let shown: String = line.chars().take(usize::from(width)).collect();
            write!(out, "{shown}").into_diagnostic()?;
            queue!(out, terminal::Clear(terminal::ClearType::UntilNewLine), cursor::MoveToNextLine(1))
                .into_diagnostic()?;
        }
        queue!(out, terminal::Clear(terminal::ClearType::FromCursorDown)).into_diagnostic()?;
        out.flush().into_diagnostic()
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = execute!(std::io::stdout(), cursor::Show, terminal::LeaveAlternateScreen);
    }
}
