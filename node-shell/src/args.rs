//! The ROS 2 part of a command line.
//!
//! `--ros-args … [--]` may stand anywhere and any number of times; what stands outside belongs to the
//! program and is handed back. Inside, rclcpp's rules hold: an unknown argument is an error, the first
//! matching remap rule wins, the last value of a parameter and the last `--log-level` win.
//!
//! Arguments, environment and the text of files come in, a value or an error with the offending text goes out.

use crate::environment::{self, EnvironmentError, Range};
use crate::names::{self, NameError, Remap, RemapTarget};
use linewright_parameters::Problems;
use linewright_parameters::{Argument, FILE_BYTES_MAX, Override, ParameterFile, argument_value};
use std::io::Read;
use thiserror::Error;

/// Log level (`--log-level`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogLevel {
    /// Everything.
    Debug,
    /// Normal events.
    Info,
    /// Unexpected events.
    Warn,
    /// Errors.
    Error,
    /// As `Error`; ROS 2 has one more level.
    Fatal,
}

impl LogLevel {
    const ALL: [LogLevel; 5] = [LogLevel::Debug, LogLevel::Info, LogLevel::Warn, LogLevel::Error, LogLevel::Fatal];

    /// The level with this name, in small letters.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|level| level.name() == name)
    }

    /// Its name, in small letters.
    pub fn name(self) -> &'static str {
        match self {
            LogLevel::Debug => "debug",
            LogLevel::Info => "info",
            LogLevel::Warn => "warn",
            LogLevel::Error => "error",
            LogLevel::Fatal => "fatal",
        }
    }
}

/// ROS 2 settings from the command line and the environment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosArgs {
    /// Remap rules in the order given.
    pub remaps: Vec<Remap>,
    /// Values of parameters, from files and arguments, in the order given.
    pub params: Vec<Override>,
    pub log_level: Option<LogLevel>,
    pub domain_id: u16,
    /// Discovery range if the environment names one. Nothing named means this machine only.
    pub range: Option<Range>,
    /// Arguments without effect here; log these.
    pub warnings: Vec<String>,
}

/// A command line that cannot be obeyed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ArgsError {
    /// Neither an option nor any other known argument.
    #[error("unknown ROS argument '{argument}' (a '--' ends the ROS arguments)")]
    Unknown { argument: String },
    /// An option at the end, without its value.
    #[error("'{option}' needs a value after it")]
    NoValue { option: String },
    /// No `:=`, or nothing on one side of it.
    #[error("'{option} {value}': expected {expected}")]
    Malformed {
        option: String,
        value: String,
        /// Expected form.
        expected: &'static str,
    },
    /// A value of a parameter that is no YAML.
    #[error("'{option} {value}': {why}")]
    Value { option: String, value: String, why: String },
    /// A parameter file that cannot be read.
    #[error("'--params-file {file}': {why}")]
    ParamsFile {
        file: String,
        /// Reason, in the operating system's words where it gives one.
        why: String,
    },
    /// Problems in a parameter file.
    #[error("{0:#}")]
    InParamsFile(Box<Problems>),
    /// Not a level.
    #[error("'--log-level {value}': expected debug, info, warn, error or fatal")]
    LogLevel { value: String },
    /// The environment is at fault.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
}

/// Options of rclcpp that change nothing here; `true` if a value follows.
const WITHOUT_EFFECT: &[(&str, bool)] = &[
    ("-e", true),
    ("--enclave", true),
    ("--log-config-file", true),
    ("--log-file-name", true),
    ("--enable-rosout-logs", false),
    ("--disable-rosout-logs", false),
    ("--enable-stdout-logs", false),
    ("--disable-stdout-logs", false),
    ("--enable-external-lib-logs", false),
    ("--disable-external-lib-logs", false),
];

impl RosArgs {
    /// Splits `args` (without the program's name) into the ROS part, parsed, and the rest. `read` gives the text of a parameter
    /// file, or the reason why it cannot be read.
    pub fn parse(
        args: impl IntoIterator<Item = String>,
        var: impl Fn(&str) -> Option<String>,
        read: impl Fn(&str) -> Result<String, String>,
    ) -> Result<(Self, Vec<String>), ArgsError> {
        let environment = environment::read(var)?;
        let mut parsed = Self {
            domain_id: environment.domain_id,
            range: environment.range,
            warnings: environment.warnings,
            ..Self::default()
        };
        let mut rest = Vec::new();
        let mut args = args.into_iter();
        let mut inside = false;
        while let Some(argument) = args.next() {
            match (inside, argument.as_str()) {
                (_, "--ros-args") => inside = true,
                (true, "--") => inside = false,
                (true, _) => parsed.take(argument, &mut args, &read)?,
                (false, _) => rest.push(argument),
            }
        }
        Ok((parsed, rest))
    }

