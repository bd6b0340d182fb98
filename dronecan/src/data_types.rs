//! The data types of the DroneCAN standard set that an actuator uses: identifiers and signatures.

use crate::Kind;

/// A data type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataType {
    /// Its identifier, among messages or among services.
    pub id: u16,
    /// Hash of its definition, with which the CRC of its transfers begins.
    pub signature: u64,
}

macro_rules! data_types {
    ($($(#[doc = $doc:literal])+ $NAME:ident = $id:literal, $signature:literal;)+) => {
        $(
            $(#[doc = $doc])+
            pub const $NAME: DataType = DataType {
                id: $id,
                signature: $signature,
            };
        )+
    };
}

data_types! {
    /// `uavcan.protocol.dynamic_node_id.Allocation`, a message.
    ALLOCATION = 1, 0x0b2a_8126_20a1_1d40;
    /// `uavcan.protocol.NodeStatus`, a message.
    NODE_STATUS = 341, 0x0f08_68d0_c1a7_c6f1;
    /// `uavcan.equipment.actuator.ArrayCommand`, a message.
    ARRAY_COMMAND = 1010, 0xd8a7_4862_38ec_3af3;
    /// `uavcan.equipment.actuator.Status`, a message.
    ACTUATOR_STATUS = 1011, 0x5e9b_ba44_faf1_ea04;
    /// `uavcan.equipment.power.CircuitStatus`, a message.
    CIRCUIT_STATUS = 1091, 0x8313_d33d_0ddd_a115;
    /// `uavcan.equipment.device.Temperature`, a message.
    TEMPERATURE = 1110, 0x7026_1c28_a941_44c6;
    /// `uavcan.protocol.debug.LogMessage`, a message.
    LOG_MESSAGE = 16383, 0xd654_a48e_0c04_9d75;
    /// `uavcan.protocol.GetNodeInfo`, a service.
    GET_NODE_INFO = 1, 0xee46_8a81_21c4_6a9e;
    /// `uavcan.protocol.RestartNode`, a service.
    RESTART_NODE = 5, 0x569e_0539_4a30_17f0;
    /// `uavcan.protocol.param.ExecuteOpcode`, a service.
    EXECUTE_OPCODE = 10, 0x3b13_1ac5_eb69_d2cd;
    /// `uavcan.protocol.param.GetSet`, a service.
    GET_SET = 11, 0xa7b6_22f9_39d1_a4d5;
    /// `uavcan.protocol.file.BeginFirmwareUpdate`, a service.
    BEGIN_FIRMWARE_UPDATE = 40, 0xb7d7_25df_7272_4126;
    /// `uavcan.protocol.file.Read`, a service.
    FILE_READ = 48, 0x8dcd_ca93_9f33_f678;
}

/// The data type of a transfer that a node receives; `None` for all others.
pub(crate) fn received(kind: Kind) -> Option<DataType> {
    let (types, id): (&[DataType], u16) = match kind {
        Kind::Message(id) => (&[ALLOCATION, ARRAY_COMMAND], id),
        Kind::Request { service, .. } => (
            &[
                GET_NODE_INFO,
                RESTART_NODE,
                EXECUTE_OPCODE,
                GET_SET,
                BEGIN_FIRMWARE_UPDATE,
            ],
            service.into(),
        ),
        Kind::Response { service, .. } => (&[FILE_READ], service.into()),
    };
    types.iter().copied().find(|data_type| data_type.id == id)
}
