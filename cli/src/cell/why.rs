//! Why something does not go on: of a cell a part, a production order or a resource, as its coordinator answers; of any line
//! what its stations wait for, as `watch` shows it.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use linewright_line::{Line, StationId};
use linewright_node_shell::RosArgs;
use miette::miette;
use serde_json::json;

use super::CellClient;
use super::operate::CONNECT;
use crate::client::OperatorClient;
use crate::load;
use crate::out::{self, say};
use crate::states::StationJson;
use crate::watch;

/// Ask why something does not go on: a line, a station; of a cell also a part, a production order or a resource.
#[derive(Debug, Args)]
pub struct WhyArgs {
    /// The directory of a line or cell, or its description file.
    line: PathBuf,
    /// Name of a station; of a cell also the number of a part (7, or "part 7"), or the name of a production order or a
    /// resource [default: every station].
    about: Vec<String>,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

/// `linewright why`
pub async fn why(args: WhyArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let about = args.about.join(" ");
    let (line, is_cell) = load::line_or_cell(&args.line)?;
    let named = line.station_named(&about);
    let (mut reasons, mut stations) = (Vec::new(), Vec::new());
    match (about.is_empty(), is_cell) {
        (true, _) => stations.extend(line.station_ids()),
        (false, false) if is_part(&about) => return Err(no_parts(&args, &line, &about)),
        (false, false) => stations.push(load::station(&line, &about)?),
        (false, true) => {
            stations.extend(station_of(&args, &line, &about)?.or(named));
            let mut client = CellClient::open(&line, ros, "why")?;
            client.until_heard(CONNECT).await?;
            match client.why(&about).await {
                Ok(lines) => reasons = lines,
                // The coordinator answers about resources, the stations answer for themselves.
                Err(_) if named.is_some() => (),
                Err(unknown) => return Err(unknown),
            }
        }
    }
    let mut lines = reasons.clone();
    let (mut objects, mut others) = (Vec::new(), Vec::new());
    if !stations.is_empty() {
        let mut client = OperatorClient::open(&line, &args.line, ros, "why_line")?;
        client.until_all_heard(CONNECT).await?;
        others = client.other_descriptions();
        lines.splice(0..0, others.clone());
        if about.is_empty() {
            lines.extend(watch::mode(&line.title, client.coordinator(), client.coordinator_unheard_for(), usize::MAX));
        }
        for id in stations {
            let (name, state) = (&line.station(id).name, client.station(id));
            lines.extend(watch::station(name, state, client.unheard_for(id), usize::MAX));
            objects.push(StationJson::of(name, state));
        }
    }
    if args.json {
        out::json(&json!({ "about": about, "reasons": reasons, "other_descriptions": others, "stations": objects }))?;
    } else {
        say!("{}", lines.join("\n"));
    }
    Ok(ExitCode::SUCCESS)
}

/// Whether this is how a part is named.
fn is_part(about: &str) -> bool {
    let number = about.strip_prefix("part").map_or(about, str::trim_start);
    !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit())
}

fn no_parts(args: &WhyArgs, line: &Line, about: &str) -> miette::Report {
    let path = out::shell_word(&args.line.display().to_string());
    let stations: Vec<&str> = line.stations.iter().map(|station| station.name.as_str()).collect();
    miette!(
        help = format!(
            "`linewright why {path}` shows what every station waits for; of one: `linewright why {path} STATION`, of {}",
            stations.join(", ")
        ),
        "'{about}' is a part, and {path} is a line: parts, production orders and resources are those of a flexible cell"
    )
}

/// The station of a resource of that name, if there are both.
fn station_of(args: &WhyArgs, line: &Line, name: &str) -> miette::Result<Option<StationId>> {
    let Some(cell) = load::cell_of(&args.line, line)? else { return Ok(None) };
    let resource = cell.resources.iter().find(|resource| resource.name == name);
    let controller = resource.and_then(|resource| resource.controller);
    Ok(controller.and_then(|id| line.station_named(&cell.controllers[id.index()])))
}
