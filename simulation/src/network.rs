//! The links between the nodes of a line: which node reads which.

use linewright_line::{Line, OpId};

use crate::link::Link;
use crate::options::SimOptions;

/// Every way of the line with, for those between stations, the arrows it carries.
pub(crate) fn links_of(line: &Line, options: &SimOptions) -> (Vec<Link>, Vec<Vec<usize>>) {
    let (coordinator, operator) = (line.stations.len(), line.stations.len() + 1);
    let (mut links, mut arrows) = (Vec::new(), Vec::new());
    let mut add = |from: usize, to: usize, reads: (Vec<OpId>, Option<u128>), carried: Vec<usize>| {
        let term = if from == coordinator { line.timing.lease } else { line.timing.stale };
        let mut link = Link::new((from, to), reads, !options.rules.counted, term, options.seed);
        link.wakes_always = options.one_by_one;
        links.push(link);
        arrows.push(carried);
    };
    for from in 0..coordinator {
        for to in (0..coordinator).filter(|&to| to != from) {
            let joins = |a: &linewright_line::Arrow, x: usize, y: usize| a.from.0.index() == x && a.to.0.index() == y;
            let carried: Vec<usize> = (0..line.arrows.len()).filter(|&at| joins(&line.arrows[at], from, to)).collect();
            // A reader whose counts the writer's arrows compare is asked for agreement, and answers.
            let measures = measured_by(line, from, to);
            if !carried.is_empty() || measures.is_some() || line.arrows.iter().any(|a| joins(a, to, from)) {
                let mut reads: Vec<OpId> = carried.iter().map(|&at| line.arrows[at].from.1).collect();
                reads.sort_unstable();
                reads.dedup();
                add(from, to, (reads, measures), carried);
            }
        }
        add(from, coordinator, (Vec::new(), None), Vec::new());
        add(coordinator, from, (Vec::new(), None), Vec::new());
        add(operator, from, (Vec::new(), None), Vec::new());
    }
    add(operator, coordinator, (Vec::new(), None), Vec::new());
    (links, arrows)
}

/// The inputs of one station that measure for another whether the two are clear of each other; none where no conflict
/// joins them.
fn measured_by(line: &Line, writer: usize, reader: usize) -> Option<u128> {
    let sides = line.conflicts.iter().flat_map(|conflict| [(&conflict.a, &conflict.b), (&conflict.b, &conflict.a)]);
    let read = sides.filter(|(of, other)| of.station.index() == writer && other.station.index() == reader);
    let inputs: Vec<u128> = read.map(|(of, _)| line.clearance(of).map_or(0, |clear| clear.all())).collect();
    (!inputs.is_empty()).then(|| inputs.iter().fold(0, |all, inputs| all | inputs))
}
