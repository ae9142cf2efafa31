//! A station behind the gateway: what it is told of its inputs, and what the bus puts out for it.
//!
//! Only what was told last is kept here, so that nothing is told twice. Which outputs may be in force, the coordinator's
//! logic says.

use linewright_fieldbus::Driver;
use linewright_line::{Line, Owner, StationId};
use linewright_msgs::ProcessImage;
use linewright_node_shell::{NewestBySequence, Node, TopicError, stamp};
use linewright_station_node::devices::Trouble;

/// What an input message says, for telling whether it would say anything new.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ToldInputs {
    pub bits: u128,
    pub valid: bool,
    /// The life of the devices, and of the process that tells of them.
    pub lives: u64,
    /// The output image that was in force meanwhile: who sent it, and its number.
    pub under: Option<(u64, u64)>,
}

impl ToldInputs {
    pub fn message(self, boot_id: u64, sequence: u64) -> ProcessImage {
        let (number_boot_id, number) = self.under.unwrap_or_default();
        let (valid, lives) = (self.valid, self.lives);
        let header = stamp();
        let mut message =
            ProcessImage { header, boot_id, sequence, valid, lives, number, number_boot_id, ..ProcessImage::default() };
        message.set_word(self.bits);
        message
    }
}

/// A station behind the gateway.
pub struct Behind {
    pub station: StationId,
    /// Its newest output image by sequence.
    pub newest: NewestBySequence,
    /// What it is told of its devices.
    pub trouble: Trouble,
    /// What the bus was last told to put out, and in which life of the devices.
    put: Option<(u128, u64)>,
    /// What the station was last told of its inputs.
    told: Option<ToldInputs>,
}

impl Behind {
    pub fn open(node: &mut Node, line: &Line, station: StationId) -> Result<Self, TopicError> {
        let topic = format!("{}/trouble", line.station(station).name);
        let trouble = Trouble::open(node, &topic, Owner::Station(station))?;
        Ok(Behind { station, newest: NewestBySequence::new(), trouble, put: None, told: None })
    }

    /// Has the bus put out what is in force. After a loss it has forgotten what it was told, so it is told again.
    pub fn put_out(&mut self, driver: &mut Driver, bits: u128, lives: u64) {
        if self.put != Some((bits, lives)) {
            driver.set_outputs(Owner::Station(self.station), bits);
            self.put = Some((bits, lives));
        }
    }

    /// Whether the station has to be told, because something is new or it is `due`.
    pub fn is_news(&mut self, news: ToldInputs, due: bool) -> bool {
        self.told.replace(news) != Some(news) || due
    }
}
