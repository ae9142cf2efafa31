//! What a run may be told: chance, network, and how much to remember.

use std::time::Duration;

use linewright_station_logic::Rules;

/// What the network does to messages between the nodes of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Network {
    /// What every message takes.
    pub delay: Duration,
    /// What a message may take longer, drawn for each alone.
    pub jitter: Duration,
    /// How many of a thousand reports, orders and images are lost. Inputs of people are not.
    pub loss_per_mille: u32,
    /// How many of a thousand numbered messages arrive twice.
    pub double_per_mille: u32,
    /// Each message goes its own way: reports and images, which are read by their numbers, overtake each other, and held
    /// buttons, which are repeated, can get lost too.
    pub best_effort: bool,
}

impl Default for Network {
    /// One millisecond, nothing drawn, nothing lost.
    fn default() -> Self {
        Network {
            delay: Duration::from_millis(1),
            jitter: Duration::ZERO,
            loss_per_mille: 0,
            double_per_mille: 0,
            best_effort: false,
        }
    }
}

/// What changes about a network; whatever is not named stays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NetworkChange {
    /// See [`Network::delay`].
    pub delay: Option<Duration>,
    /// See [`Network::jitter`].
    pub jitter: Option<Duration>,
    /// See [`Network::loss_per_mille`].
    pub loss_per_mille: Option<u32>,
}

impl NetworkChange {
    /// The network that `before` becomes.
    pub fn of(self, before: Network) -> Network {
        Network {
            delay: self.delay.unwrap_or(before.delay),
            jitter: self.jitter.unwrap_or(before.jitter),
            loss_per_mille: self.loss_per_mille.unwrap_or(before.loss_per_mille),
            ..before
        }
    }
}

/// What a run may be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimOptions {
    /// What everything random follows from.
    pub seed: u64,
    pub network: Network,
    /// Whether process images travel as they do on a shop floor, in frames on buses, in messages through the gateway, and
    /// every message whole and numbered. Otherwise images are there at once and a repetition costs next to nothing.
    pub frames: bool,
    /// With frames: what the network does to process images between the gateway and the stations.
    pub images: Network,
    /// How far a motion's duration may deviate from the description, as a fraction.
    pub variation: f64,
    /// The rules the station controllers keep. Anything but all of them is for seeing that they are needed.
    pub rules: Rules,
    /// Wake the receiver of every message, also of one that says nothing new. Slower, and the same run: a test holds
    /// the two against each other.
    pub one_by_one: bool,
    /// Keep the log of everything that happened.
    pub keeps_log: bool,
}

impl Default for SimOptions {
    fn default() -> Self {
        SimOptions {
            seed: 1,
            network: Network::default(),
            frames: false,
            images: Network::default(),
            variation: 0.0,
            rules: Rules::default(),
            one_by_one: false,
            keeps_log: false,
        }
    }
}
