//! The services a line's devices are reached by: those of the ROS 2 package `ros2_canopen`, so that its users' scripts work.
//!
//! Each is two messages, request and response. Their `.srv` files belong to other packages; `tests/msg_files.rs` has
//! their text.

use crate::describe::RosMessage;
use crate::macros::{message, service};

/// A service: what is asked, and what is answered.
pub trait RosService: Send + Sync + 'static {
    /// ROS 2 package.
    const PACKAGE: &'static str;
    /// Name within the package.
    const NAME: &'static str;
    /// What is asked.
    type Request: RosMessage + Clone;
    /// What is answered.
    type Response: RosMessage;
}

service! {
    /// `std_srvs/Trigger`.
    "std_srvs" / Trigger = TriggerRequest -> TriggerResponse
}

message! {
    /// Nothing is asked but that it be done. ROS 2 gives an empty message one byte.
    "std_srvs" / TriggerRequest
    fields {
        /// Says nothing.
        structure_needs_at_least_one_member: u8,
    }
    ros name "Trigger_Request", meaning |_| Ok(())
}

message! {
    /// Whether it was done, and if not why.
    "std_srvs" / TriggerResponse
    fields {
        /// It was done.
        success: bool,
        /// Result in a sentence.
        message: String,
    }
    ros name "Trigger_Response", meaning |_| Ok(())
}

service! {
    /// `canopen_interfaces/CORead`: an object of the device whose service it is.
    "canopen_interfaces" / CORead = CoReadRequest -> CoReadResponse
}

message! {
    /// Which object.
    "canopen_interfaces" / CoReadRequest
    fields {
        /// Index.
        index: u16,
        /// Subindex.
        subindex: u8,
    }
    ros name "CORead_Request", meaning |_| Ok(())
}

message! {
    /// Its value.
    "canopen_interfaces" / CoReadResponse
    fields {
        /// It was read.
        success: bool,
        /// Its value; if it was not read, the abort code (CiA 301 table 22) that says why.
        data: u32,
    }
    ros name "CORead_Response", meaning |_| Ok(())
}

service! {
    /// `canopen_interfaces/COWrite`.
    "canopen_interfaces" / COWrite = CoWriteRequest -> CoWriteResponse
}

message! {
    /// Which object, and its new value.
    "canopen_interfaces" / CoWriteRequest
    fields {
        /// Index.
        index: u16,
        /// Subindex.
        subindex: u8,
        /// The value; of a shorter object the low bytes.
        data: u32,
    }
    ros name "COWrite_Request", meaning |_| Ok(())
}

message! {
    /// Whether it was written.
    "canopen_interfaces" / CoWriteResponse
    fields {
        /// It was.
        success: bool,
    }
    ros name "COWrite_Response", meaning |_| Ok(())
}

service! {
    /// `canopen_interfaces/COReadID`: an object of any device of the bus.
    "canopen_interfaces" / COReadID = CoReadIdRequest -> CoReadIdResponse
}

message! {
    /// Which object of which device.
    "canopen_interfaces" / CoReadIdRequest
    constants {
        /// One byte with sign.
        const CANOPEN_DATATYPE_INT8: u8 = 2;
        /// Two.
        const CANOPEN_DATATYPE_INT16: u8 = 3;
        /// Four.
        const CANOPEN_DATATYPE_INT32: u8 = 4;
        /// One byte.
        const CANOPEN_DATATYPE_UINT8: u8 = 5;
        /// Two.
        const CANOPEN_DATATYPE_UINT16: u8 = 6;
        /// Four.
        const CANOPEN_DATATYPE_UINT32: u8 = 7;
    }
    fields {
        /// The device.
        nodeid: u8,
        /// Index.
        index: u16,
        /// Subindex.
        subindex: u8,
        /// How long it is.
        canopen_datatype: u8,
    }
    ros name "COReadID_Request", meaning |_| Ok(())
}

message! {
    /// Its value.
    "canopen_interfaces" / CoReadIdResponse
    fields {
        /// It was read.
        success: bool,
        /// Its value; if it was not read, the abort code that says why.
        data: u32,
    }
    ros name "COReadID_Response", meaning |_| Ok(())
}

service! {
    /// `canopen_interfaces/COWriteID`.
    "canopen_interfaces" / COWriteID = CoWriteIdRequest -> CoWriteIdResponse
}

message! {
    /// Which object of which device, and its new value.
    "canopen_interfaces" / CoWriteIdRequest
    constants {
        /// One byte with sign.
        const CANOPEN_DATATYPE_INT8: u8 = 2;
        /// Two.
        const CANOPEN_DATATYPE_INT16: u8 = 3;
        /// Four.
        const CANOPEN_DATATYPE_INT32: u8 = 4;
        /// One byte.
        const CANOPEN_DATATYPE_UINT8: u8 = 5;
        /// Two.
        const CANOPEN_DATATYPE_UINT16: u8 = 6;
        /// Four.
        const CANOPEN_DATATYPE_UINT32: u8 = 7;
    }
    fields {
        /// The device; with a sign, as published.
        nodeid: i8,
        /// Index.
        index: u16,
        /// Subindex.
        subindex: u8,
        /// The value.
        data: u32,
        /// How long it is.
        canopen_datatype: u8,
    }
    ros name "COWriteID_Request", meaning |_| Ok(())
}

message! {
    /// Whether it was written.
    "canopen_interfaces" / CoWriteIdResponse
    fields {
        /// It was.
        success: bool,
    }
    ros name "COWriteID_Response", meaning |_| Ok(())
}
