//! `linewright deploy`: writes for each host of a line the files that it takes: description, services, their settings, and a script that
//! installs them.
//!
//! Nothing is installed or sent anywhere by this command. The services are those of `launch-config/systemd`, unchanged; what differs from
//! host to host is in their environment file and in drop-ins.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{create_dir_all, read_dir, set_permissions, write};
use std::net::IpAddr;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use linewright_line::{DeviceKind, Line};
use linewright_node_shell::RosArgs;
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::{files, load};

const STATION: &str = include_str!("../../launch-config/systemd/linewright-station@.service");
const COORDINATOR: &str = include_str!("../../launch-config/systemd/linewright-coordinator.service");

/// The coordinator's name beside those of stations. No station can have it: their nodes would have one name.
const COORDINATOR_NODE: &str = "coordinator";

/// Write for each host what is to be installed on it: description, services and their settings.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// Host of a station, or of `coordinator`; repeat it for each. `'*=HOST'` is for all that are not named.
    #[arg(long = "host", value_name = "STATION=HOST", required = true, value_parser = placed)]
    hosts: Vec<(String, String)>,
    /// Directory to write to, with a directory for each host; created if missing.
    #[arg(long)]
    out: PathBuf,
    /// Network of the hosts, as `192.168.7.0/24`: services take packets from there and from their own host alone. Required for several hosts;
    /// may be repeated.
    #[arg(long = "network", value_name = "ADDRESS/BITS", value_parser = network)]
    networks: Vec<String>,
    /// The CAN interface of the line's bus, on the coordinator's host.
    #[arg(long, default_value = "can0")]
    bus: String,
    /// Write into directories that are not empty: files of the same names are replaced.
    #[arg(long)]
    force: bool,
}

fn placed(word: &str) -> Result<(String, String), String> {
    let (node, host) = word.split_once('=').ok_or("expected STATION=HOST, as `mill_1=cell-pc-2`")?;
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || ".-".contains(c);
    if host.is_empty() || host.len() > 253 || !host.chars().all(is_allowed) || host.starts_with(['.', '-']) {
        return Err(format!("`{host}` is no host name: letters, digits, `-` and `.`"));
    }
    Ok((node.to_owned(), host.to_owned()))
}

fn network(word: &str) -> Result<String, String> {
    let parts = word.split_once('/').and_then(|(address, bits)| {
        let address: IpAddr = address.parse().ok()?;
        let bits: u8 = bits.parse().ok()?;
        Some((address, bits, if address.is_ipv4() { 32 } else { 128 }))
    });
    match parts {
        Some((_, 1.., max)) if parts.is_some_and(|(_, bits, _)| bits <= max) => Ok(word.to_owned()),
        Some(_) => Err("bits from 1 to 32 of an IPv4 address, to 128 of an IPv6 address".to_owned()),
        None => Err("expected ADDRESS/BITS, as `192.168.7.0/24`".to_owned()),
    }
}

/// `linewright deploy`
pub fn run(args: &Args, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, false)?;
    // What is wrong with a cell is found here, and not on its host.
    let cell = load::cell_of(&args.line, &line)?;
    let hosts = hosts(&line, &args.hosts)?;
    // Nodes find each other by IPv4 alone.
    let is_v4 = |network: &String| !network.contains(':');
    if hosts.len() > 1 && !args.networks.iter().any(is_v4) {
        return Err(miette!(
            help =
                "for instance `--network 192.168.7.0/24`; the services take packets from there and by loopback alone",
            "{} hosts need the network that joins them, one of IPv4",
            hosts.len()
        ));
    }
    for host in hosts.keys() {
        let dir = args.out.join(host);
        let is_used = dir.exists() && read_dir(&dir).into_diagnostic()?.next().is_some();
        if is_used && !args.force {
            return Err(miette!(help = "give another --out, or --force", "{} is not empty", dir.display()));
        }
    }
    let fingerprint = cell.as_ref().map_or(line.fingerprint(), |cell| cell.fingerprint(&line));
    for (host, nodes) in &hosts {
        write_host(args, ros, (&line, cell.is_some()), (host, nodes), hosts.len() > 1)?;
        crate::out::say!("{host}: {}", nodes.join(", "));
    }
    for name in modbus_hosts(&line).filter(|host| host.parse::<IpAddr>().is_err()) {
        crate::out::complain!("the address of Modbus device {name} is not known: allow it with --network ADDRESS/32");
    }
    crate::out::say!("fingerprint of the description: {fingerprint:016x}");
    crate::out::say!("next:  copy each directory to its host, and run `sudo sh install.sh` in it there");
    Ok(ExitCode::SUCCESS)
}

