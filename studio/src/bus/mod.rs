//! The bus: one thread receives, every thread sends, and requests to nodes wait for their responses
//! beside the telemetry.

pub mod decode;
pub mod hub;
pub mod lss;
pub mod statistics;

pub use hub::HubLink;
