//! The live view: mode, stations, bar chart, faults, and what each blocked station waits for; of a flexible cell also parts,
//! production orders, alarms and what is left out.
//!
//! `watch` shows it for a line that runs anywhere; `run` shows the same for the line it has started.

pub mod cell;
pub mod next;

use std::borrow::Cow;
use std::collections::VecDeque;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use clap::Args as ClapArgs;
use crossterm::{cursor, execute, queue, terminal};
use futures::future::LocalBoxFuture;
use linewright_console_view::{
    NextStep, ReasonsByResource, SELECTOR_AT_MANUAL, coordinator_not_received, refusal, station_not_received,
};
use linewright_line::{Line, Station, StationId};
use linewright_msgs::{CellState, LineState, StationEvent, StationState};
use linewright_node_shell::RosArgs;
use miette::IntoDiagnostic;

use crate::cell::CellClient;
use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;
use crate::load;
use crate::recover::NewestPlan;
use crate::run::chart::RollingChart;
use crate::states::LineJson;
use cell::CellWatchJson;

/// Options of `watch`.
#[derive(Debug, ClapArgs)]
pub struct Args {
    /// The directory of a line or cell, or its description file.
    line: PathBuf,
    /// Print one picture and end.
    #[arg(long)]
    once: bool,
    /// Print the states as one JSON object and end.
    #[arg(long)]
    json: bool,
}