/// The nodes of each host: `coordinator` first, then stations in the order of the line.
fn hosts<'a>(line: &'a Line, placed: &'a [(String, String)]) -> miette::Result<BTreeMap<&'a str, Vec<&'a str>>> {
    let nodes: Vec<&str> =
        [COORDINATOR_NODE].into_iter().chain(line.stations.iter().map(|of| of.name.as_str())).collect();
    let mut chosen: BTreeMap<&str, &str> = BTreeMap::new();
    for (node, host) in placed {
        if node != "*" && !nodes.contains(&node.as_str()) {
            let error = miette!("no station `{node}` in {}; it has {}", line.name, nodes[1..].join(", "));
            return Err(load::or_meant(error, node, nodes.iter().copied()));
        }
        if let Some(other) = chosen.insert(node, host).filter(|other| other != host) {
            return Err(miette!("`{node}` has two hosts: {other} and {host}"));
        }
    }
    let missing: Vec<&str> =
        nodes.iter().copied().filter(|node| !chosen.contains_key(node) && !chosen.contains_key("*")).collect();
    if !missing.is_empty() {
        return Err(miette!(
            help = "give `--host NAME=HOST` for each, or `--host '*=HOST'` for all that are left",
            "no host for {}",
            missing.join(", ")
        ));
    }
    let mut hosts: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for node in nodes {
        hosts.entry(chosen.get(node).or(chosen.get("*")).expect("each node has one")).or_default().push(node);
    }
    Ok(hosts)
}

fn write_host(
    args: &Args,
    ros: &RosArgs,
    (line, has_cell): (&Line, bool),
    (host, nodes): (&str, &[&str]),
    is_one_of_several: bool,
) -> miette::Result<()> {
    let dir = args.out.join(host);
    let own = load::file_of(&args.line);
    let from = own.parent().unwrap_or(Path::new(""));
    let description = format!("etc/linewright/{}", line.name);
    let mut written = vec![
        (format!("{description}/line.toml"), files::description(&own)?.into_bytes()),
        ("etc/linewright/environment".to_owned(), environment(args, ros, line, is_one_of_several).into_bytes()),
    ];
    if has_cell && let Some(cell) = load::cell_file(&args.line) {
        written.push((format!("{description}/cell.toml"), files::description(&cell)?.into_bytes()));
    }
    for file in device_files(line) {
        let path = files::beside(from, file)?;
        let bytes = std::fs::read(&path).into_diagnostic().wrap_err_with(|| path.display().to_string())?;
        written.push((format!("{description}/{file}"), bytes));
    }
    let units = "etc/systemd/system";
    let network = drop_in(args, line);
    if nodes.contains(&COORDINATOR_NODE) {
        written.push((format!("{units}/linewright-coordinator.service"), COORDINATOR.into()));
        written.push((format!("{units}/linewright-coordinator.service.d/network.conf"), network.clone().into_bytes()));
    }
    if nodes.iter().any(|node| *node != COORDINATOR_NODE) {
        written.push((format!("{units}/linewright-station@.service"), STATION.into()));
        written.push((format!("{units}/linewright-station@.service.d/network.conf"), network.into_bytes()));
    }
    let script = install_script(&line.name, host, nodes, written.iter().map(|(file, _)| file.as_str()));
    written.push(("install.sh".to_owned(), script.into_bytes()));
    for (file, bytes) in written {
        let path = dir.join(&file);
        let place = || path.display().to_string();
        create_dir_all(path.parent().unwrap_or(&dir)).into_diagnostic().wrap_err_with(place)?;
        write(&path, bytes).into_diagnostic().wrap_err_with(place)?;
        let mode = if file == "install.sh" { 0o755 } else { 0o644 };
        set_permissions(&path, PermissionsExt::from_mode(mode)).into_diagnostic().wrap_err_with(place)?;
    }
    Ok(())
}

