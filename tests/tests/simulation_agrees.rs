//! `linewright simulate` leaves out frames and the gateway. It must not come to another end: the same line, played by the
//! simulation and by the whole stack, does the same operations in the same order as far as the chart orders them, and
//! takes the same time but for messages.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_line::net::Block;
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_simulation::{End, Goal, Options, What, run};
use linewright_station_logic::{Event, Happening};
use linewright_tests::{Sim, transfer_line_with};

const CYCLES: i32 = 6;

type Op = (StationId, OpId);

/// When each operation started and was done in each cycle, and what each station did in its own order.
#[derive(Default)]
struct Trace {
    started: BTreeMap<(Op, i32), Tick>,
    done: BTreeMap<(Op, i32), Tick>,
    order: BTreeMap<StationId, Vec<(Happening, i32)>>,
}

impl Trace {
    fn enter(&mut self, at: Tick, id: StationId, event: Event) {
        if event.cycle > CYCLES {
            return;
        }
        match event.what {
            Happening::Started(op, Block::Normal) => drop(self.started.insert(((id, op), event.cycle), at)),
            Happening::Completed(op, Block::Normal) => drop(self.done.insert(((id, op), event.cycle), at)),
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

#[test]
fn the_whole_stack_and_the_simulation_do_the_same() {
    for machines in [1, 3] {
        let line = transfer_line_with(machines, 1.0);
        let mut full = Sim::new(&line, 1);
        full.start_auto();
        full.run_until_done("mill_1", "reset main slide", CYCLES);
        full.run_for(Duration::from_secs(4));
        let mut stack = Trace::default();
        for id in line.station_ids() {
            full.log().of(id).for_each(|(at, event)| stack.enter(at, id, event));
        }

        let options = Options { keeps_log: true, ..Options::default() };
        let (sim, end) = run(&line, options, &Goal::cycles(CYCLES as usize)).expect("the line compiles");
        assert_eq!(end, End::Done);
        let mut pure = Trace::default();
        for entry in sim.log().entries() {
            if let What::Station(id, event) = entry.what {
                pure.enter(entry.at, id, event);
            }
        }

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