/// `linewright watch`
pub async fn run(args: Args, ros: &RosArgs) -> miette::Result<ExitCode> {
    let (line, is_cell) = load::line_or_cell(&args.line)?;
    let mut client = OperatorClient::open(&line, &args.line, ros, "watch")?;
    let mut cell = is_cell.then(|| CellClient::open(&line, ros, "watch_cell")).transpose()?;
    let mut view = WatchState::new(&line);
    if args.once || args.json || !std::io::stdout().is_terminal() {
        return once(&args, &mut client, cell, view).await;
    }
    client.until_connected(HEARD_WITHIN).await?;
    let mut screen = Screen::open()?;
    let mut ticks = tokio::time::interval(PICTURE_EVERY);
    let mut reasons = tokio::time::interval(REASONS_EVERY);
    // A reply is waited for beside the picture.
    let mut asked = AskedReasons::default();
    let mut interrupts = Interrupts::listen()?;
    loop {
        tokio::select! {
            heard = client.next() => drop(view.take(&heard?)),
            heard = next_of(&mut cell) => heard?,
            known = asked.reply() => view.out_of_service = known,
            _ = reasons.tick() => asked.ask(cell.as_ref(), CellClient::state),
            _ = ticks.tick() => {
                view.look(&client, cell.as_ref());
                let state = cell.as_ref().and_then(CellClient::heard_lately);
                screen.show(&view.picture(&client, state, Screen::size()))?;
            }
            () = interrupts.next() => break,
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// One picture, of what is heard now: 1 where something is not.
async fn once(
    args: &Args,
    client: &mut OperatorClient,
    mut cell: Option<CellClient>,
    mut view: WatchState,
) -> miette::Result<ExitCode> {
    view.has_chart = false;
    let is_all = client.until_all_heard(HEARD_WITHIN).await?;
    if let Some(cell) = cell.as_mut().filter(|_| client.coordinator().is_some()) {
        let down = cell.until_heard(HEARD_WITHIN).await?.down.clone();
        view.out_of_service = cell.reasons(down.as_slice().to_vec()).await;
    }
    let until = tokio::time::Instant::now() + client.line().timing.refresh * 4;
    while let Ok(heard) = tokio::time::timeout_at(until, client.next()).await {
        drop(view.take(&heard?));
    }
    view.settle(client, &mut cell).await?;
    let state = cell.as_ref().and_then(CellClient::heard_lately);
    if args.json {
        let cell = state.map(|state| CellWatchJson::of(state, &view.out_of_service));
        crate::out::json(&LineJson::of(client, cell))?;
    } else {
        crate::out::say!("{}", view.picture(client, state, (100, usize::MAX)).join("\n"));
    }
    if !is_all {
        let limit = HEARD_WITHIN.as_secs();
        let coordinator = client.coordinator().is_none().then_some("the coordinator");
        let missing: Vec<&str> = coordinator.into_iter().chain(client.unheard()).collect();
        crate::out::complain!("not heard within {limit} s: {}", missing.join(", "));
    }
    Ok(if is_all { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Waits for a newer state of the cell; for ever of a line.
pub async fn next_of(cell: &mut Option<CellClient>) -> miette::Result<()> {
    match cell {
        Some(cell) => cell.next().await.map(drop),
        None => std::future::pending().await,
    }
}

/// A request for the reasons why resources are left out, while its reply is awaited.
#[derive(Default)]
pub struct AskedReasons(Option<LocalBoxFuture<'static, ReasonsByResource>>);

impl AskedReasons {
    /// Asks for what is down by this state of the cell, unless a reply is awaited.
    pub fn ask(&mut self, cell: Option<&CellClient>, state: fn(&CellClient) -> Option<&CellState>) {
        let Some(cell) = cell.filter(|_| self.0.is_none()) else { return };
        let down = state(cell).map(|state| state.down.as_slice().to_vec()).unwrap_or_default();
        self.0 = Some(Box::pin(cell.reasons(down)));
    }

    /// Waits for the reply; for ever where none is awaited.
    pub async fn reply(&mut self) -> ReasonsByResource {
        let Some(asked) = &mut self.0 else { return std::future::pending().await };
        let known = asked.await;
        self.0 = None;
        known
    }
}

/// Time within which all are to be received.
const HEARD_WITHIN: Duration = Duration::from_secs(5);
/// Often enough for an eye.
pub const PICTURE_EVERY: Duration = Duration::from_millis(100);
/// Period of requests for the reasons why resources are left out.
pub const REASONS_EVERY: Duration = Duration::from_secs(1);
/// Time that the bar chart shows, in s.
const CHART_SECONDS: f64 = 12.0;
/// Number of the last messages shown.
const MESSAGES: usize = 6;
const MESSAGES_TITLE: &str = "events, the newest last:";

/// State of the view beside the newest states.
pub struct WatchState {
    line: Line,
    chart: RollingChart,
    messages: VecDeque<String>,
    /// Lines above the picture, e.g. where the buses are.
    pub head: Vec<String>,
    /// Of a cell: why resources are left out.
    pub out_of_service: ReasonsByResource,
    /// A single picture has none: it would show only what was received while it was made.
    has_chart: bool,
    newest: NewestPlan,
    /// What comes next, where a position is to be confirmed.
    next: Option<NextStep>,
}

/// Seconds since the Unix epoch, as the stamps count them.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
}

impl WatchState {
    /// An empty view.
    pub fn new(line: &Line) -> Self {
        WatchState {
            line: line.clone(),
            chart: RollingChart::new(line),
            messages: VecDeque::new(),
            head: Vec::new(),
            out_of_service: ReasonsByResource::new(),
            has_chart: true,
            newest: NewestPlan::default(),
            next: None,
        }
    }

    /// Adds a line to the last messages.
    pub fn say(&mut self, message: String) {
        self.messages.push_back(message);
        while self.messages.len() > MESSAGES {
            self.messages.pop_front();
        }
    }

    /// Takes an update of the client; gives the message that it adds, if it does.
    pub fn take(&mut self, heard: &StateUpdate) -> Option<String> {
        let StateUpdate::Event(id, event) = heard else { return None };
        let message = self.event(*id, event)?;
        self.say(message.clone());
        Some(message)
    }

    fn event(&mut self, id: StationId, event: &StationEvent) -> Option<String> {
        let at = f64::from(event.header.stamp.sec) + f64::from(event.header.stamp.nanosec) * 1e-9;
        let op = self.line.station(id).operation_named(&event.operation);
        match (event.kind, op) {
            (StationEvent::KIND_STARTED, Some(op)) => self.chart.started(id, op, at, false),
            (StationEvent::KIND_UNDO_STARTED, Some(op)) => self.chart.started(id, op, at, true),
            (StationEvent::KIND_COMPLETED | StationEvent::KIND_UNDONE, Some(op)) => self.chart.ended(id, op, at, false),
            (StationEvent::KIND_FAULT | StationEvent::KIND_STOPPED, Some(op)) => {
                self.chart.ended(id, op, at, true);
                return Some(format!("{} {}", event.station, event.text));
            }
            (StationEvent::KIND_MODE | StationEvent::KIND_IGNORED, _) => {}
            (_, _) => return Some(format!("{} {}", event.station, event.text)),
        }
        None
    }

    /// The picture, as lines of text no wider than the screen. What does not fit its height is left out: first the bar
    /// chart, then the oldest messages, then the head.
    pub fn picture(
        &self,
        client: &OperatorClient,
        cell: Option<&CellState>,
        (width, height): (usize, usize),
    ) -> Vec<String> {
        let shown = |id| {
            client.station(id).map(|state| self.next.as_ref().map_or(Cow::Borrowed(state), |of| of.shown(id, state)))
        };
        let known: Vec<Option<Cow<'_, StationState>>> = self.line.station_ids().map(shown).collect();
        let labels = labels(&self.line, width);
        let stations = labels.iter().zip(&known).map(|(label, state)| (label.as_str(), state.as_deref()));
        let mut states = mode(&self.line.title, client.coordinator(), client.coordinator_unheard_for(), width);
        let next = self.next.iter().flat_map(|next| wrapped(&next.line(), 4, width));
        // Above the empty line.
        states.splice(states.len() - 1..states.len() - 1, next);
        let others = client.other_descriptions();
        states.splice(0..0, others.iter().flat_map(|text| wrapped(text, 4, width)));
        match cell {
            Some(cell) => {
                let is_stopped = client.coordinator().is_some_and(|state| state.mode == StationState::MODE_ESTOP);
                let size = (width, height.saturating_sub(states.len()));
                states.extend(cell::picture(cell, &self.out_of_service, stations, is_stopped, now(), size));
            }
            None => {
                let unheard = self.line.station_ids().map(|id| client.unheard_for(id));
                states.extend(
                    stations.zip(unheard).flat_map(|((label, state), unheard)| station(label, state, unheard, width)),
                );
            }
        }
        let head: Vec<String> = self.head.iter().flat_map(|line| wrapped(line, 4, width)).collect();
        let has_head = head.len() + states.len() < height;
        let room = height - states.len().min(height) - if has_head { head.len() } else { 0 };
        let messages = self.events(width, room.saturating_sub(1));
        let chart = self.bars(width);
        let has_chart = !chart.is_empty() && chart.len() + messages.len() + 2 <= room;
        let mut lines = if has_head { head } else { Vec::new() };
        lines.extend(states);
        for part in [if has_chart { chart } else { Vec::new() }, messages] {
            if !part.is_empty() {
                lines.push(String::new());
                lines.extend(part);
            }
        }
        lines
    }

    /// The last messages below a title, in so many lines at most; none where there are none, or no room.
    fn events(&self, width: usize, room: usize) -> Vec<String> {
        let mut lines: Vec<String> = self.messages.iter().flat_map(|line| wrapped(line, 4, width)).collect();
        lines.drain(..lines.len().saturating_sub(room.saturating_sub(1)));
        if !lines.is_empty() {
            lines.insert(0, MESSAGES_TITLE.to_owned());
        }
        lines
    }

    /// The bar chart; empty as long as nothing has moved, or where there is no width for it.
    fn bars(&self, width: usize) -> Vec<String> {
        let chart_width = width.saturating_sub(self.chart.label_width() + 2).min(160);
        if !self.has_chart || self.chart.is_empty() || chart_width < 10 {
            return Vec::new();
        }
        let mut lines = self.chart.draw(now(), CHART_SECONDS, chart_width);
        lines.push(format!(
            "{:>w$}",
            format!("last {CHART_SECONDS:.0} s ▏now"),
            w = self.chart.label_width() + 2 + chart_width
        ));
        lines
    }
}

/// The mode, with an empty line below it.
pub fn mode(title: &str, line: Option<&LineState>, unheard: Option<Duration>, width: usize) -> Vec<String> {
    let mut lines = match line {
        Some(state) => wrapped(&format!("{title} — mode: {}", state.text), 4, width),
        None => wrapped(&format!("{title}: {}", coordinator_not_received(unheard)), 4, width),
    };
    lines.extend(line.and_then(refusal).into_iter().flat_map(|text| wrapped(&text, 4, width)));
    lines.push(String::new());
    lines
}

/// What each station is called in a picture so wide: its name, which commands need, with its title where that takes no more
/// than a third of the width. All are padded to one width.
fn labels(line: &Line, width: usize) -> Vec<String> {
    let label = |of: &Station| Some(of.label()).filter(|label| label.chars().count() * 3 <= width);
    let labels: Vec<String> = line.stations.iter().map(|of| label(of).unwrap_or_else(|| of.name.clone())).collect();
    let widest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0).max(12);
    labels.into_iter().map(|label| format!("{label:widest$}")).collect()
}

/// A station with its fault and what it waits for.
pub fn station(label: &str, state: Option<&StationState>, unheard: Option<Duration>, width: usize) -> Vec<String> {
    let Some(state) = state else { return vec![format!("{label:12} {}", station_not_received(unheard))] };
    let mut lines = wrapped(&format!("{label:12} cycle {:<4} {}", state.cycle, state.operation), 15, width);
    if state.selector_manual {
        lines.push(format!("{:12} {SELECTOR_AT_MANUAL}", ""));
    }
    if !state.fault.is_empty() {
        lines.extend(wrapped(&format!("{:12} FAULT {}", "", state.fault), 15, width));
    }
    for (number, reason) in state.blocked_by.iter().enumerate() {
        let begins = if number == 0 { "waits for" } else { "and" };
        lines.extend(wrapped(&format!("{:12} {begins} {reason}", ""), 15, width));
    }
    lines
}

/// A text in lines of at most `width` characters, broken at spaces where there are any; the second and later ones are
/// indented.
fn wrapped(text: &str, indent: usize, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut rest: Vec<char> = text.trim_end().chars().collect();
    let mut indent_now = 0;
    while indent_now + rest.len() > width.max(indent + 10) {
        let room = width.max(indent + 10) - indent_now;
        let leading = rest.iter().take_while(|letter| **letter == ' ').count();
        let space = rest[..=room].iter().rposition(|letter| *letter == ' ').filter(|at| *at > leading);
        let (line, next) = rest.split_at(space.unwrap_or(room));
        lines.push(" ".repeat(indent_now) + line.iter().collect::<String>().trim_end());
        rest = next.iter().copied().skip_while(|letter| *letter == ' ').collect();
        indent_now = indent;
    }
    lines.push(" ".repeat(indent_now) + &rest.iter().collect::<String>());
    lines
}

/// The terminal, given back as it was when this is dropped.
pub struct Screen;

impl Screen {
    /// Takes the terminal's alternate screen.
    pub fn open() -> miette::Result<Self> {
        execute!(std::io::stdout(), terminal::EnterAlternateScreen, cursor::Hide).into_diagnostic()?;
        Ok(Screen)
    }

    /// Its width and the height of a picture, in characters.
    pub fn size() -> (usize, usize) {
        terminal::size()
            .map_or((100, 40), |(width, height)| (usize::from(width), usize::from(height).saturating_sub(1)))
    }

    /// Shows a picture; what does not fit is cut.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_picture_has_no_bar_chart() {
        let text = linewright_line::TransferLine::default().text();
        let line = linewright_line::parse("line.toml", &text).expect("parses").line;
        let mut view = WatchState::new(&line);
        let (kind, operation) = (StationEvent::KIND_STARTED, line.stations[0].operations[0].name.clone());
        let mut event = StationEvent { kind, operation, ..StationEvent::default() };
        event.header.stamp.sec = now() as i32;
        view.take(&StateUpdate::Event(StationId(0), event));
        assert!(!view.bars(100).is_empty());
        view.has_chart = false;
        assert!(view.bars(100).is_empty());
    }

    /// What has happened stands apart from what is so now.
    #[test]
    fn the_last_events_stand_below_a_title() {
        let text = linewright_line::TransferLine::default().text();
        let mut view = WatchState::new(&linewright_line::parse("line.toml", &text).expect("parses").line);
        assert!(view.events(60, 10).is_empty());
        ["a", "b", "c"].into_iter().for_each(|event| view.say(event.to_owned()));
        assert_eq!(view.events(60, 10).len(), 4);
        assert_eq!(view.events(60, 3), [MESSAGES_TITLE, "b", "c"]);
        assert!(view.events(60, 1).is_empty() && view.events(60, 0).is_empty());
    }

    #[test]
    fn reasons_are_wrapped_and_whole_at_sixty_columns() {
        let reason = "interlock: transfer not clear: LS_vertical_0 (transfer io, node 11h, 6000h:01 bit 0) off, for advance clamp";
        let clamp = StationState {
            cycle: 12,
            operation: "return clamp".to_owned(),
            fault: "advance clamp: watchdog: motion not complete in time".to_owned(),
            blocked_by: vec!["recovery of advance clamp in manual".to_owned(), reason.to_owned()],
            ..StationState::default()
        };
        let line = LineState { text: "e-stop, not reset; give reset, then manual".to_owned(), ..LineState::default() };
        let stations = [("transfer", None), ("clamp_1", Some(&clamp)), ("mill_1", Some(&clamp))];
        let mut lines = mode("Transfer line", Some(&line), None, 60);
        lines.extend(stations.into_iter().flat_map(|(name, state)| station(name, state, None, 60)));
        assert!(lines.iter().all(|line| line.chars().count() <= 60), "{lines:#?}");
        assert!(lines.len() < 24, "{lines:#?}");
        let whole = lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
        for part in [reason, &clamp.fault, "mode: e-stop, not reset; give reset, then manual"] {
            assert!(whole.contains(part), "{part}: {lines:#?}");
        }
    }

    /// Commands need the name, so that is never left out.
    #[test]
    fn a_title_stands_beside_the_name_where_there_is_room() {
        let text = linewright_line::TransferLine::default().text();
        let mut line = linewright_line::parse("line.toml", &text).expect("parses").line;
        for (station, title) in
            line.stations.iter_mut().zip(["Transfer bar", "Clamp 1", "Milling unit of the right side"])
        {
            station.title = title.to_owned();
        }
        let names = |width| labels(&line, width).iter().map(|label| label.trim_end().to_owned()).collect::<Vec<_>>();
        let [bar, mill] = ["transfer (Transfer bar)", "mill_1 (Milling unit of the right side)"];
        assert_eq!(names(60), ["transfer", "clamp_1", "mill_1"]);
        assert_eq!(names(80), [bar, "clamp_1", "mill_1"], "what says no more than the name is no title");
        assert_eq!(names(120), [bar, "clamp_1", mill]);
        let wide = labels(&line, 120);
        assert!(wide.iter().all(|label| label.chars().count() == mill.len()), "{wide:?}");
        assert_eq!(station(&wide[0], None, None, 120), [format!("{bar:w$} no state received", w = mill.len())]);
    }

    #[test]
    fn a_selector_at_manual_is_shown_in_every_mode() {
        let mut state = StationState::default();
        assert!(!station("mill_1", Some(&state), None, 60).concat().contains("selector"));
        state.selector_manual = true;
        assert_eq!(station("mill_1", Some(&state), None, 60)[1].trim(), "selector at manual");
    }

    #[test]
    fn what_is_not_heard_any_more_is_so_for_how_long() {
        assert_eq!(station("mill_1", None, None, 60), ["mill_1       no state received"]);
        let unheard = Some(Duration::from_millis(12_700));
        assert_eq!(station("mill_1", None, unheard, 60), ["mill_1       no state received for 12 s"]);
        assert_eq!(mode("Line", None, unheard, 60)[0], "Line: no state received from the coordinator for 12 s");
    }

    #[test]
    fn a_refusal_has_an_age() {
        let refusal = "auto refused in manual: transfer: not at home".to_owned();
        let line = LineState { text: "manual".to_owned(), refusal, refusal_age_ms: 12_400, ..LineState::default() };
        let shown = mode("Line", Some(&line), None, 80);
        assert_eq!(shown[1], "last refusal, 12 s ago: auto refused in manual: transfer: not at home");
        assert_eq!(mode("Line", Some(&LineState { refusal: String::new(), ..line }), None, 80).len(), 2);
    }

    #[test]
    fn a_text_is_broken_at_spaces_and_a_long_word_anywhere() {
        assert_eq!(wrapped("  one two three four", 4, 14), ["  one two", "    three four"]);
        assert_eq!(wrapped("abcdefghijklmnopqrst", 2, 14), ["abcdefghijklmn", "  opqrst"]);
        assert_eq!(wrapped("short", 4, 60), ["short"]);
        assert_eq!(wrapped("", 4, 60), [""]);
    }
}
