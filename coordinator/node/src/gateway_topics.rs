//! A station behind the gateway, as far as ROS 2 sees it: the message with its inputs, and the diagnostics of its devices.

use linewright_coordinator_logic::OutputImage;
use linewright_coordinator_shell::InputsImage;
use linewright_line::{Line, Owner, StationId};
use linewright_msgs::ProcessImage;
use linewright_node_line::devices::DeviceDiagnosticsTopic;
use linewright_node_line::{ConvertError, of_this_description};
use linewright_node_shell::{RosNode, TopicError, stamp};

/// The message that carries a station's inputs.
pub fn inputs_message(image: InputsImage, boot_id: u64, sequence: u64, description: u64) -> ProcessImage {
    let (number_boot_id, number) = image.under.unwrap_or_default();
    let InputsImage { bits, valid, lives, .. } = image;
    let mut message = ProcessImage {
        header: stamp(),
        boot_id,
        sequence,
        description,
        valid,
        lives,
        number,
        number_boot_id,
        ..ProcessImage::default()
    };
    message.set_word(bits);
    message
}

/// The outputs of the station of this name, from its message.
///
/// # Errors
/// When the message has another fingerprint of the description than this.
pub fn outputs_from_message(
    station: &str,
    description: u64,
    message: &ProcessImage,
) -> Result<OutputImage, ConvertError> {
    of_this_description(station, message.description, description)?;
    Ok(OutputImage {
        bits: message.word(),
        valid: message.valid,
        losses: message.lives,
        boot_id: message.boot_id,
        number: message.number,
        mode_epoch: message.mode_epoch,
    })
}

/// A station behind the gateway.
pub struct GatewayTopics {
    pub station: StationId,
    /// Diagnostics of its devices.
    pub trouble: DeviceDiagnosticsTopic,
}

impl GatewayTopics {
    pub fn open(node: &mut RosNode, line: &Line, station: StationId) -> Result<Self, TopicError> {
        let topic = format!("{}/trouble", line.station(station).name);
        let trouble = DeviceDiagnosticsTopic::open(node, &topic, Owner::Station(station), "coordinator")?;
        Ok(GatewayTopics { station, trouble })
    }
}
