//! Options of a run: chance, network, and the extent of its log.

use std::time::Duration;

use linewright_station_logic::Rules;

/// Effect of the network on messages between the nodes of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Network {
    /// Delay of every message.
    pub delay: Duration,
    /// Additional delay of a message at most, drawn for each alone.
    pub jitter: Duration,
    /// Reports, orders and images lost, in ‰. Inputs of people are not.
    pub loss_per_mille: u32,
    /// Numbered messages that arrive twice, in ‰.
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

/// Change of a network; a value not given stays.
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

/// Options of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimOptions {
    /// Seed of everything random.
    pub seed: u64,
    pub network: Network,
    /// Whether process images travel as they do on a shop floor, in frames on buses, in messages through the gateway, and
    /// every message whole and numbered. Otherwise images are there at once and a repetition costs next to nothing.
    pub frames: bool,
    /// With frames: network of process images between the gateway and the stations.
    pub images: Network,
    /// Largest deviation of a motion's duration from the description, as a fraction.
    pub variation: f64,
    /// The rules the station controllers keep. Anything but all of them is for seeing that they are needed.
    pub rules: Rules,
    /// Wake the receiver of every message, also of one without news. Slower, and the same run: a test holds the two
    /// against each other.
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
