//! Starting the processes of a line.

use std::path::Path;
use std::time::{Duration, Instant};

use linewright_cell::Cell;
use linewright_fieldbus::BusOptions;
use linewright_line::Line;
use linewright_node_shell::RosArgs;
use linewright_parameters::Override;
use miette::{Context, IntoDiagnostic, miette};

use super::Args;
use super::children::Children;
use crate::can::run_of;
use crate::nodes::{claim_coordinator, claim_station, parameters_of_coordinator, parameters_of_station};

/// Whether the arguments are those of this line or cell, and each node takes the parameters it is given.
pub fn arguments_fit(line: &Line, cell: Option<&Cell>, args: &Args, ros: &RosArgs) -> miette::Result<()> {
    match cell {
        None if !args.parts.is_empty() => return Err(miette!("--parts is for cells; there is no cell.toml")),
        Some(_) if args.cycles.is_some() => return Err(miette!("a cell has no cycles; order parts with --parts")),
        Some(_) | None => {}
    }
    parameters_of_coordinator((line, cell), ros, Some(&args.bus), args.retention)?;
    line.station_ids().try_for_each(|station| parameters_of_station(line, ros, station).map(drop))
}

/// What `check` refuses by structure alone is not started: its arrows do not keep stations apart, or its net is broken.
pub fn structure_holds(line: &Line, file: &Path) -> miette::Result<()> {
    /// More reasons are for `check`.
    const REASONS_MAX: usize = 3;
    let reasons: Vec<String> = crate::check::refusals(line).take(REASONS_MAX).collect();
    if reasons.is_empty() {
        return Ok(());
    }
    let path = crate::out::shell_word(&file.display().to_string());
    Err(miette!(
        help = "`--unchecked` starts it all the same",
        "`linewright check {path}` refuses this line, and nothing was started:\n{}",
        reasons.join("\n")
    ))
}

/// Claims what the nodes are going to claim, and lets go of it: an error names a process that holds any of it already.
pub fn nothing_runs_yet(line: &Line, args: &Args, ros: &RosArgs, bus: &BusOptions) -> miette::Result<()> {
    let state_dir = args.state_dir.as_deref();
    let mut claims = vec![claim_coordinator(line, ros, &args.bus, state_dir, bus)?];
    for station in line.station_ids() {
        claims.push(claim_station(line, ros, station, state_dir, bus)?);
    }
    Ok(())
}

/// Time for the plant to serve its Modbus devices.
const SERVED_WITHIN: Duration = Duration::from_secs(20);
/// Period at which it is looked for them.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Whether a simulated plant can serve the line's Modbus devices: unlike virtual buses their addresses are everybody's.
pub async fn addresses_are_free(line: &Line, args: &Args) -> miette::Result<()> {
    if args.no_plant {
        return Ok(());
    }
    linewright_racks::can_be_served(line).await.map_err(|error| miette!("{error}"))
}

/// Waits until the plant serves all Modbus devices. A manager that comes before may reach those of another run.
async fn until_served(children: &mut Children, line: &Line, ros: &RosArgs) -> miette::Result<()> {
    let (run, began) = (run_of(line, ros)?, Instant::now());
    while !linewright_racks::are_served(line, &run).await {
        children.revive()?;
        if began.elapsed() > SERVED_WITHIN {
            let limit = SERVED_WITHIN.as_secs();
            return Err(miette!("the simulated plant does not serve its Modbus devices within {limit} s"));
        }
        tokio::time::sleep(LOOK_EVERY).await;
    }
    Ok(())
}

/// Starts the plant, the coordinator and the stations.
pub async fn start_all(
    children: &mut Children,
    line: &Line,
    args: &Args,
    ros: &RosArgs,
    dir: &Path,
    virtual_bus: bool,
) -> miette::Result<()> {
    // Nodes find the descriptions as this command does.
    let description = args.line.canonicalize().into_diagnostic()?.display().to_string();
    let state = dir.display().to_string();
    let ros_args = forwarded_ros_args(std::env::args(), kept_files(ros, dir)?);
    let words = |more: &[&str]| -> Vec<String> {
        let mut words: Vec<String> = more.iter().map(|word| (*word).to_owned()).collect();
        words.extend(["--end-with-stdin".to_owned(), description.clone()]);
        words.extend(virtual_bus.then(|| "--virtual-bus".to_owned()));
        words.extend(ros_args.iter().cloned());
        words
    };
    if !args.no_plant {
        // A plant that is started again stands where it stood.
        children.start_plant(words(&["plant", "--of-run", "--bus", &args.bus, "--state-dir", &state]))?;
        until_served(children, line, ros).await?;
    }
    let retention = args.retention.map(|days| days.to_string());
    let mut coordinator = vec!["coordinator", "--bus", &args.bus, "--state-dir", &state];
    coordinator.extend(args.no_autostart.then_some("--no-autostart"));
    coordinator.extend(retention.iter().flat_map(|days| ["--retention", days]));
    children.start("coordinator", words(&coordinator))?;
    for group in line.stations.chunks(args.stations_per_process) {
        let names: Vec<&str> = group.iter().map(|station| station.name.as_str()).collect();
        let mut more = vec!["station", "--state-dir", &state];
        more.extend(args.no_autostart.then_some("--no-autostart"));
        for name in &names {
            more.extend(["--station", name]);
        }
        children.start(&names.join("+"), words(&more))?;
    }
    Ok(())
}

/// Copies of the parameter files as they were checked, in the order given: a node that is started again reads the same, whatever has become
/// of the file.
fn kept_files(ros: &RosArgs, dir: &Path) -> miette::Result<Vec<String>> {
    let texts = ros.params.iter().filter_map(|given| match given {
        Override::File(file) => Some(file.text()),
        Override::Argument(_) => None,
    });
    let keep = |(nth, text): (usize, &str)| {
        let copy = dir.join(format!("parameters-{nth}.yaml"));
        let what = || format!("cannot keep a copy of a parameter file in {}", copy.display());
        std::fs::write(&copy, text).into_diagnostic().wrap_err_with(what)?;
        Ok(copy.display().to_string())
    };
    texts.enumerate().map(keep).collect()
}

/// The ROS arguments among these, for the nodes that are started, with `files` in place of the parameter files.
fn forwarded_ros_args(arguments: impl Iterator<Item = String>, files: Vec<String>) -> Vec<String> {
    let (mut inside, mut files, mut is_file) = (false, files.into_iter(), false);
    let forwarded = |argument: String| {
        inside = (inside && argument != "--") || argument == "--ros-args";
        let argument = if is_file { files.next().unwrap_or(argument) } else { argument };
        is_file = inside && argument == "--params-file";
        inside.then_some(argument)
    };
    // Each stretch begins anew with --ros-args, so that it need not be ended.
    arguments.filter_map(forwarded).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_have_the_ros_arguments_with_copies_of_the_files() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let given = "run c --params-file x --ros-args --params-file a.yaml -p k:=1 --params-file b.yaml -- --json --ros-args -r __ns:=/h";
        let found = forwarded_ros_args(words(given).into_iter(), words("0.yaml 1.yaml"));
        let expected = "--ros-args --params-file 0.yaml -p k:=1 --params-file 1.yaml --ros-args -r __ns:=/h";
        assert_eq!(found, words(expected));
    }
}
