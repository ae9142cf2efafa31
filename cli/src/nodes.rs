//! The long-running subcommands: `station`, `coordinator` and `plant`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use linewright_cell::Cell;
use linewright_coordinator_shell::parameters::{CAN_INTERFACE, coordinator_parameters, names};
use linewright_fieldbus::{BusOptions, Clock, Transport, place};
use linewright_line::{DeviceBus, Line, StationId};
use linewright_node_shell::{
    Claim, ClaimError, LOG_LEVEL_NAME, LogLevel, Participant, RosArgs, level_at_start, set_log_level,
};
use linewright_parameters::{OverrideError, ParameterSet, apply};
use linewright_station_shell::parameters::station_parameters;
use miette::miette;
use tokio::sync::watch;

use crate::load;

/// What every node takes.
#[derive(Debug, Args)]
pub struct Common {
    /// The line's directory, or its description file.
    pub line: PathBuf,
    /// Keep the journal in this directory, and go on from it after a restart; of the simulated plant its positions.
    #[arg(long)]
    pub state_dir: Option<PathBuf>,
    /// Use a virtual bus, between processes of this machine, where there is no CAN interface of a bus's name. Without this a
    /// missing interface is an error.
    #[arg(long)]
    virtual_bus: bool,
    /// End when standard input ends, so that no node outlives its supervisor.
    #[arg(long, hide = true)]
    pub end_with_stdin: bool,
}

impl Common {
    fn bus(&self) -> BusOptions {
        let transport = if self.virtual_bus { Transport::Auto } else { Transport::SocketCan };
        BusOptions { transport, ..BusOptions::default() }
    }
}

/// Run the node of one or more stations.
#[derive(Debug, Args)]
pub struct StationArgs {
    #[command(flatten)]
    common: Common,
    /// Name of the station; repeat it to host several in this process.
    #[arg(long = "station", required = true)]
    stations: Vec<String>,
    /// Wait for the transitions configure and activate of a lifecycle manager, or of `ros2 lifecycle set`; without this the node is active
    /// at once.
    #[arg(long)]
    no_autostart: bool,
}

/// Run the coordinator's node.
#[derive(Debug, Args)]
pub struct CoordinatorArgs {
    #[command(flatten)]
    common: Common,
    /// The CAN interface of the line's bus. The ROS parameter can_interface_name does the same.
    #[arg(long)]
    bus: Option<String>,
    /// Run a flexible cell without a state directory: its orders, parts and alarms are lost when this process ends.
    #[arg(long, conflicts_with = "state_dir")]
    forget: bool,
    /// Days for which the database keeps what happens; without this everything is kept.
    #[arg(long, value_name = "DAYS", value_parser = clap::value_parser!(u32).range(1..=36_500))]
    retention: Option<u32>,
    /// Wait for the transitions configure and activate of a lifecycle manager, or of `ros2 lifecycle set`; without this the node is active
    /// at once.
    #[arg(long)]
    no_autostart: bool,
}

/// Days as a duration.
fn days(days: u32) -> Duration {
    Duration::from_secs(u64::from(days) * 86_400)
}

/// Run the simulated plant.
#[derive(Debug, Args)]
pub struct PlantArgs {
    #[command(flatten)]
    common: Common,
    /// The CAN interface of the line's bus.
    #[arg(long, default_value = DEFAULT_BUS)]
    bus: String,
    /// It is part of a run of its line, and its Modbus devices name that.
    #[arg(long, hide = true)]
    of_run: bool,
}

/// The default CAN interface of the line's bus.
pub const DEFAULT_BUS: &str = "vcan0";

/// Claims what a node must have alone on this machine: its name in the ROS domain, the bus it manages, if it does, which commands
/// then find by the line, and its journal. As long as this is held, the next claim to the same is refused.
fn claim(
    line: &Line,
    ros: &RosArgs,
    name: &str,
    interface: Option<&str>,
    state_dir: Option<&Path>,
    bus: &BusOptions,
) -> miette::Result<Vec<Claim>> {
    let refused = |error: ClaimError| miette!("{error}");
    let namespace = format!("/{}", line.name);
    let mut claims = vec![Claim::node(ros, &namespace, name).map_err(refused)?];
    if let Some(interface) = interface {
        let place = place(interface, bus);
        claims.push(Claim::bus(&place).map_err(refused)?);
        claims.push(Claim::managed_bus(ros, (&namespace, name), interface, &place).map_err(refused)?);
    }
    if let Some(dir) = state_dir {
        claims.push(claim_file(dir, name)?);
    }
    Ok(claims)
}