/// The files that the description names, each once.
fn device_files(line: &Line) -> Vec<&str> {
    let mut named: Vec<&str> = Vec::new();
    for device in &line.devices {
        named.extend(device.canopen().and_then(|canopen| canopen.setup.file.as_deref()));
        if let DeviceKind::Frames(frames) = &device.kind {
            named.push(&frames.file.name);
        }
    }
    named.sort_unstable();
    named.dedup();
    named
}

/// Settings that the services read, as `NAME=VALUE`.
fn environment(args: &Args, ros: &RosArgs, line: &Line, is_one_of_several: bool) -> String {
    let range = if is_one_of_several { "SUBNET" } else { "LOCALHOST" };
    format!(
        "LINE=/etc/linewright/{}\nBUS={}\nROS_DOMAIN_ID={}\nROS_AUTOMATIC_DISCOVERY_RANGE={range}\n",
        line.name, args.bus, ros.domain_id
    )
}

/// Hosts of the Modbus devices, as the description has them.
fn modbus_hosts(line: &Line) -> impl Iterator<Item = &str> {
    let addresses = line.devices.iter().filter_map(|device| device.modbus()).map(|modbus| modbus.address.as_str());
    addresses.map(|address| address.rsplit_once(':').map_or(address, |(host, _)| host).trim_matches(['[', ']']))
}

/// Part of a service: the addresses that it takes packets from and sends to.
fn drop_in(args: &Args, line: &Line) -> String {
    let mut allowed = vec!["localhost".to_owned()];
    allowed.extend(args.networks.iter().cloned());
    if !args.networks.is_empty() {
        // How DDS discovers: the group of RTPS 2.5, 9.6.1.4.2.
        allowed.push("239.255.0.1".to_owned());
    }
    let mut named = String::new();
    for host in modbus_hosts(line) {
        match host.parse::<IpAddr>() {
            Ok(address) => allowed.push(address.to_string()),
            Err(_) => {
                let _ = writeln!(named, "# {host} is a name: its address has to be among these.");
            }
        }
    }
    allowed.dedup();
    format!("{named}[Service]\nIPAddressDeny=any\nIPAddressAllow={}\n", allowed.join(" "))
}

/// A word of a shell script.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

