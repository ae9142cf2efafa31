//! The ring of stations: a net of any size whose numbers other model checkers have been measured with.

use linewright_nets::{Net, NetBuilder};

/// Operations of a station.
const OPERATIONS: usize = 6;

/// A ring of stations, each with a cycle of six operations, with a buffer between neighbours. The third operation of a
/// station empties the buffer before it, the fifth fills the one behind it. Every second buffer is full at first, so
/// the net is live, safe and reversible; with `empty` all are empty, and every station waits in the end.
pub fn ring(stations: usize, empty: bool) -> Net {
    let mut b = NetBuilder::new("ring");
    let (mut places, mut buffers) = (Vec::new(), Vec::new());
    for i in 0..stations {
        let pair = |j: usize| [b.place(format!("o_{i}_{j}"), 0), b.place(format!("c_{i}_{j}"), u32::from(j == 5))];
        places.push((0..OPERATIONS).map(pair).collect::<Vec<_>>());
        let full = u32::from(i % 2 == 0 && !empty);
        buffers.push([b.place(format!("f_{i}"), full), b.place(format!("e_{i}"), 1 - full)]);
    }
    for i in 0..stations {
        let ([full, vacant], [next_full, next_vacant]) = (buffers[i], buffers[(i + 1) % stations]);
        for j in 0..OPERATIONS {
            let [operating, complete] = places[i][j];
            let before = places[i][(j + OPERATIONS - 1) % OPERATIONS][1];
            let start = b.transition(format!("s_{i}_{j}"));
            let finish = b.transition(format!("d_{i}_{j}"));
            b.input(start, before, 1).output(start, operating, 1);
            b.input(finish, operating, 1).output(finish, complete, 1);
            if j == 2 {
                b.input(start, full, 1).output(finish, vacant, 1);
            }
            if j == 4 {
                b.input(start, next_vacant, 1).output(finish, next_full, 1);
            }
        }
    }
    b.build().expect("the ring is written down correctly")
}
