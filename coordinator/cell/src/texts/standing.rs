//! How the stations of a failed activity stand.

/// Standing of a station of a failed activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationStanding {
    /// In an emergency stop of its own.
    EmergencyStop,
    /// Its order is done.
    Done,
    AtRest,
    /// Between two rests.
    Held,
    /// Still at its order, which it goes back from, or ends, in auto.
    AtOrder,
    /// Not reported at rest in time.
    Unknown,
    /// Its order store was reset.
    StoreReset,
    /// Its order was not begun.
    NotBegun,
}

impl StationStanding {
    /// The text, behind the station's name.
    pub const fn text(self) -> &'static str {
        match self {
            StationStanding::EmergencyStop => "in emergency stop",
            StationStanding::Done => "order done",
            StationStanding::AtRest => "at rest",
            StationStanding::Held => "stopped between two rests",
            StationStanding::AtOrder => {
                "still at its order, which it ends in auto; if it stands there, stop and lead it in manual"
            }
            StationStanding::Unknown => "rest not confirmed",
            StationStanding::StoreReset => "restarted without its memory of orders",
            StationStanding::NotBegun => "order not begun",
        }
    }
}