/// The script that installs the files of a host's directory on that host, as root, and restarts its services. Files of the same names are
/// replaced; directories with states of nodes are not touched.
fn install_script<'a>(line: &str, host: &str, nodes: &[&str], files: impl Iterator<Item = &'a str>) -> String {
    let units: Vec<String> = nodes
        .iter()
        .map(|node| match *node {
            COORDINATOR_NODE => "linewright-coordinator".to_owned(),
            station => format!("linewright-station@{station}"),
        })
        .collect();
    let units = units.join(" ");
    let installs: String =
        files.map(|file| format!("install -D -m 644 {} {}\n", quoted(file), quoted(&format!("/{file}")))).collect();
    format!(
        r#"#!/bin/sh
# Installs the part of the line that runs on {host}. Run it as root in this directory, with the line at stand-by.
set -eu
cd "$(dirname "$0")"
if [ "$(id -u)" != 0 ]; then
    echo "run this as root: sudo sh install.sh" >&2
    exit 1
fi
wanted='{version}'
found="$(/usr/bin/linewright --version 2>/dev/null || echo 'no /usr/bin/linewright')"
if [ "$found" != "$wanted" ]; then
    echo "this was written by '$wanted', and here is '$found': install the same program as /usr/bin/linewright on each host" >&2
    exit 1
fi
installed="$(sed -n 's/^LINE=//p' /etc/linewright/environment 2>/dev/null || true)"
if [ -n "$installed" ] && [ "$installed" != '/etc/linewright/{line}' ]; then
    echo "$installed is installed here: run 'install.sh remove' of that line first" >&2
    exit 1
fi
kept=' {services} '
if [ "${{1:-}}" = remove ]; then
    kept=' '
elif [ "$#" != 0 ]; then
    echo "usage: sh install.sh [remove]" >&2
    exit 1
fi
# A node that has moved to another host must not control the same machine from here.
for unit in $(systemctl list-units --all --plain --no-legend 'linewright-coordinator.service' 'linewright-station@*.service' | awk '{{print $1}}') \
    $(ls /etc/systemd/system/multi-user.target.wants 2>/dev/null | grep -E '^linewright-(coordinator|station@.*)\.service$' || true); do
    case "$kept" in
    *" $unit "*) ;;
    *) systemctl disable --now "$unit" ;;
    esac
done
if [ "$kept" = ' ' ]; then
    rm -f /etc/linewright/environment
    exit 0
fi
id linewright >/dev/null 2>&1 || useradd --system --no-create-home linewright
{installs}systemctl daemon-reload
systemctl enable {units}
systemctl restart {units}
systemctl --no-pager status {units} || true
"#,
        services = units.split(' ').map(|unit| format!("{unit}.service")).collect::<Vec<_>>().join(" "),
        version = format_args!("linewright {}", env!("LINEWRIGHT_VERSION")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Line {
        let text = linewright_line::TransferLine::default().text();
        linewright_line::parse("line.toml", &text).expect("the shipped line is sound").line
    }

    fn given(placed: &[(&str, &str)]) -> Vec<(String, String)> {
        placed.iter().map(|(node, host)| ((*node).to_owned(), (*host).to_owned())).collect()
    }

    #[test]
    fn each_node_has_one_host() {
        let line = line();
        let placed = given(&[("mill_1", "b"), ("*", "a")]);
        let found = hosts(&line, &placed).expect("all have one");
        assert_eq!(found["a"], ["coordinator", "transfer", "clamp_1"]);
        assert_eq!(found["b"], ["mill_1"]);
        let errors = [
            (given(&[("mill_1", "b")]), "no host for coordinator, transfer, clamp_1"),
            (given(&[("mill_1", "b"), ("mill_1", "c"), ("*", "a")]), "`mill_1` has two hosts: b and c"),
            (
                given(&[("mill_2", "b"), ("*", "a")]),
                "no station `mill_2` in transfer_line; it has transfer, clamp_1, mill_1",
            ),
        ];
        for (placed, expected) in errors {
            assert_eq!(hosts(&line, &placed).expect_err(expected).to_string(), expected);
        }
    }

    #[test]
    fn hosts_and_networks_are_read() {
        assert_eq!(placed("mill_1=pc-2.hall"), Ok(("mill_1".to_owned(), "pc-2.hall".to_owned())));
        for bad in ["mill_1", "mill_1=", "mill_1=../x", "mill_1=.hidden", "mill_1=a b"] {
            assert!(placed(bad).is_err(), "{bad}");
        }
        for good in ["192.168.7.0/24", "10.0.0.0/8", "fd00::/8"] {
            assert_eq!(network(good).as_deref(), Ok(good));
        }
        for bad in ["192.168.7.0", "192.168.7.0/33", "0.0.0.0/0", "hall/24", "fd00::/129"] {
            assert!(network(bad).is_err(), "{bad}");
        }
    }
}
