//! `linewright diagnostics`: the parameter file of `diagnostic_aggregator` for a line.

use std::path::PathBuf;
use std::process::ExitCode;

use linewright_coordinator_shell::coordinator_checks;
use linewright_node_line::aggregator_file;

use crate::load;

/// Print the parameter file by which diagnostic_aggregator of ROS 2 groups the diagnostics of a line.
#[derive(Debug, clap::Args)]
#[command(after_help = "ros2 run diagnostic_aggregator aggregator_node --ros-args --params-file FILE")]
pub struct Args {
    /// The directory of a line or cell, or its description file.
    line: PathBuf,
}

/// `linewright diagnostics`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let (line, is_cell) = load::line_or_cell(&args.line)?;
    crate::out::bytes(aggregator_file(&line, coordinator_checks(is_cell)).as_bytes());
    Ok(ExitCode::SUCCESS)
}
