//! How the motion is ended.

use super::integers::integers;

integers! {
    /// Quick stop.
    pub struct StopSettings {
        /// Deceleration of a quick stop.
        quick_stop_deceleration_deg_s2: 2000, "deg/s^2", 50, 100000, "full duty against the motion gives 2150 deg/s^2 and more";
        /// Time after which a quick stop ends with the bridge off, come what may.
        quick_stop_ms: 500, "ms", 20, 10000, "350 deg/s at this deceleration take 175 ms";
        /// After a quick stop that was asked for: 0 the bridge goes off, 1 the angle is held.
        quick_stop_hold: 0, "choice", 0, 1, "CiA 402, quick stop option code 2";
    }
}

integers! {
    /// The CAN bus.
    pub struct BusSettings {
        /// Number of this node.
        node_id: 1, "1", 1, 127, "CiA 301";
        /// Bit rate: 1000 or 500.
        bit_rate_kbit_s: 1000, "kbit/s", 500, 1000, "the widest that bxCAN has";
    }
}
