//! `candump`, `can monitor`, `can record` and `can replay`: a bus as a list of frames.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use linewright_canopen::candump::{self, CandumpWriter};
use linewright_canopen::{Frame, describe_frame};
use linewright_fieldbus::Bus;
use linewright_line::Line;
use miette::{IntoDiagnostic, WrapErr, miette};
use tokio::time::{Instant, sleep_until};

use super::{open, since_epoch};
use crate::interrupts::Interrupts;
use crate::load;
use crate::nodes::DEFAULT_BUS;

/// Show the frames of a CAN bus.
#[derive(Debug, Args)]
pub struct DumpArgs {
    /// The CAN interface.
    #[arg(default_value = DEFAULT_BUS)]
    interface: String,
    /// End after this many frames.
    #[arg(short = 'n', long)]
    count: Option<u64>,
}

/// `linewright candump`
pub async fn dump(args: DumpArgs) -> miette::Result<ExitCode> {
    let mut bus = open(&args.interface, None)?;
    let interface = args.interface.as_str();
    each(&mut bus, args.count, |frame| {
        crate::out::line(format_args!("{}", candump::log_line(since_epoch(), interface, frame)))
    })
    .await?;
    Ok(ExitCode::SUCCESS)
}

/// Show every frame with what it means.
#[derive(Debug, Args)]
pub struct MonitorArgs {
    /// A line whose description names the nodes. Of several virtual buses of this name its run's is meant.
    #[arg(long)]
    line: Option<PathBuf>,
    /// End after this many frames.
    #[arg(short = 'n', long)]
    count: Option<u64>,
    /// Leave out heartbeats, and process data without a change.
    #[arg(long)]
    news: bool,
}

impl MonitorArgs {
    /// The line, if one is given.
    pub fn line(&self) -> miette::Result<Option<Line>> {
        self.line.as_ref().map(|path| load::line(path, true)).transpose()
    }
}

pub async fn monitor(
    bus: &mut Bus,
    interface: &str,
    line: Option<&Line>,
    args: &MonitorArgs,
) -> miette::Result<ExitCode> {
    let names = describe_frame::NodeNames::of(line, interface);
    let mut news = describe_frame::ChangeFilter::default();
    each(bus, args.count, |frame| {
        if args.news && !news.is_news(frame) {
            return true;
        }
        let log = candump::log_line(since_epoch(), interface, frame);
        crate::out::line(format_args!("{log:60} {}", describe_frame::describe_frame(frame, &names)))
    })
    .await?;
    Ok(ExitCode::SUCCESS)
}

/// Record the bus.
#[derive(Debug, Args)]
pub struct RecordArgs {
    /// File to write; must not exist.
    file: PathBuf,
    /// End after this many frames.
    #[arg(short = 'n', long)]
    count: Option<u64>,
    /// End after this time, in seconds.
    #[arg(long)]
    seconds: Option<f64>,
}

pub async fn record(bus: &mut Bus, args: &RecordArgs) -> miette::Result<ExitCode> {
    let name = args.file.display();
    let file = File::create_new(&args.file).into_diagnostic().wrap_err_with(|| format!("cannot write {name}"))?;
    let mut recorder = CandumpWriter::new(bus.name(), Box::new(BufWriter::new(file)));
    let end = match args.seconds {
        Some(seconds) => Some(Duration::try_from_secs_f64(seconds).map_err(|error| miette!("--seconds: {error}"))?),
        None => None,
    };
    let mut frames: u64 = 0;
    let recording = each(bus, args.count, |frame| {
        recorder.record(since_epoch(), frame);
        frames += 1;
        recorder.lost() == 0
    });
    match end {
        Some(end) => tokio::time::timeout(end, recording).await.unwrap_or(Ok(()))?,
        None => recording.await?,
    }
    recorder.flush().into_diagnostic().wrap_err_with(|| format!("cannot write {name}"))?;
    if recorder.lost() > 0 {
        return Err(miette!("{name} takes no more; {} frames are in it", frames - recorder.lost()));
    }
    crate::out::say!("{frames} frames in {name}");
    let overruns = bus.stats().overruns;
    if overruns > 0 {
        crate::out::complain!("the kernel dropped frames {overruns} times before they were recorded");
    }
    Ok(ExitCode::SUCCESS)
}

