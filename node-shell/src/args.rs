//! The ROS 2 part of a command line.
//!
//! `--ros-args … [--]` may stand anywhere and any number of times; what stands outside belongs to the
//! program and is handed back. Inside, rclcpp's rules hold: an unknown argument is an error, the first
//! matching remap rule wins, the last value of a parameter and the last `--log-level` win.
//!
//! Pure: arguments and environment come in, a value or an error with the offending text goes out.

use crate::environment::{self, EnvironmentError, Range};
use crate::names::{Remap, RemapTarget};
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

/// A parameter's value. The forms a ROS 2 parameter can take.
#[derive(Debug, Clone, PartialEq)]
pub enum ParamValue {
    /// `true`, `yes`, `on` and their opposites.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A number with a point or an exponent.
    Double(f64),
    /// Anything else, or quoted.
    Text(String),
    List(Vec<ParamValue>),
}

/// One `-p [node:]name:=value`.
#[derive(Debug, Clone, PartialEq)]
pub struct Param {
    /// For nodes of this name only.
    pub node: Option<String>,
    /// Parameter name, with dots between its parts.
    pub name: String,
    pub value: ParamValue,
}

/// ROS 2 settings from the command line and the environment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosArgs {
    /// Remap rules in the order given.
    pub remaps: Vec<Remap>,
    /// Parameters in the order given; see [`param`](Self::param).
    pub params: Vec<Param>,
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
    /// Parameter files are not read.
    #[error(
        "'--params-file {file}': parameter files are not read; a line is set up by its description, give single parameters with -p name:=value"
    )]
    ParamsFile { file: String },
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
    /// Splits `args` (without the program's name) into the ROS part, parsed, and the rest.
    pub fn parse(
        args: impl IntoIterator<Item = String>,
        var: impl Fn(&str) -> Option<String>,
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
                (true, _) => parsed.take(argument, &mut args)?,
                (false, _) => rest.push(argument),
            }
        }
        Ok((parsed, rest))
    }

    /// [`parse`](Self::parse) of this process's own arguments and environment. Arguments that are not
    /// Unicode can be no ROS argument; they are handed back with the offending bytes replaced.
    pub fn from_process() -> Result<(Self, Vec<String>), ArgsError> {
        let args = std::env::args_os().skip(1).map(|arg| arg.to_string_lossy().into_owned());
        Self::parse(args, |name| std::env::var(name).ok())
    }

    /// The last value given for a parameter of `node`.
    pub fn param(&self, node: &str, name: &str) -> Option<&ParamValue> {
        let ours = |p: &&Param| p.name == name && p.node.as_deref().is_none_or(|n| n == node);
        self.params.iter().rev().find(ours).map(|p| &p.value)
    }

    fn take(&mut self, option: String, args: &mut impl Iterator<Item = String>) -> Result<(), ArgsError> {
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
            _ => return Err(ArgsError::ParamsFile { file: value }),
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
        match text.to_ascii_lowercase().as_str() {
            "debug" => Ok(LogLevel::Debug),
            "info" => Ok(LogLevel::Info),
            "warn" => Ok(LogLevel::Warn),
            "error" => Ok(LogLevel::Error),
            "fatal" => Ok(LogLevel::Fatal),
            _ => Err(ArgsError::LogLevel { value }),
        }
    }
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

fn param(option: &str, value: String) -> Result<Param, ArgsError> {
    match assignment(&value) {
        Some((node, name, text)) => Ok(Param { node, name: name.to_owned(), value: scalar_or_list(text) }),
        None => Err(ArgsError::Malformed { option: option.to_owned(), value, expected: "[node:]name:=value" }),
    }
}

/// The YAML that fits on a command line: scalars and flat lists.
fn scalar_or_list(text: &str) -> ParamValue {
    let text = text.trim();
    match text.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
        Some(inner) if inner.trim().is_empty() => ParamValue::List(Vec::new()),
        Some(inner) => ParamValue::List(items(inner).into_iter().map(|item| scalar(item.trim())).collect()),
        None => scalar(text),
    }
}

/// The items of a list: a comma between quotation marks separates none.
fn items(inner: &str) -> Vec<&str> {
    let mut quote = None;
    let separates = |sign: char| {
        match quote {
            Some(open) if open == sign => quote = None,
            None if matches!(sign, '\'' | '"') => quote = Some(sign),
            Some(_) | None => {}
        }
        quote.is_none() && sign == ','
    };
    inner.split(separates).collect()
}

fn scalar(text: &str) -> ParamValue {
    for quote in ['\'', '"'] {
        if let Some(inner) = text.strip_prefix(quote).and_then(|t| t.strip_suffix(quote)) {
            return ParamValue::Text(inner.to_owned());
        }
    }
    match text.to_ascii_lowercase().as_str() {
        "true" | "yes" | "on" | "y" => return ParamValue::Bool(true),
        "false" | "no" | "off" | "n" => return ParamValue::Bool(false),
        _ => {}
    }
    if let Ok(number) = text.parse::<i64>() {
        return ParamValue::Integer(number);
    }
    // Rust also reads "inf" and "nan" as numbers; YAML writes those with a dot, and they are not needed here.
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && text.contains(|c: char| c.is_ascii_digit()) => ParamValue::Double(number),
        _ => ParamValue::Text(text.to_owned()),
    }
}

#[cfg(test)]
#[path = "args_tests.rs"]
mod tests;
