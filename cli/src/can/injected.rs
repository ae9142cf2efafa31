//! The faults that `linewright fail` injects: their names on the command line, and the objects that it writes to a simulated device for each.

use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::PossibleValue;
use linewright_plant::{CLEAR, CLEAR_WORD, DeviceFault, FrameFaults, InputFault, MotionFault, ObjectWrites};

/// Fault to inject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InjectedFault {
    /// With one motion.
    Motion(MotionFault),
    /// With one input.
    Input(InputFault),
    /// With a whole device.
    Device(DeviceTrouble),
    /// All is well again.
    Clear,
}

/// Fault of a whole device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DeviceTrouble {
    /// The device neither sends nor receives
    Silent,
    /// The device boots
    Reboot,
    /// The device boots and does not come up
    NoBoot,
    /// The device sends no heartbeat; all else goes on
    NoHeartbeat,
    /// The device boots with another product code (object 1018h:02)
    Identity,
    /// The device boots and refuses its heartbeat time (object 1017h)
    Refuse,
    /// The device reports an overload of its outputs (emergency 2310h)
    Emergency,
    /// The device is off the bus for a second
    BusOff,
    /// Of the frames to and from the device 5 % are lost and 5 % doubled
    Lossy,
}

/// Every fault, in the order of the help.
static VARIANTS: LazyLock<Vec<InjectedFault>> = LazyLock::new(|| {
    let motions = MotionFault::ALL.into_iter().map(InjectedFault::Motion);
    let devices = DeviceTrouble::value_variants().iter().copied().map(InjectedFault::Device);
    let inputs = InputFault::ALL.into_iter().map(InjectedFault::Input);
    motions.chain(inputs).chain(devices).chain([InjectedFault::Clear]).collect()
});

impl ValueEnum for InjectedFault {
    fn value_variants<'a>() -> &'a [Self] {
        &VARIANTS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            InjectedFault::Motion(fault) => {
                Some(PossibleValue::new(fault.name()).help(fault.about().first()?.trim_end_matches('.')))
            }
            InjectedFault::Input(fault) => {
                Some(PossibleValue::new(fault.name()).help(fault.about().trim_end_matches('.')))
            }
            InjectedFault::Device(trouble) => trouble.to_possible_value(),
            InjectedFault::Clear => Some(PossibleValue::new(CLEAR_WORD).help("All is well again")),
        }
    }
}

impl InjectedFault {
    /// Its name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Fault of a motion (`Some(None)`: cleared), if it concerns one.
    pub fn of_a_motion(self) -> Option<Option<MotionFault>> {
        match self {
            InjectedFault::Clear => Some(None),
            InjectedFault::Motion(fault) => Some(Some(fault)),
            InjectedFault::Input(_) | InjectedFault::Device(_) => None,
        }
    }

    /// What happens to an input (`Some(None)`: nothing any more), if it happens to one.
    pub fn of_an_input(self) -> Option<Option<InputFault>> {
        match self {
            InjectedFault::Clear => Some(None),
            InjectedFault::Input(fault) => Some(Some(fault)),
            InjectedFault::Motion(_) | InjectedFault::Device(_) => None,
        }
    }

    /// Writes to the device, if it concerns a whole device. Those that take effect in a boot end with one.
    pub fn of_a_device(self) -> Option<ObjectWrites> {
        const HARDWARE: u32 = 0x0606_0000;
        let trouble = match self {
            InjectedFault::Clear => return Some(vec![CLEAR]),
            InjectedFault::Motion(_) | InjectedFault::Input(_) => return None,
            InjectedFault::Device(trouble) => trouble,
        };
        let faults = match trouble {
            DeviceTrouble::Silent => vec![DeviceFault::Silent],
            DeviceTrouble::Reboot => vec![DeviceFault::Reboot],
            DeviceTrouble::NoBoot => vec![DeviceFault::NoBoot],
            DeviceTrouble::NoHeartbeat => vec![DeviceFault::NoHeartbeat],
            DeviceTrouble::Identity => {
                vec![DeviceFault::Identity { object: (0x1018, 2), value: 0xFFFF }, DeviceFault::Reboot]
            }
            DeviceTrouble::Refuse => {
                let object = (0x1017, 0);
                let refusal = DeviceFault::Abort { object, code: HARDWARE, reading: false, writing: true };
                vec![refusal, DeviceFault::Reboot]
            }
            DeviceTrouble::Emergency => vec![DeviceFault::Emergency { code: 0x2310, register: 5 }],
            DeviceTrouble::BusOff => vec![DeviceFault::BusOff { millis: 1000 }],
            DeviceTrouble::Lossy => {
                let faults = FrameFaults { lost_to: 50, lost_from: 50, doubled: 50, ..FrameFaults::default() };
                return Some(faults.orders());
            }
        };
        Some(faults.into_iter().flat_map(DeviceFault::orders).collect())
    }
}