/// Claims the files of `name` in a state directory, which is made if it is not there. What this process writes is its owner's alone.
fn claim_file(dir: &Path, name: &str) -> miette::Result<Claim> {
    crate::files::keep_from_others();
    std::fs::create_dir_all(dir).map_err(|error| crate::files::cannot_use(dir, &error))?;
    Claim::file(dir, name).map_err(|error| miette!("{error}"))
}

/// The claims of a station's node.
pub fn claim_station(
    line: &Line,
    ros: &RosArgs,
    station: StationId,
    state_dir: Option<&Path>,
    bus: &BusOptions,
) -> miette::Result<Vec<Claim>> {
    let station = line.station(station);
    let interface = match &station.bus {
        DeviceBus::Line => None,
        DeviceBus::Own(interface) => Some(interface.as_str()),
    };
    claim(line, ros, &station.name, interface, state_dir, bus)
}

/// The claims of the coordinator's node.
pub fn claim_coordinator(
    line: &Line,
    ros: &RosArgs,
    interface: &str,
    state_dir: Option<&Path>,
    bus: &BusOptions,
) -> miette::Result<Vec<Claim>> {
    claim(line, ros, "coordinator", Some(interface), state_dir, bus)
}

/// The parameters of a station's node, as it is started with them.
pub fn parameters_of_station(line: &Line, ros: &RosArgs, station: StationId) -> miette::Result<ParameterSet> {
    let given = station_parameters(line, station, level_at_start(ros.log_level));
    started_with(line, ros, &line.station(station).name, given)
}

/// The parameters of the coordinator's node, as it is started with them. `bus` is that of the command line.
pub fn parameters_of_coordinator(
    (line, cell): (&Line, Option<&Cell>),
    ros: &RosArgs,
    bus: Option<&str>,
    retention: Option<u32>,
) -> miette::Result<ParameterSet> {
    let (level, interface) = (level_at_start(ros.log_level), bus.unwrap_or(DEFAULT_BUS));
    let given = coordinator_parameters(line, cell, level, interface, retention);
    let set = started_with(line, ros, "coordinator", given)?;
    match (bus, set.text(CAN_INTERFACE.name)) {
        (Some(bus), Some(other)) if bus != other => Err(miette!(
            help = "give it by --bus; the parameter sets it only for `linewright coordinator` without --bus",
            "the bus is '{bus}' by --bus (vcan0 where `run` is not given one), and '{other}' by the parameter {}",
            CAN_INTERFACE.name
        )),
        _ => Ok(set),
    }
}

/// Parameters with the values that files and arguments give them.
fn started_with(line: &Line, ros: &RosArgs, name: &str, mut set: ParameterSet) -> miette::Result<ParameterSet> {
    let full = ros.node_name(&format!("/{}", line.name), name).map_err(|error| miette!("node name: {error}"))?;
    let warnings = apply(&mut set, &ros.params, &full, &names()).map_err(|error| match error {
        OverrideError::File(problems) => miette::Report::new(*problems).wrap_err(format!("parameters of {full}")),
        argument => miette!("parameters of {full}: {argument}"),
    })?;
    warnings.iter().for_each(|warning| tracing::warn!("{warning}"));
    Ok(set)
}

/// Puts the log level of a parameter into force, unless it is the one that the process has been started with.
fn follow_log_level(set: &ParameterSet, ros: &RosArgs) {
    let name = set.text(LOG_LEVEL_NAME).filter(|name| *name != level_at_start(ros.log_level));
    if let Some(level) = name.and_then(LogLevel::named) {
        set_log_level(level);
    }
}

fn runtime() -> miette::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| miette!("cannot start the runtime: {error}"))
}

/// Turns true on Ctrl-C, on SIGTERM, or when standard input ends, if `end_with_stdin`.
fn stop_signal(end_with_stdin: bool) -> watch::Receiver<bool> {
    let (stop, stopped) = watch::channel(false);
    if end_with_stdin {
        let stop = stop.clone();
        // A thread, because reading standard input cannot be cancelled; it ends with the process.
        std::thread::spawn(move || {
            let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
            let _ = stop.send(true);
        });
    }
    tokio::spawn(async move {
        terminated().await;
        let _ = stop.send(true);
        std::future::pending::<()>().await;
    });
    stopped
}

async fn terminated() {
    use tokio::signal::unix::{SignalKind, signal};
    match signal(SignalKind::terminate()) {
        Ok(mut term) => {
            tokio::select! {
                _ = tokio::signal::ctrl_c() => {}
                _ = term.recv() => {}
            }
        }
        Err(_) => {
            let _ = tokio::signal::ctrl_c().await;
        }
    }
}

