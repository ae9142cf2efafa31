//! Report of production orders: how many were done, and how late.

use std::fmt;
use std::time::Duration;

use linewright_line::Tick;

use super::super::production::ProductionOrder;
use super::spread::Spread;

/// The production orders of a cell, from some moment on. Those that were over before are not counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OrdersReport {
    /// Not over yet.
    pub open: usize,
    /// All of their parts have left.
    pub done: usize,
    /// Cancelled, and over.
    pub cancelled: usize,
    /// As if they had never been.
    pub withdrawn: usize,
    /// Of those that are done how many had a due date.
    pub due: usize,
    /// And how many of these were not late.
    pub in_time: usize,
    /// Lateness of those that were late.
    pub late: Spread,
}

impl OrdersReport {
    /// Of these orders, from a moment on.
    pub fn of<'a>(orders: impl Iterator<Item = &'a ProductionOrder>, from: Tick) -> Self {
        let (mut of, mut late) = (OrdersReport::default(), Vec::new());
        for order in orders.filter(|order| order.ended.is_none_or(|ended| ended >= from)) {
            match (order.ended, order.withdrawn, order.cancelled) {
                (None, ..) => of.open += 1,
                (Some(_), true, _) => of.withdrawn += 1,
                (Some(_), false, Some(_)) => of.cancelled += 1,
                (Some(_), false, None) => of.done += 1,
            }
            let Some(lateness) = order.lateness() else { continue };
            of.due += 1;
            match u64::try_from(lateness) {
                Ok(micros @ 1..) => late.push(Duration::from_micros(micros)),
                Ok(0) | Err(_) => of.in_time += 1,
            }
        }
        of.late = Spread::of(late);
        of
    }
}

impl fmt::Display for OrdersReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OrdersReport { open, done, cancelled, withdrawn, due, in_time, late } = self;
        if open + done + cancelled + withdrawn == 0 {
            return Ok(());
        }
        write!(f, "\norders: {done} done, {open} open")?;
        for (count, what) in [(cancelled, "cancelled"), (withdrawn, "withdrawn")] {
            if *count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        if *due > 0 {
            write!(f, "; {in_time} of {due} that were due in time")?;
        }
        if late.count > 0 {
            let [median, most] = [late.median, late.most].map(|late| late.as_secs_f64());
            write!(f, ", the others late by {median:.1} s in the median, {most:.1} s at most")?;
        }
        writeln!(f)
    }
}
