//! Nets as SVG: circles, bars and arcs where [`NetSheet`] has them, with the initial tokens. The full name of each node is its tool
//! tip; transitions of a station carry the numbers of the published figures.

use std::fmt::Write as _;

use linewright_line::Station;
use linewright_line::net::{Block, NODE_RADIUS, NetSheet, SheetPoint, StationNet, TransitionKind};
use linewright_nets::Net;

use crate::chart::svg::escaped;

/// A station's net.
pub fn of_station(station: &Station, net: &StationNet, sheet: &NetSheet) -> String {
    let places = net.places().iter().map(|place| format!("p{}", place.number()));
    let transitions = net.transitions().iter().map(|transition| number(transition.kind).to_owned());
    let mut drawing = Drawing::new(net.net(), sheet, places.collect(), transitions.collect());
    for (op, at) in station.operations.iter().zip(&sheet.modules) {
        let (x, y, name) = (at.x, at.y - 14.0, escaped(&op.name));
        drawing.line(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" font-weight=\"bold\">{name}</text>"));
    }
    drawing.end()
}

/// A net in a ring, with the names of its places.
pub fn of_ring(net: &Net, sheet: &NetSheet) -> String {
    let places = net.places().map(|place| net.place_name(place).to_owned()).collect();
    Drawing::new(net, sheet, places, vec![String::new(); net.transition_count()]).end()
}

/// The number of a transition in the published figures (seed 002, Figures 12, 13 and 20); none for those that only a recovery path
/// or a task has.
fn number(kind: TransitionKind) -> &'static str {
    match kind {
        TransitionKind::Stop(_, Block::Normal) => "t1",
        TransitionKind::Resume(_, Block::Normal) => "t2",
        TransitionKind::Complete(_, Block::Normal) => "t3",
        TransitionKind::Undo(_) => "t4",
        TransitionKind::Retract(_) => "t5",
        TransitionKind::Stop(_, Block::Recovery) => "t6",
        TransitionKind::Resume(_, Block::Recovery) => "t7",
        TransitionKind::Complete(_, Block::Recovery) => "t8",
        TransitionKind::Restart(_) => "t9",
        TransitionKind::Again(_) => "t10",
        TransitionKind::Next { .. } => "t11",
        TransitionKind::Back { .. } => "t12",
        TransitionKind::GiveUp(_) | TransitionKind::EnterPath(_) | TransitionKind::FollowPath { .. } => "",
    }
}

struct Drawing {
    text: String,
}

impl Drawing {
    /// Everything but what is beside the net; with short names beside its nodes.
    fn new(net: &Net, sheet: &NetSheet, places: Vec<String>, transitions: Vec<String>) -> Self {
        let (width, height) = (sheet.size.x, sheet.size.y);
        let mut drawing = Drawing {
            text: format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" \
                 font-size=\"11\">\n\
                 <defs><marker id=\"arrow\" viewBox=\"0 0 8 8\" refX=\"8\" refY=\"4\" markerWidth=\"7\" markerHeight=\"7\" \
                 orient=\"auto\"><path d=\"M0 0L8 4L0 8z\"/></marker></defs>\n\
                 <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"white\"/>\n\
                 <text x=\"8\" y=\"20\" font-size=\"15\">{}</text>\n",
                escaped(net.name())
            ),
        };
        for arc in &sheet.arcs {
            let (place, transition) = (sheet.places[arc.place], sheet.transitions[arc.transition]);
            let bends = arc.bends.iter().copied();
            let mut points: Vec<SheetPoint> = [place].into_iter().chain(bends).chain([transition]).collect();
            if arc.is_output {
                points.reverse();
            }
            drawing.arc(&points);
        }
        let initial = net.initial_marking();
        for ((p, &at), label) in net.places().zip(&sheet.places).zip(&places) {
            let tokens = initial.tokens(p);
            drawing.node(at, net.place_name(p), label, |at| {
                let dot = format!("<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\"/>", at.x, at.y);
                let count =
                    format!("<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{tokens}</text>", at.x, at.y + 4.0);
                let inside = match tokens {
                    0 => String::new(),
                    1 => dot,
                    _ => count,
                };
                let (x, y) = (at.x, at.y);
                format!(
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{NODE_RADIUS}\" fill=\"white\" stroke=\"black\"/>{inside}"
                )
            });
        }
        for ((t, &at), label) in net.transitions().zip(&sheet.transitions).zip(&transitions) {
            let side = NODE_RADIUS * 1.2;
            drawing.node(at, net.transition_name(t), label, |at| {
                let (x, y) = (at.x - side / 2.0, at.y - side / 2.0);
                format!("<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{side:.1}\" height=\"{side:.1}\" fill=\"#555\"/>")
            });
        }
        drawing
    }

    fn node(&mut self, at: SheetPoint, name: &str, label: &str, shape: impl Fn(SheetPoint) -> String) {
        let (x, y) = (at.x + NODE_RADIUS + 2.0, at.y - NODE_RADIUS + 2.0);
        let (name, label, shape) = (escaped(name), escaped(label), shape(at));
        self.line(format_args!(
            "<g><title>{name}</title>{shape}<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"#555\">{label}</text></g>"
        ));
    }

    /// From node to node, without the parts inside the nodes.
    fn arc(&mut self, points: &[SheetPoint]) {
        let [first, second, ..] = *points else { return };
        let [.., before, last] = *points else { return };
        let mut shown = points.to_vec();
        shown[0] = towards(first, second);
        let end = shown.len() - 1;
        shown[end] = towards(last, before);
        let path = shown.iter().map(|at| format!("{:.1},{:.1}", at.x, at.y)).collect::<Vec<_>>().join(" ");
        self.line(format_args!(
            "<polyline points=\"{path}\" fill=\"none\" stroke=\"black\" marker-end=\"url(#arrow)\"/>"
        ));
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{line}");
    }

    fn end(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }
}

/// The border of a node, on the way to another point.
fn towards(from: SheetPoint, to: SheetPoint) -> SheetPoint {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let share = NODE_RADIUS / dx.hypot(dy).max(NODE_RADIUS);
    SheetPoint { x: from.x + dx * share, y: from.y + dy * share }
}
