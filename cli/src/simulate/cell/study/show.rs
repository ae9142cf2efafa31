//! The figures of a study as text.

use std::fmt::Write;
use std::time::Duration;

use linewright_simulation::cell::{CellStudy, Estimate, OrderFigures, ReplicationFigures, ResourceFigures};

/// So many orders are listed; of more the JSON has all.
const LISTED_MAX: usize = 40;

/// Figures of all replications; of one alone its orders as well.
pub fn text(study: &CellStudy, figures: &[ReplicationFigures]) -> String {
    let mut text = study.cell().title.clone();
    if let Some(title) = &study.scenario().title {
        let _ = write!(text, ": {title}");
    }
    text.push('\n');
    heading(&mut text, study, figures);
    let estimate = |of: &dyn Fn(&ReplicationFigures) -> Option<f64>| study.estimate(figures, of);
    let rows: [(&str, &str, Option<Estimate>); 11] = [
        ("throughput", "parts/h", estimate(&|of| Some(of.throughput))),
        ("parts inside", "", estimate(&|of| Some(of.inside))),
        ("time in the cell", "s", estimate(&|of| of.in_cell)),
        ("  waited", "s", estimate(&|of| of.waited)),
        ("lead time of orders", "s", estimate(&|of| of.lead)),
        ("orders open at the end", "", estimate(&|of| Some(of.open as f64)).filter(|of| of.mean > 0.0)),
        ("  overdue", "", estimate(&|of| Some(of.overdue as f64)).filter(|of| of.mean > 0.0)),
        ("orders in time", "%", estimate(&|of| of.in_time.map(|share| share * 100.0))),
        ("tardiness", "s", estimate(&|of| of.tardiness)),
        ("  in sum", "s", estimate(&|of| of.tardiness_sum)),
        ("  at most", "s", estimate(&|of| of.tardiness_max)),
    ];
    text.push('\n');
    for (name, unit, estimate) in rows {
        if let Some(estimate) = estimate {
            let _ = writeln!(text, "{}", format!("{name:<24} {:>20}  {unit}", number(Some(estimate))).trim_end());
        }
    }
    resources(&mut text, study, figures);
    if let [one] = figures {
        orders(&mut text, one);
    }
    text
}

fn heading(text: &mut String, study: &CellStudy, figures: &[ReplicationFigures]) {
    let warm_up = study.scenario().warm_up;
    let cut = if warm_up.is_zero() { String::new() } else { format!(", after {} of warm-up", time(warm_up)) };
    let (parts, orders) = (sum(figures, |of| of.parts), sum(figures, |of| of.orders));
    let longest = figures.iter().map(|of| of.observed).max().unwrap_or_default();
    let _ = match figures.len() {
        1 => writeln!(text, "{parts} parts of {orders} orders done in {}{cut}", time(longest)),
        n => writeln!(
            text,
            "{n} replications of {}{}{cut}; mean ± half width of the {} % confidence interval",
            if study.scenario().duration.is_some() { "" } else { "at most " },
            time(longest),
            (study.scenario().confidence * 1000.0).round() / 10.0
        ),
    };
}

fn sum(figures: &[ReplicationFigures], of: impl Fn(&ReplicationFigures) -> usize) -> usize {
    figures.iter().map(of).sum()
}

fn time(time: Duration) -> String {
    format!("{:.3} s", time.as_secs_f64())
}

/// A mean with its half width, to a thousandth of the mean at least.
fn number(estimate: Option<Estimate>) -> String {
    let Some(Estimate { mean, half_width, .. }) = estimate else { return "-".to_owned() };
    let places = match mean.abs() {
        1000.0.. => 0,
        100.0.. => 1,
        10.0.. => 2,
        _ => 3,
    };
    half_width.map_or_else(|| format!("{mean:.places$}"), |half| format!("{mean:.places$} ± {half:.places$}"))
}

fn resources(text: &mut String, study: &CellStudy, figures: &[ReplicationFigures]) {
    let _ = writeln!(text, "\n{:<24} {:>18} {:>18} {:>18}", "resource", "worked, %", "down, %", "taken");
    for (index, resource) in study.cell().resources.iter().enumerate() {
        let estimate = |of: &dyn Fn(&ResourceFigures) -> f64| {
            study.estimate(figures, |figures| figures.resources.get(index).map(of))
        };
        // A store does nothing by itself.
        let worked = estimate(&|of| of.worked * 100.0).filter(|_| !resource.prototype.stores());
        let down = estimate(&|of| of.down * 100.0).filter(|of| of.mean > 0.0);
        let taken = estimate(&|of| of.taken).filter(|of| of.mean > 0.0);
        let [worked, down, taken] = [worked, down, taken].map(number);
        let _ = writeln!(text, "{:<24} {worked:>18} {down:>18} {taken:>18}", resource.name);
    }
}

fn orders(text: &mut String, of: &ReplicationFigures) {
    let _ = writeln!(
        text,
        "\n{:<24} {:>6} {:>13} {:>13} {:>13} {:>11}",
        "order", "parts", "released", "due", "done", "late"
    );
    for order in of.each.iter().take(LISTED_MAX) {
        let at = |tick: linewright_line::Tick| format!("{:.3} s", tick.as_secs_f64());
        let name = format!("{} ({})", order.name, order.product);
        let _ = writeln!(
            text,
            "{name:<24} {:>6} {:>13} {:>13} {:>13} {:>11}",
            order.quantity,
            at(order.released),
            order.due.map_or("-".to_owned(), at),
            order.done.map_or("-".to_owned(), at),
            late(order)
        );
    }
    if of.each.len() > LISTED_MAX {
        let _ = writeln!(text, "and {} more; --json has all of them", of.each.len() - LISTED_MAX);
    }
}

/// By how much an order was late; nothing of one that is not done.
fn late(order: &OrderFigures) -> String {
    match order.done.and_then(|done| order.tardiness(done)) {
        Some(Duration::ZERO) => "no".to_owned(),
        Some(late) => time(late),
        None => "-".to_owned(),
    }
}