/// `linewright station`
pub fn station(args: StationArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.common.line, true)?;
    let mut stations: Vec<StationId> = Vec::new();
    for name in &args.stations {
        let id = load::station(&line, name)?;
        if !stations.contains(&id) {
            stations.push(id);
        }
    }
    let state_dir = args.common.state_dir.as_deref();
    let parameters = |&id: &StationId| parameters_of_station(&line, ros, id);
    let parameters = stations.iter().map(parameters).collect::<miette::Result<Vec<_>>>()?;
    parameters.iter().for_each(|set| follow_log_level(set, ros));
    let claim = |&id: &StationId| claim_station(&line, ros, id, state_dir, &BusOptions::default());
    let _claims = stations.iter().map(claim).collect::<miette::Result<Vec<_>>>()?;
    runtime()?.block_on(async {
        let stop = stop_signal(args.common.end_with_stdin);
        let clock = Clock::start();
        // Each station has a participant of its own: on the loopback address nodes that share one do not receive each
        // other. The DDS library answers there to a datagram's source, and has no address for itself.
        let open = |_: &StationId| Participant::open(ros).map_err(|error| miette!("{error}"));
        let participants = stations.iter().map(open).collect::<miette::Result<Vec<_>>>()?;
        let nodes =
            stations.into_iter().zip(parameters).zip(&participants).map(|((station, parameters), participant)| {
                let options = linewright_station_node::StationOptions {
                    line: line.clone(),
                    station,
                    state_dir: args.common.state_dir.clone(),
                    bus: args.common.bus(),
                    clock,
                    parameters,
                    autostart: !args.no_autostart,
                };
                linewright_station_node::run(options, participant, stop.clone())
            });
        // One station's failure ends the process, and with it all of them: a supervisor restarts it whole.
        futures::future::try_join_all(nodes).await.map_err(|error| miette!("{error}"))
    })?;
    Ok(ExitCode::SUCCESS)
}

/// `linewright coordinator`
pub fn coordinator(args: CoordinatorArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.common.line, true)?;
    let cell = load::cell_of(&args.common.line, &line)?;
    if let Some(cell) = cell.as_ref().filter(|_| args.common.state_dir.is_none() && !args.forget) {
        return Err(miette!(
            help = "--state-dir DIR keeps them, --forget runs the cell without",
            "cell '{}' has no state directory: its orders, parts and alarms would be lost when this process ends",
            cell.name
        ));
    }
    let bus = args.bus.as_deref();
    let parameters = parameters_of_coordinator((&line, cell.as_ref()), ros, bus, args.retention)?;
    follow_log_level(&parameters, ros);
    let interface = parameters.text(CAN_INTERFACE.name).unwrap_or(DEFAULT_BUS).to_owned();
    let _claims = claim_coordinator(&line, ros, &interface, args.common.state_dir.as_deref(), &BusOptions::default())?;
    runtime()?.block_on(async {
        let stop = stop_signal(args.common.end_with_stdin);
        let participant = Participant::open(ros).map_err(|error| miette!("{error}"))?;
        let options = linewright_coordinator_node::CoordinatorOptions {
            line,
            cell,
            interface,
            state_dir: args.common.state_dir.clone(),
            retention: args.retention.map(days),
            bus: args.common.bus(),
            clock: Clock::start(),
            parameters,
            autostart: !args.no_autostart,
        };
        linewright_coordinator_node::run(options, &participant, stop).await.map_err(|error| miette!("{error}"))
    })?;
    Ok(ExitCode::SUCCESS)
}

/// `linewright plant`
pub fn plant(args: PlantArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.common.line, true)?;
    let run = args.of_run.then(|| crate::can::run_of(&line, ros)).transpose()?;
    let _claim = args.common.state_dir.as_deref().map(|dir| claim_file(dir, "plant")).transpose()?;
    runtime()?.block_on(async {
        let mut stop = stop_signal(args.common.end_with_stdin);
        let options = linewright_racks::RackOptions {
            line_bus: args.bus.clone(),
            bus: args.common.bus(),
            plant: linewright_plant::PlantOptions { people: true, ..Default::default() },
            clock: Clock::start(),
            // Of a run: it reads them from standard output.
            mishap: args.of_run.then_some(|text: &str| crate::out::say!("{text}")),
            run,
        };
        let stopped = async {
            let _ = stop.wait_for(|stop| *stop).await;
        };
        let keep = args.common.state_dir.as_deref();
        linewright_racks::run_plant(&line, &options, keep, stopped).await.map_err(|error| miette!("{error}"))
    })?;
    Ok(ExitCode::SUCCESS)
}
