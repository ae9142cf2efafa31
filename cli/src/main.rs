//! The `linewright` command: describe, check, run and operate a production line.
//!
//! Each subcommand is a module. This file parses the command line, sets up what all of them share, and turns an error
//! into words and an exit code: 0 done, 1 it could not be done, 2 the command line is wrong.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod analyse;
mod can;
mod cell;
mod chart;
mod check;
mod client;
mod console;
mod deploy;
mod described;
mod devices;
mod diagnostics;
mod expand;
mod files;
mod frames;
mod interface;
mod interrupts;
mod io;
mod load;
mod nets;
mod new;
mod nodes;
mod operate;
mod out;
mod parts;
mod recover;
mod report;
mod run;
mod schema;
mod shell;
mod simulate;
mod states;
mod synthesise;
mod watch;

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use linewright_node_shell::{ArgsError, RosArgs, init_logging};

/// Describe, check, run and operate a production line.
#[derive(Debug, Parser)]
#[command(
    name = "linewright",
    version = env!("LINEWRIGHT_VERSION"),
    about,
    after_help = "ROS 2 arguments go behind --ros-args, e.g. --ros-args -r __ns:=/hall_2 --log-level debug."
)]
struct Cli {
    #[command(subcommand)]
    command: CliCommand,
}

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Write the description of a new line or cell.
    New(new::Args),
    /// Check a description: text, structure, and all behaviour of its controllers together; of a cell also deadlocks.
    Check(check::Args),
    /// Print the description of a line with every station of a type written out.
    Expand(expand::Args),
    /// Write the I/O list of a line as CSV, or put one into its description: export, import.
    Io(io::Args),
    /// Write the nets of a line: one of each station, and the mode decision's; and those of a flexible cell.
    Nets(nets::Args),
    /// Analyse a place/transition net: bounded, live, reversible, deadlocks, invariants.
    Analyse(analyse::Args),
    /// Synthesise a supervisor from relations of operations: added predecessors with reasons, coordinated operations,
    /// contradictions.
    Synthesise(synthesise::Args),
    /// Simulate a line by its own controllers, or a cell, in virtual time: bar chart, cycle time, faults; figures of a
    /// cell with confidence intervals.
    Simulate(simulate::Args),
    /// Report on a line or a flexible cell from its database: times of resources, times of parts, lateness of orders.
    Report(report::Args),
    /// Run a whole line on this machine, with simulated devices.
    Run(run::Args),
    /// Run the node of one or more stations.
    Station(nodes::StationArgs),
    /// Run the coordinator's node.
    Coordinator(nodes::CoordinatorArgs),
    /// Run the simulated plant: every device of the line as a CAN node.
    Plant(nodes::PlantArgs),
    /// Give an operator's command: start, stop, auto, hand, manual, estop or reset.
    Mode(operate::ModeArgs),
    /// Hold hand-mode buttons, or a station's panel buttons, for a while.
    Press(operate::PressArgs),
    /// Confirm the position of a station that has lost its memory: by its switches, or in a named operation.
    Rejoin(operate::RejoinArgs),
    /// Show what has to be done, step by step, until the line is in auto again.
    Recover(recover::Args),
    /// Cause or clear a fault of a simulated mechanism or device.
    Fail(can::FailArgs),
    /// Take a part out of the simulated plant, or put one in, as a person does by hand.
    Part(can::PartArgs),
    /// Submit, list, cancel or withdraw production orders of a running cell.
    Order(cell::OrderArgs),
    /// Show why a line, a part, a production order or a resource does not go on.
    Why(cell::WhyArgs),
    /// Answer an alarm of a running cell, or show those that stand.
    Answer(cell::AnswerArgs),
    /// Show the resources of a running cell that are out of service; stop one, put it out of service or back, or reset
    /// its station.
    Resource(cell::ResourceArgs),
    /// Show a line or a cell as it runs.
    Watch(watch::Args),
    /// Show a running line in a browser on this machine.
    Console(console::Args),
    /// Inspect and command the nodes of a CAN bus: scan, status, nmt, sdo, monitor, record, replay.
    Can(can::CanArgs),
    /// Print the file by which diagnostic_aggregator of ROS 2 groups the diagnostics of a line.
    Diagnostics(diagnostics::Args),
    /// List the ROS 2 messages, services and actions of a line with their type hashes, or show one.
    Interface(interface::Args),
    /// Write for each host of a line what is to be installed on it: description, services and their settings.
    Deploy(deploy::Args),
    /// Print the JSON schema of a description, for editors: line, cell, relations or scenario.
    Schema(schema::Args),
    /// Print the completion script of a shell: bash, elvish, fish, powershell or zsh.
    Completions(shell::CompletionsArgs),
    /// Write the manual pages of this command into a directory.
    Man(shell::ManArgs),
    /// Show the frames of a CAN bus, virtual or not, as candump -L does.
    Candump(can::DumpArgs),
}