    /// [`parse`](Self::parse) of this process's own arguments and environment. Arguments that are not
    /// Unicode can be no ROS argument; they are handed back with the offending bytes replaced.
    pub fn from_process() -> Result<(Self, Vec<String>), ArgsError> {
        let args = std::env::args_os().skip(1).map(|arg| arg.to_string_lossy().into_owned());
        Self::parse(args, |name| std::env::var(name).ok(), read_file)
    }

    /// The absolute name of a node after remaps.
    ///
    /// # Errors
    /// When the name or the namespace is none, as given or as remapped.
    pub fn node_name(&self, namespace: &str, name: &str) -> Result<String, NameError> {
        let (namespace, name) = names::identify(&self.remaps, namespace, name)?;
        names::expand(&name, &namespace, &name)
    }

    fn take(
        &mut self,
        option: String,
        args: &mut impl Iterator<Item = String>,
        read: impl Fn(&str) -> Result<String, String>,
    ) -> Result<(), ArgsError> {
        if let Some((_, with_value)) = WITHOUT_EFFECT.iter().find(|(known, _)| *known == option) {
            if *with_value && args.next().is_none() {
                return Err(ArgsError::NoValue { option });
            }
            self.warnings.push(format!("'{option}' has no effect"));
            return Ok(());
        }
        if !matches!(option.as_str(), "-r" | "--remap" | "-p" | "--param" | "--params-file" | "--log-level") {
            return Err(ArgsError::Unknown { argument: option });
        }
        let Some(value) = args.next() else { return Err(ArgsError::NoValue { option }) };
        match option.as_str() {
            "-r" | "--remap" => self.remaps.push(remap(&option, value)?),
            "-p" | "--param" => self.params.push(param(&option, value)?),
            "--log-level" => self.log_level = Some(self.level(value)?),
            _ => self.params.push(params_file(value, read)?),
        }
        Ok(())
    }

    /// `info`, or `logger:=info`: there is one logger here, so its name is only reported.
    fn level(&mut self, value: String) -> Result<LogLevel, ArgsError> {
        let text = match value.split_once(":=") {
            Some((logger, level)) => {
                self.warnings.push(format!("--log-level for logger '{logger}' applies to the whole process"));
                level
            }
            None => &value,
        };
        LogLevel::named(&text.to_ascii_lowercase()).ok_or(ArgsError::LogLevel { value })
    }
}

/// The text of a parameter file.
fn read_file(path: &str) -> Result<String, String> {
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(|error| error.to_string())?;
    file.take(FILE_BYTES_MAX as u64 + 1).read_to_string(&mut text).map_err(|error| error.to_string())?;
    if text.len() > FILE_BYTES_MAX {
        return Err(format!("it has more than {FILE_BYTES_MAX} bytes"));
    }
    Ok(text)
}

fn params_file(file: String, read: impl Fn(&str) -> Result<String, String>) -> Result<Override, ArgsError> {
    let text = read(&file).map_err(|why| ArgsError::ParamsFile { file: file.clone(), why })?;
    let read = ParameterFile::read(&file, &text).map_err(|problems| ArgsError::InParamsFile(Box::new(problems)))?;
    Ok(Override::File(read))
}

/// Splits `[node:]left:=right`; both sides must be there.
fn assignment(value: &str) -> Option<(Option<String>, &str, &str)> {
    let (left, right) = value.split_once(":=")?;
    let (node, left) = match left.split_once(':') {
        Some((node, left)) => (Some(node.to_owned()), left),
        None => (None, left),
    };
    let empty_node = node.as_deref().is_some_and(str::is_empty);
    (!left.is_empty() && !right.is_empty() && !empty_node).then_some((node, left, right))
}

fn remap(option: &str, value: String) -> Result<Remap, ArgsError> {
    let bad = |value: String| ArgsError::Malformed {
        option: option.to_owned(),
        value,
        expected: "[node:]from:=to, __ns:=/namespace or __node:=name",
    };
    // "rostopic://" names the kind of a rule; there are only topics here.
    let plain = value.replacen("rostopic://", "", 1);
    let Some((node, from, to)) = assignment(&plain) else { return Err(bad(value)) };
    let target = match from {
        "__node" | "__name" => RemapTarget::NodeName,
        "__ns" => RemapTarget::Namespace,
        reserved if reserved.starts_with("__") => return Err(bad(value)),
        topic => RemapTarget::Topic(topic.to_owned()),
    };
    Ok(Remap { node, target, to: to.to_owned() })
}

fn param(option: &str, value: String) -> Result<Override, ArgsError> {
    let option = option.to_owned();
    let Some((node, name, text)) = assignment(&value) else {
        return Err(ArgsError::Malformed { option, value, expected: "[node:]name:=value" });
    };
    match argument_value(text) {
        Ok(found) => Ok(Override::Argument(Argument { node, name: name.to_owned(), value: found })),
        Err(why) => Err(ArgsError::Value { option, value, why }),
    }
}

#[cfg(test)]
#[path = "args_tests.rs"]
mod tests;
