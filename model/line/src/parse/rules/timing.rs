//! The line's time limits.

use std::time::Duration;

use linewright_text::{Located, Problem, Report};

use crate::Timing;
use crate::parse::draft::DraftLine;

/// A limit below twice its period would trip on a single late message.
const PERIODS_MIN: u32 = 2;

pub(super) fn limits_exceed_their_periods(draft: &DraftLine<'_>, report: &mut Report) {
    let (raw, default) = (&draft.raw.timing, Timing::default());
    let refresh = ("refresh_ms", &raw.refresh, default.refresh);
    let heartbeat = ("heartbeat_ms", &raw.heartbeat, default.heartbeat);
    let limits = [
        ("stale_ms", &raw.stale, default.stale, refresh),
        ("lease_ms", &raw.lease, default.lease, refresh),
        ("heartbeat_timeout_ms", &raw.heartbeat_timeout, default.heartbeat_timeout, heartbeat),
    ];
    for (name, limit, limit_default, (period_name, period, period_default)) in limits {
        let value = |written: &Option<Located<Duration>>, default| written.as_ref().map_or(default, |w| w.value);
        let (limit_value, period_value) = (value(limit, limit_default), value(period, period_default));
        if limit_value >= period_value * PERIODS_MIN {
            continue;
        }
        let Some(written) = limit.as_ref().or(period.as_ref()) else { continue };
        report.add(
            Problem::error(
                written.at.clone(),
                format!(
                    "`{name}` is {} ms, but `{period_name}` is {} ms",
                    limit_value.as_millis(),
                    period_value.as_millis()
                ),
            )
            .hint(format!("`{name}` must be at least twice `{period_name}`, or one late message trips it")),
        );
    }
}
