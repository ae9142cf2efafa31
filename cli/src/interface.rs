//! `linewright interface`: the ROS 2 types of a line, with their hashes and their texts.

use std::process::ExitCode;

use linewright_msgs::{INTERFACES, Interface};
use miette::miette;
use serde_json::json;

/// List the ROS 2 messages, services and actions of a line, or show one.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Interface to show: its name, or the end of it, as in `StationState` or `linewright_msgs/msg/StationState`.
    name: Option<String>,
    /// Print JSON in place of text.
    #[arg(long)]
    json: bool,
}

/// `linewright interface`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    match (&args.name, args.json) {
        (None, false) => {
            let width = INTERFACES.iter().map(|interface| interface.name.len()).max().unwrap_or(0);
            INTERFACES.iter().for_each(|Interface { name, type_hash, .. }| {
                crate::out::say!("{name:width$}  {type_hash}");
            });
        }
        (None, true) => {
            let all: Vec<_> =
                INTERFACES.iter().map(|of| json!({ "name": of.name, "type_hash": of.type_hash })).collect();
            crate::out::json(&all)?;
        }
        (Some(name), is_json) => {
            let Interface { name, type_hash, definition } = find(name)?;
            if is_json {
                crate::out::json(&json!({ "name": name, "type_hash": type_hash, "definition": definition }))?;
            } else {
                crate::out::say!("# {name}\n# {type_hash}\n\n{}", definition.trim_end());
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The interface with this name, or the only one whose name ends with it.
fn find(name: &str) -> miette::Result<&'static Interface> {
    let ends = |of: &&Interface| of.name.strip_suffix(name).is_some_and(|rest| rest.is_empty() || rest.ends_with('/'));
    let short = |of: &&Interface| {
        // As it stands in messages and in docs: without the kind.
        let parts: Vec<&str> = of.name.split('/').collect();
        matches!(&parts[..], [package, _, last] if format!("{package}/{last}") == name)
    };
    let found: Vec<&Interface> = INTERFACES.iter().filter(|of| ends(of) || short(of)).collect();
    match &found[..] {
        [interface] => Ok(interface),
        [] => {
            let known = INTERFACES.iter().flat_map(|of| [of.name, of.name.rsplit('/').next().unwrap_or(of.name)]);
            let near = linewright_text::nearest(name, known).map(|near| format!("did you mean `{near}`? "));
            Err(miette!(
                help = format!("{}`linewright interface` lists those that a line uses", near.unwrap_or_default()),
                "no interface of a line is named `{name}`"
            ))
        }
        several => {
            let names: Vec<&str> = several.iter().map(|of| of.name).collect();
            Err(miette!(help = format!("one of {}", names.join(", ")), "`{name}` is the end of several names"))
        }
    }
}
