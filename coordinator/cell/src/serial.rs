//! Form of times, stations and rules in what is written down: microseconds, numbers, and the words of descriptions.
//!
//! The types of records and snapshots derive `serde`, independent of text or bytes. The types here come from crates
//! that do not.

/// A time, in microseconds.
pub(super) mod micros {
    use linewright_line::Tick;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(tick: &Tick, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_u64(tick.as_micros())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Tick, D::Error> {
        u64::deserialize(from).map(Tick::from_micros)
    }
}

/// A time that need not be.
pub(super) mod maybe {
    use linewright_line::Tick;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(tick: &Option<Tick>, to: S) -> Result<S::Ok, S::Error> {
        tick.map(Tick::as_micros).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Tick>, D::Error> {
        Ok(Option::<u64>::deserialize(from)?.map(Tick::from_micros))
    }
}

/// A random key, in hexadecimal digits.
pub(super) mod key {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(key: &u128, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(&format_args!("{key:032x}"))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<u128, D::Error> {
        let text = String::deserialize(from)?;
        u128::from_str_radix(&text, 16).map_err(|_| D::Error::custom(format!("`{text}` is no key")))
    }
}

/// A station, by its number in the table.
pub(super) mod station {
    use linewright_line::StationId;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(station: &StationId, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_u16(station.0)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<StationId, D::Error> {
        u16::deserialize(from).map(StationId)
    }
}

/// A rule, by its word.
pub(super) mod rule {
    use linewright_cell::DispatchRule;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(rule: &DispatchRule, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(rule)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<DispatchRule, D::Error> {
        let word = String::deserialize(from)?;
        let known = DispatchRule::ALL.iter().find(|(known, _)| *known == word);
        known.map(|&(_, rule)| rule).ok_or_else(|| D::Error::custom(format!("there is no rule `{word}`")))
    }
}