/// Send what was recorded.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// A log in the form of `candump -L`.
    file: PathBuf,
    /// Interface whose frames are sent [default: all].
    #[arg(long)]
    from: Option<String>,
    /// Factor on the recorded speed.
    #[arg(long, default_value_t = 1.0)]
    speed: f64,
}

pub async fn replay(bus: &mut Bus, args: &ReplayArgs) -> miette::Result<ExitCode> {
    if !(args.speed > 0.0 && args.speed.is_finite()) {
        return Err(miette!("--speed {} is no speed; 1 is as recorded", args.speed));
    }
    // All of it is read before the first frame is sent: half a recording may leave something running.
    let frames = recorded(&args.file, args.from.as_deref())?;
    let Some((begin, _)) = frames.first() else {
        return Err(miette!(
            "{} has no frame{}",
            args.file.display(),
            match &args.from {
                Some(from) => format!(" of {from}"),
                None => String::new(),
            }
        ));
    };
    let start = Instant::now();
    let mut interrupts = Interrupts::listen()?;
    let mut sent: u64 = 0;
    for (stamp, frame) in &frames {
        // A log whose clock was set back continues at once.
        let after = stamp.saturating_sub(*begin).div_f64(args.speed);
        tokio::select! {
            () = sleep_until(start + after) => {}
            () = interrupts.next() => break,
        }
        bus.send(frame);
        sent += 1;
    }
    crate::out::say!("{sent} of {} frames sent in {:.3} s", frames.len(), start.elapsed().as_secs_f64());
    let refused = bus.stats().send_errors;
    if refused > 0 {
        crate::out::complain!("{refused} frames not sent: no acknowledge on the bus, or transmit queue full");
    }
    Ok(if refused == 0 && sent == frames.len() as u64 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The frames of a log, those of the interface `from` if one is named; or the place of the first line that is none.
fn recorded(path: &Path, from: Option<&str>) -> miette::Result<Vec<(Duration, Frame)>> {
    let name = path.display();
    let file = File::open(path).into_diagnostic().wrap_err_with(|| format!("cannot read {name}"))?;
    let mut frames = Vec::new();
    for (number, line) in BufReader::new(file).lines().enumerate() {
        let line = line.into_diagnostic().wrap_err_with(|| format!("cannot read {name}"))?;
        if line.trim().is_empty() {
            continue;
        }
        let (stamp, interface, frame) =
            candump::parse_log_line(&line).map_err(|error| miette!("{name}:{}: {error}", number + 1))?;
        if from.is_none_or(|from| from == interface) {
            frames.push((stamp, frame));
        }
    }
    Ok(frames)
}

/// Time after which a bus without a frame is remarked on: a manager sends its heartbeat more often.
const SILENT: Duration = Duration::from_secs(2);

/// A bus on which nothing is received.
fn silence(bus: &Bus) -> String {
    let why = if bus.is_virtual() {
        "no process has it, or none sends; a line that was started with another LINEWRIGHT_BUS_DIR, in another ROS domain or with another \
         --bus has another one"
    } else {
        "no node sends, or the interface has another bit rate than they have"
    };
    format!("nothing was received in {} s on {}: {why}", SILENT.as_secs(), bus.describe())
}

/// Calls `take` with each frame received: until `count` frames, `false` from `take`, or Ctrl-C. Prints one remark if no frame is
/// received within `SILENT`.
async fn each(bus: &mut Bus, count: Option<u64>, mut take: impl FnMut(&Frame) -> bool) -> miette::Result<()> {
    let mut interrupts = Interrupts::listen()?;
    let mut left = count.unwrap_or(u64::MAX);
    let (silent_at, mut is_silent) = (Instant::now() + SILENT, true);
    while left > 0 {
        let frame = tokio::select! {
            frame = bus.recv() => frame.into_diagnostic()?,
            () = interrupts.next() => break,
            () = sleep_until(silent_at), if is_silent => {
                crate::out::complain!("{}", silence(bus));
                is_silent = false;
                continue;
            }
        };
        is_silent = false;
        if !take(&frame) {
            break;
        }
        left -= 1;
    }
    Ok(())
}
