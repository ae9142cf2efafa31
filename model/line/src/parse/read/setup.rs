//! What a device has to be and is told, and what its trouble does: `identity`, `settings`, `on_emergency`, `when_lost`.

use linewright_text::{At, Fields, Report, Where};

use crate::Reaction;
use crate::parse::raw::{RawIdentity, RawSetting, RawTransmission, Width};

/// What trouble does to the owner.
pub(super) fn reaction(f: &mut Fields<'_>, key: &'static str, report: &mut Report) -> Option<At<Reaction>> {
    f.maybe_word(report, key, &[("fault", Reaction::Fault), ("report", Reaction::Report)])
}

pub(super) fn identity(mut f: Fields<'_>, report: &mut Report) -> RawIdentity {
    let keys = ["type", "vendor", "product", "revision", "serial"];
    let raw = RawIdentity(keys.map(|key| f.integer(report, key)));
    f.finish(report);
    raw
}

pub(super) fn transmission(mut f: Fields<'_>, report: &mut Report) -> (RawTransmission, Where) {
    let at = f.at.clone();
    let raw = RawTransmission { inputs: f.integer(report, "inputs"), outputs: f.integer(report, "outputs") };
    f.finish(report);
    (raw, at)
}

pub(super) fn setting(mut f: Fields<'_>, report: &mut Report) -> RawSetting {
    let width = |bytes, signed| Width { bytes, signed };
    // Four bytes first: what is not said is usual.
    let widths = [
        ("u32", width(4, false)),
        ("u8", width(1, false)),
        ("u16", width(2, false)),
        ("i8", width(1, true)),
        ("i16", width(2, true)),
        ("i32", width(4, true)),
    ];
    let raw = RawSetting {
        object: f.required_text(report, "object"),
        width: f.word(report, "type", &widths),
        value: f.required_integer(report, "value"),
    };
    f.finish(report);
    raw
}
