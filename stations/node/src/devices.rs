//! The devices on the buses of the station's own.

use linewright_fieldbus_seam::News;
use linewright_line::{Owner, Tick};
use linewright_node_line::devices::DeviceServiceRequest;
use linewright_station_shell::StationArrival;

use crate::node::StationLoop;

impl StationLoop {
    pub(crate) fn bus_news(&mut self, news: &[News]) {
        for one in news {
            match one {
                News::InputsChanged { .. } | News::Answered => {}
                News::Ignored(what) => self.ignore(what),
                News::Noted(what) => tracing::info!(station = self.name, "{what}"),
            }
        }
        if let (Some(devices), Some(buses)) = (&mut self.devices, &mut self.buses) {
            devices.bus_news(news, buses);
        }
        self.tell_trouble(self.clock.now());
        if let Some(buses) = &mut self.buses {
            let image = buses.take_inputs(Owner::Station(self.station));
            let losses = u64::from(image.losses);
            self.handle(StationArrival::Devices { bits: image.bits, valid: image.valid, losses });
        }
    }

    /// Publishes the faults of the devices on its own bus, if it has one.
    pub(crate) fn tell_trouble(&mut self, now: Tick) {
        if let (Some(trouble), Some(buses)) = (&mut self.trouble, &self.buses) {
            trouble.act(now, buses);
            self.words.trouble(trouble.text());
        }
    }

    pub(crate) fn asked(&mut self, asked: DeviceServiceRequest) {
        if let (Some(devices), Some(buses)) = (&mut self.devices, &mut self.buses) {
            devices.ask(asked, buses);
        }
    }
}
