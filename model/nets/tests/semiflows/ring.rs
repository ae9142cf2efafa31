//! A ring of stations that hand parts on through buffers: a live, safe and reversible marked graph of any size.
//!
//! Station i does six operations in a cycle, each with the places `o` (operating) and `c` (completed). Operation 2
//! takes the part out of the buffer before the station (`f` full, `e` empty), operation 4 puts it into the next one.

use linewright_nets::{Net, NetBuilder, PlaceId};

const OPERATIONS: usize = 6;

/// The ring; with `parts` every other buffer is full, without them every station waits for ever.
pub fn ring(stations: usize, parts: bool) -> Net {
    let mut b = NetBuilder::new("ring");
    let mut cells: Vec<([PlaceId; OPERATIONS], [PlaceId; OPERATIONS], PlaceId, PlaceId)> = Vec::new();
    for i in 0..stations {
        let (mut o, mut c) = ([PlaceId(0); OPERATIONS], [PlaceId(0); OPERATIONS]);
        for j in 0..OPERATIONS {
            o[j] = b.place(format!("o_{i}_{j}"), 0);
            c[j] = b.place(format!("c_{i}_{j}"), u32::from(j + 1 == OPERATIONS));
        }
        let full = u32::from(parts && i % 2 == 0);
        cells.push((o, c, b.place(format!("f_{i}"), full), b.place(format!("e_{i}"), 1 - full)));
    }
    for i in 0..stations {
        let (o, c, full, empty) = cells[i];
        let (.., next_full, next_empty) = cells[(i + 1) % stations];
        for j in 0..OPERATIONS {
            let start = b.transition(format!("s_{i}_{j}"));
            let done = b.transition(format!("d_{i}_{j}"));
            b.input(start, c[(j + OPERATIONS - 1) % OPERATIONS], 1).output(start, o[j], 1);
            b.input(done, o[j], 1).output(done, c[j], 1);
            if j == 2 {
                b.input(start, full, 1).output(done, empty, 1);
            }
            if j == 4 {
                b.input(start, next_empty, 1).output(done, next_full, 1);
            }
        }
    }
    b.build().unwrap()
}
