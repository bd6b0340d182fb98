//! Tests of the device at frame level against CiA 301 and CiA 305.

mod bench;
mod block;
mod emergency;
mod filters;
mod heartbeat;
mod lss;
mod minimal;
mod nmt;
mod parameters;
mod pdo;
mod random;
mod sdo;
mod store;
mod sync;
mod transmission;

#[path = "../../examples/loopback/device.rs"]
mod device;
#[path = "../../examples/loopback/dictionary.rs"]
mod dictionary;
