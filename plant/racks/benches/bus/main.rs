//! The field bus through a real transport: SocketCAN where there is an interface `vcan0`, else the virtual bus.
//!
//! - `latency`: from an image to the frame at the device, and from a frame to the image, beside a bare frame;
//! - `rate`: what a frame costs a manager of 126 devices in processor time, beside a listener that does nothing with it;
//! - `boot`: 32 simulated devices side by side and one after the other;
//! - `sdo`: small reads, and objects of 10 kB, in segments and blocks.
//!
//! On `vcan0`, and if `LINEWRIGHT_PYTHON` names a Python with `canopen`, that package does the same steps with the same
//! devices and the same server, in turn with ours. All of it is repeated; the median and the best are printed.
//!
//! `cargo bench -p linewright-racks --bench bus [-- WHAT]`; in a user-mode Linux, where the kernel has no CAN:
//! `LINEWRIGHT_PYTHON=… fieldbus/io/tests/vcan_uml.sh target/release/deps/bus-…`.

mod boot;
mod latency;
mod rate;
mod sdo;

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use linewright_fieldbus::bus::{BusOptions, Transport};

/// Bus to measure on.
#[derive(Clone)]
struct Place {
    name: &'static str,
    interface: &'static str,
    options: BusOptions,
}

type Part = fn(&Place);

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let dir = tempfile::tempdir().expect("a directory for the virtual bus");
    let on = |transport| BusOptions { transport, dir: Some(dir.path().to_owned()) };
    // Real sockets are measured alone where there are any; in a user-mode Linux all of it takes minutes.
    let place = if Path::new("/sys/class/net/vcan0").exists() {
        Place { name: "SocketCAN vcan0", interface: "vcan0", options: on(Transport::SocketCan) }
    } else {
        Place { name: "virtual bus", interface: "bench", options: on(Transport::Virtual) }
    };
    let parts: [(&str, Part); 4] =
        [("boot", boot::run), ("sdo", sdo::run), ("latency", latency::run), ("rate", rate::run)];
    for (name, part) in parts {
        if words.is_empty() || words.iter().any(|word| word == name) {
            println!("== {name}, {}", place.name);
            part(&place);
        }
    }
}

/// Runs what is asynchronous on this thread.
fn block_on<T>(what: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    runtime.block_on(what)
}

/// The median and the best of some times, for a line of text.
fn of(times: &mut [Duration]) -> String {
    times.sort();
    let [median, p99] = [times.len() / 2, times.len() * 99 / 100].map(|at| times[at.min(times.len() - 1)]);
    format!("median {median:.1?}, best {:.1?}, 99 % {p99:.1?} of {}", times[0], times.len())
}

/// Has Python do its part, if there is one; what it prints is printed.
fn python(place: &Place, words: &[&str]) {
    let Ok(python) = std::env::var("LINEWRIGHT_PYTHON") else { return };
    if place.interface != "vcan0" {
        return;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/bus/peer.py");
    let mut command = Command::new(python);
    command.arg(script).args(words).arg(place.interface).env("PYTHONDONTWRITEBYTECODE", "1");
    match command.output() {
        Ok(output) => {
            print!("{}", String::from_utf8_lossy(&output.stdout));
            if !output.status.success() {
                println!("  python failed: {}", String::from_utf8_lossy(&output.stderr));
            }
        }
        Err(error) => println!("  no python: {error}"),
    }
}