fn main() -> ExitCode {
    let code = command();
    let code = match out::finish() {
        Ok(()) => code,
        Err(why) => {
            crate::out::complain!("linewright: cannot write to standard output: {why}");
            ExitCode::FAILURE
        }
    };
    linewright_node_shell::flush_stderr();
    code
}

fn command() -> ExitCode {
    let (ros, rest) = match RosArgs::from_process() {
        Ok(parsed) => parsed,
        Err(ArgsError::InParamsFile(problems)) => {
            crate::out::complain!("{:?}", miette::Report::new(*problems));
            return ExitCode::from(2);
        }
        Err(error) => {
            crate::out::complain!("linewright: {error}");
            return ExitCode::from(2);
        }
    };
    let program = std::env::args().next().unwrap_or_else(|| "linewright".to_owned());
    let parsed = numbers_as_values(Cli::command()).try_get_matches_from(std::iter::once(program).chain(rest));
    let cli = match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        // Help and the version are no errors, and go to standard output.
        Err(shown) if !shown.use_stderr() => {
            let text = shown.render();
            let is_terminal = std::io::stdout().is_terminal();
            out::bytes(if is_terminal { text.ansi().to_string() } else { text.to_string() }.as_bytes());
            return ExitCode::SUCCESS;
        }
        Err(wrong) => {
            let text = wrong.render();
            let is_terminal = std::io::stderr().is_terminal();
            let text = if is_terminal { text.ansi().to_string() } else { text.to_string() };
            crate::out::complain!("{}", number_errors(&text).trim_end());
            return ExitCode::from(2);
        }
    };
    match dispatch(cli.command, ros) {
        Ok(code) => code,
        Err(error) => {
            crate::out::complain!("{error:?}");
            if error.is::<load::WrongArgument>() { ExitCode::from(2) } else { ExitCode::FAILURE }
        }
    }
}

/// The command with arguments that take a negative number as their value: that is refused by its bounds, and is no unknown option.
fn numbers_as_values(command: clap::Command) -> clap::Command {
    let takes = |arg: clap::Arg| {
        if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg }
    };
    command.mut_args(takes).mut_subcommands(numbers_as_values)
}

/// Error of the argument parser about a number, with the expected form in its place.
fn number_errors(text: &str) -> String {
    [
        ("invalid float literal", "expected a number, without a unit, e.g. 0.8"),
        ("invalid digit found in string", "expected a whole number, 0 or more, without a unit"),
        ("number too large to fit in target type", "the number is too large"),
        ("cannot parse integer from empty string", "expected a whole number"),
        ("cannot parse float from empty string", "expected a number, e.g. 0.8"),
    ]
    .into_iter()
    .fold(text.to_owned(), |text, (is, should)| text.replace(is, should))
}

