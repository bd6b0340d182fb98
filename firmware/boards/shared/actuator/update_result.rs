//! What the background task reports of an update.

use firmware::drive::StageError;

/// The end of an order of the drive (`firmware::drive::UpdateOrder`).
pub enum UpdateResult {
    /// An image was staged or not; its memory.
    Staged(&'static mut [i32], Result<(), StageError>),
    /// Whether the record is written that the image which runs is confirmed.
    Confirmed(bool),
    /// Whether the request to install the staged image is written.
    Requested(bool),
}
