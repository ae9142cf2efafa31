//! Times as people write and read them.
//!
//! Events have microseconds, of the calendar or since a simulation began. What is written without an offset is local time;
//! a local time that is there twice, when clocks go back, is the first of the two.

use chrono::{DateTime, Local, NaiveDate, NaiveDateTime, NaiveTime, SecondsFormat, TimeZone, Utc};
use linewright_history::TimeBase;
use linewright_line::Tick;
use miette::{IntoDiagnostic, miette};

/// Time zone of times of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zone {
    /// Greenwich, without summer time.
    Utc,
    /// Here.
    Local,
}

/// Parses a time.
pub fn parse(text: &str, clock: TimeBase, zone: Zone) -> miette::Result<Tick> {
    match clock {
        TimeBase::Simulated => seconds(text),
        TimeBase::Unix => calendar(text, zone),
    }
}

fn seconds(text: &str) -> miette::Result<Tick> {
    let seconds: f64 = text
        .strip_suffix('s')
        .unwrap_or(text)
        .trim()
        .parse()
        .map_err(|_| miette!("`{text}` is not a number of seconds, and this is the database of a simulation"))?;
    if (0.0..=1e12).contains(&seconds) {
        Ok(Tick::from_micros((seconds * 1e6).round() as u64))
    } else {
        Err(miette!("`{text}`: a simulation has between 0 and 10¹² seconds"))
    }
}

fn calendar(text: &str, zone: Zone) -> miette::Result<Tick> {
    let instant = match DateTime::parse_from_rfc3339(text) {
        Ok(instant) => instant.with_timezone(&Utc),
        Err(_) => {
            let naive = naive(text)
                .ok_or_else(|| miette!("`{text}` is no time; write 2026-11-22T06:00:00+01:00, or 2026-11-22 06:00"))?;
            let there = match zone {
                Zone::Utc => Some(naive.and_utc()),
                Zone::Local => Local.from_local_datetime(&naive).earliest().map(|local| local.with_timezone(&Utc)),
            };
            there.ok_or_else(|| miette!("there is no {text} here: clocks go forward over it"))?
        }
    };
    u64::try_from(instant.timestamp_micros()).map(Tick::from_micros).into_diagnostic()
}

/// A time without an offset; the day alone is its beginning.
fn naive(text: &str) -> Option<NaiveDateTime> {
    let text = text.trim().replacen('T', " ", 1);
    let with_time = ["%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%d %H:%M"];
    with_time
        .iter()
        .find_map(|form| NaiveDateTime::parse_from_str(&text, form).ok())
        .or_else(|| NaiveDate::parse_from_str(&text, "%Y-%m-%d").ok().map(|day| day.and_time(NaiveTime::MIN)))
}

/// A time for people and machines: RFC 3339, or seconds of a simulation.
pub fn show(tick: Tick, clock: TimeBase, zone: Zone) -> String {
    let seconds = || format!("{:.3} s", tick.as_secs_f64());
    let utc = i64::try_from(tick.as_micros()).ok().and_then(DateTime::from_timestamp_micros);
    match (clock, utc, zone) {
        (TimeBase::Simulated, ..) | (TimeBase::Unix, None, _) => seconds(),
        (TimeBase::Unix, Some(utc), Zone::Utc) => utc.to_rfc3339_opts(SecondsFormat::Millis, true),
        (TimeBase::Unix, Some(utc), Zone::Local) => {
            utc.with_timezone(&Local).to_rfc3339_opts(SecondsFormat::Millis, false)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_what_is_shown() {
        // 2026-11-22 05:00:00 UTC, by `date -u -d @1795323600`.
        let tick = Tick::from_micros(1_795_323_600_000_000);
        for text in ["2026-11-22T05:00:00Z", "2026-11-22T06:00:00+01:00", "2026-11-21T23:00:00.000-06:00"] {
            assert_eq!(parse(text, TimeBase::Unix, Zone::Local).unwrap(), tick, "{text}");
        }
        for text in ["2026-11-22 05:00", "2026-11-22T05:00:00", "2026-11-22 05:00:00.000"] {
            assert_eq!(parse(text, TimeBase::Unix, Zone::Utc).unwrap(), tick, "{text}");
        }
        assert_eq!(show(tick, TimeBase::Unix, Zone::Utc), "2026-11-22T05:00:00.000Z");
        let day = parse("2026-11-22", TimeBase::Unix, Zone::Utc).unwrap();
        assert_eq!(tick.since(day), std::time::Duration::from_secs(5 * 3600));
        // Wherever this runs, local time is there and back the same.
        let local = show(tick, TimeBase::Unix, Zone::Local);
        assert_eq!(parse(&local, TimeBase::Unix, Zone::Local).unwrap(), tick);
        assert_eq!(parse(&local[..23], TimeBase::Unix, Zone::Local).unwrap(), tick, "{local}");
        for text in ["yesterday", "2026-13-01", "2026-11-22 25:00", "", "1960-01-01"] {
            assert!(parse(text, TimeBase::Unix, Zone::Utc).is_err(), "{text}");
        }
    }

    #[test]
    fn a_simulation_has_seconds() {
        assert_eq!(parse("12.5", TimeBase::Simulated, Zone::Utc).unwrap(), Tick::from_millis(12_500));
        assert_eq!(parse("12.5 s", TimeBase::Simulated, Zone::Utc).unwrap(), Tick::from_millis(12_500));
        assert_eq!(show(Tick::from_millis(12_500), TimeBase::Simulated, Zone::Local), "12.500 s");
        for text in ["2026-11-22", "-1", "NaN", "inf"] {
            assert!(parse(text, TimeBase::Simulated, Zone::Utc).is_err(), "{text}");
        }
    }
}