fn dispatch(command: CliCommand, ros: RosArgs) -> miette::Result<ExitCode> {
    match command {
        CliCommand::New(args) => new::run(&args),
        CliCommand::Check(args) => check::run(&args),
        CliCommand::Expand(args) => expand::run(&args),
        CliCommand::Io(args) => io::run(&args),
        CliCommand::Nets(args) => nets::run(&args),
        CliCommand::Analyse(args) => analyse::run(&args),
        CliCommand::Synthesise(args) => synthesise::run(&args),
        CliCommand::Simulate(args) => simulate::run(&args),
        CliCommand::Report(args) => report::run(&args),
        CliCommand::Run(args) => asynchronous(async move { run::run(args, ros).await }),
        CliCommand::Station(args) => logged(&ros, || nodes::station(args, &ros)),
        CliCommand::Coordinator(args) => logged(&ros, || nodes::coordinator(args, &ros)),
        CliCommand::Plant(args) => logged(&ros, || nodes::plant(args, &ros)),
        CliCommand::Mode(args) => asynchronous(async move { operate::mode(args, &ros).await }),
        CliCommand::Rejoin(args) => asynchronous(async move { operate::rejoin(args, &ros).await }),
        CliCommand::Recover(args) => asynchronous(async move { recover::run(args, &ros).await }),
        CliCommand::Press(args) => asynchronous(async move { operate::press(args, &ros).await }),
        CliCommand::Fail(args) => asynchronous(async move { can::fail(args, &ros).await }),
        CliCommand::Part(args) => asynchronous(async move { can::part(args, &ros).await }),
        CliCommand::Order(args) => asynchronous(async move { cell::order(args, &ros).await }),
        CliCommand::Why(args) => asynchronous(async move { cell::why(args, &ros).await }),
        CliCommand::Answer(args) => asynchronous(async move { cell::answer(args, &ros).await }),
        CliCommand::Resource(args) => asynchronous(async move { cell::resource(args, &ros).await }),
        CliCommand::Watch(args) => asynchronous(async move { watch::run(args, &ros).await }),
        CliCommand::Console(args) => logged(&ros, || asynchronous(async { console::run(args, &ros).await })),
        CliCommand::Can(args) => asynchronous(async move { can::run(args, &ros).await }),
        CliCommand::Diagnostics(args) => diagnostics::run(&args),
        CliCommand::Interface(args) => interface::run(&args),
        CliCommand::Deploy(args) => deploy::run(&args, &ros),
        CliCommand::Schema(args) => schema::run(&args),
        CliCommand::Completions(args) => shell::completions(&args),
        CliCommand::Man(args) => shell::man(&args),
        CliCommand::Candump(args) => asynchronous(async move { can::dump(args).await }),
    }
}

fn logged(ros: &RosArgs, work: impl FnOnce() -> miette::Result<ExitCode>) -> miette::Result<ExitCode> {
    init_logging(ros.log_level).map_err(|error| miette::miette!("{error}"))?;
    work()
}

/// Runs on one thread: a controller's shell needs no more, and the DDS library has its own.
fn asynchronous(work: impl Future<Output = miette::Result<ExitCode>>) -> miette::Result<ExitCode> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| miette::miette!("cannot start the runtime: {error}"))?;
    let ended = runtime.block_on(work);
    // A record that is still being written by a disk that hangs does not hold up the end.
    runtime.shutdown_background();
    ended
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(words: &[&str]) -> String {
        let words = std::iter::once("linewright").chain(words.iter().copied());
        let wrong = numbers_as_values(Cli::command()).try_get_matches_from(words).expect_err("it is refused");
        number_errors(&wrong.render().to_string())
    }

    #[test]
    fn a_number_that_cannot_be_is_refused_as_a_number() {
        let seconds = refused(&["press", "LINE", "PB_2", "--for", "0.8 s"]);
        assert!(seconds.contains("expected seconds above 0, up to 3600, without a unit, e.g. 0.8"), "{seconds}");
        let seconds = refused(&["press", "LINE", "PB_2", "--for", "-1"]);
        assert!(seconds.contains("'-1' for '--for") && seconds.contains("above 0, up to 3600"), "{seconds}");
        for (words, place) in [
            (["run", "LINE", "--cycles", "-1"], "'-1' for '--cycles"),
            (["run", "LINE", "--cycles", "0"], "'0' for '--cycles"),
            (["run", "LINE", "--cycles", "x"], "'x' for '--cycles"),
            (["check", "LINE", "--states", "0"], "'0' for '--states"),
        ] {
            let text = refused(&words);
            assert!(text.contains(place) && text.contains("expected a whole number, 1 or more"), "{text}");
        }
        let quantity = refused(&["order", "CELL", "submit", "shaft", "-3"]);
        assert!(quantity.contains("'-3' for '[QUANTITY]'") && !quantity.contains("unexpected"), "{quantity}");
    }
}
