//! `linewright simulate` leaves out frames and the gateway, unless it is given `--frames`. It must not come to another end:
//! the same line, played with images at once and with frames, does the same operations in the same order as far as the
//! chart orders them, and takes the same time but for messages.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_line::net::Block;
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_simulation::{LogKind, RunEnd, RunGoal, SimOptions, run};
use linewright_station_logic::{HappeningKind, StationHappening};
use linewright_tests::{QUIET, transfer_line_with};

const CYCLES: i32 = 6;

type Op = (StationId, OpId);

/// When each operation started and was done in each cycle, and what each station did in its own order.
#[derive(Default)]
struct Trace {
    started: BTreeMap<(Op, i32), Tick>,
    done: BTreeMap<(Op, i32), Tick>,
    order: BTreeMap<StationId, Vec<(HappeningKind, i32)>>,
}

impl Trace {
    fn enter(&mut self, at: Tick, id: StationId, event: StationHappening) {
        if event.cycle > CYCLES {
            return;
        }
        match event.what {
            HappeningKind::Started(op, Block::Normal) => drop(self.started.insert(((id, op), event.cycle), at)),
            HappeningKind::Completed(op, Block::Normal) => drop(self.done.insert(((id, op), event.cycle), at)),
            _ => return,
        }
        self.order.entry(id).or_default().push((event.what, event.cycle));
    }

    /// Whatever the chart puts before a start was done before it.
    fn keeps_the_chart(&self, line: &Line) {
        for arrow in &line.arrows {
            for (&(_, cycle), start) in self.started.iter().filter(|((op, _), _)| *op == arrow.to) {
                if let Some(done) = self.done.get(&(arrow.from, cycle - arrow.lag as i32)) {
                    assert!(done < start, "{arrow:?} in cycle {cycle}: done at {done}, started at {start}");
                }
            }
        }
    }

    fn span(&self) -> Duration {
        let ends = self.done.values().max().expect("something was done");
        ends.since(*self.started.values().min().expect("something was started"))
    }
}

fn played(line: &Line, options: SimOptions) -> Trace {
    let options = SimOptions { keeps_log: true, ..options };
    let (sim, end) = run(line, options, &RunGoal::cycles(CYCLES as usize)).expect("the line starts");
    assert_eq!((end, sim.conflicts(), sim.record().cycles()), (RunEnd::Done, &[][..], CYCLES as usize));
    let mut trace = Trace::default();
    for entry in sim.log().entries() {
        if let LogKind::Station(id, event) = entry.what {
            trace.enter(entry.at, id, event);
        }
    }
    trace
}

#[test]
fn images_at_once_and_frames_do_the_same() {
    for machines in [1, 3] {
        let line = transfer_line_with(machines, 1.0);
        let stack = played(&line, SimOptions { frames: true, network: QUIET, images: QUIET, ..SimOptions::default() });
        let pure = played(&line, SimOptions::default());
        assert_eq!(pure.order, stack.order, "each station does the same things in the same order");
        assert_eq!(pure.started.len(), stack.started.len());
        assert!(pure.started.len() >= 17 * (CYCLES as usize - 1), "and they are all there");
        pure.keeps_the_chart(&line);
        stack.keeps_the_chart(&line);
        // The stack's messages and frames: at most 1.3 ms a motion and 0.5 ms an arrow, as worked out in `auto_cycles`.
        let (fast, slow) = (pure.span(), stack.span());
        let messages = Duration::from_millis(24) * CYCLES as u32;
        assert!(
            fast <= slow + Duration::from_millis(5) * CYCLES as u32 && slow <= fast + messages,
            "{fast:?}, {slow:?}"
        );
    }
}
