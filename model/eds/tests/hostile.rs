//! Files that are made to hurt: large, cut, or full of large numbers. Each ends soon, with a description or a problem.

use std::time::{Duration, Instant};

use linewright_eds::{limits, read};
use proptest::prelude::*;

use crate::common::{DRIVE, HEAD, IO, node, said, sound};

/// Far more than any of them takes, also on a busy machine, and far less than anything quadratic would.
const SOON: Duration = Duration::from_secs(20);

fn soon(text: &str) -> Vec<String> {
    let start = Instant::now();
    let said = said(text.as_bytes());
    assert!(start.elapsed() < SOON, "took {:?}", start.elapsed());
    assert!(said.len() <= 2 * limits::PROBLEMS_MAX && said.iter().all(|line| line.len() < 600), "{said:?}");
    said
}

#[test]
fn numbers_in_a_file_cost_nothing() {
    let arrays: String = (0..8_000)
        .map(|n| format!("[{n:04X}]\nParameterName=A\nObjectType=8\nDataType=7\nAccessType=rw\nCompactSubObj=254\n"))
        .collect();
    let start = Instant::now();
    let eds = sound(&format!("[MandatoryObjects]\nSupportedObjects=0\n{arrays}"));
    assert_eq!(eds.entries().count(), 8_000 * 255, "they can all be asked for");
    assert_eq!(eds.downloads(node(1)), Ok(Vec::new()));
    assert!(start.elapsed() < SOON, "took {:?}", start.elapsed());
    soon(&format!("{HEAD}[OptionalObjects]\nSupportedObjects=4294967295\n"));
    soon(&format!("{HEAD}[1003]\nObjectType=8\nCompactSubObj={}\n", "9".repeat(1_000_000)));
    soon(&format!("{HEAD}[Comments]\nLines=4294967295\nLine4294967295=x\n"));
}

#[test]
fn many_of_everything_ends_soon() {
    soon(&"\n".repeat(limits::FILE_BYTES_MAX));
    soon(&"[]\n".repeat(200_000));
    soon(&"[1000]\n".repeat(200_000));
    soon(&"[1000sub1\n".repeat(200_000));
    soon(&format!("[1000]\n{}", "a=1\n".repeat(200_000)));
    soon(&format!("[1000]\n{}", (0..100_000).map(|n| format!("k{n}=1\n")).collect::<String>()));
    soon(&format!("[OptionalObjects]\n{}", (0..100_000).map(|n| format!("{n}={n}\n")).collect::<String>()));
    soon(&format!("{HEAD}[{}]\n", "1".repeat(1_000_000)));
    soon(&format!("{HEAD}{}=1\n{}", "k".repeat(500_000), "x".repeat(500_000)));
    soon(&format!("{HEAD}DefaultValue={}\n", "; ".repeat(500_000)));
    soon(&format!("{HEAD}DefaultValue=$NODEID{}\n", "+".repeat(500_000)));
    soon(&format!("{HEAD}DefaultValue={}\n", "0".repeat(1_000_000)));
}

#[test]
fn a_file_cut_anywhere_ends_with_a_description_or_a_problem() {
    for whole in [DRIVE, &IO[..6000]] {
        for at in (0..whole.len()).step_by(7) {
            if let Ok(eds) = read("cut.eds", &whole[..at]) {
                assert_eq!(eds.to_bytes(), &whole[..at]);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_end_with_a_description_or_with_problems(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        match read("any.eds", &bytes) {
            Ok(eds) => prop_assert_eq!(eds.to_bytes(), bytes),
            Err(_) => drop(said(&bytes)),
        }
    }

    #[test]
    fn lines_in_any_order_are_kept_as_they_are(
        lines in prop::collection::vec(prop::sample::select(DRIVE.split(|&byte| byte == b'\n').collect::<Vec<_>>()), 0..40),
        end in prop::sample::select(vec![&b"\n"[..], b"\r\n", b"\n\n"]),
    ) {
        let bytes = [HEAD.as_bytes(), &lines.join(end)].concat();
        match read("any.eds", &bytes) {
            Ok(eds) => prop_assert_eq!(eds.to_bytes(), bytes),
            Err(_) => drop(said(&bytes)),
        }
    }
}
