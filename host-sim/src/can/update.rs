//! Update of a node's program (CiA 302-3): an image to 1F50h:1, then its start by 1F51h:1.

use std::io;
use std::time::{Duration, Instant};

use bootloader::{Header, waiting::FlashStatus};
use canopen::{Abort, cob_id::HEARTBEAT};
use embedded_can::Frame;

use super::link::Link;
use super::sdo::{Sdo, SdoError};

/// Why a node was not updated.
#[derive(Debug, thiserror::Error)]
pub enum UpdateError {
    /// A transfer failed.
    #[error(transparent)]
    Sdo(#[from] SdoError),
    /// The bus failed.
    #[error("the bus: {0}")]
    Link(#[from] io::Error),
    /// The node takes no program.
    #[error("node {0} has no bootloader")]
    NoBootloader(u8),
    /// The image is for another device.
    #[error("the image is for hardware {image:#06x}, node {node} is {found:#06x}")]
    Hardware {
        /// The node.
        node: u8,
        /// The product code that the image names.
        image: u32,
        /// The product code of the node, object 1018h:2.
        found: u32,
    },
    /// The node has refused the image.
    #[error("node {node} refuses the image: {}", status_text(*status))]
    Refused {
        /// The node.
        node: u8,
        /// Its flash status, object 1F57h:1.
        status: u32,
    },
    /// The program of the node has not confirmed itself yet.
    #[error(
        "the program of node {0} is on trial: it takes another one once it has confirmed itself"
    )]
    OnTrial(u8),
    /// The node has not written the image.
    #[error("node {0} did not write the image within {limit} s", limit = STAGING.as_secs())]
    NotStaged(u8),
    /// The node runs another program than the one that it was given.
    #[error("node {0} went back to its program before: the new one failed its self-test")]
    RolledBack(u8),
    /// The node did not start again.
    #[error("node {0} did not start again within {limit} s", limit = RESTART.as_secs())]
    Silent(u8),
}

impl UpdateError {
    /// Whether the node has refused.
    pub fn is_refusal(&self) -> bool {
        matches!(
            self,
            Self::Refused { .. } | Self::OnTrial(_) | Self::Sdo(SdoError::Abort { .. })
        )
    }
}

fn status_text(status: u32) -> &'static str {
    const NO_VALID_PROGRAM: u32 = FlashStatus::NoValidProgram as u32;
    const WRITE_ERROR: u32 = FlashStatus::WriteError as u32;
    match status >> 1 & 0x7f {
        NO_VALID_PROGRAM => {
            "it does not fit, is damaged, is older than the program before, or is not signed by the \
             right key"
        }
        WRITE_ERROR => "the flash cannot be written",
        _ => "for an unknown reason",
    }
}

/// The time in which a node installs an image and starts again: some 10 s, and more on a board that
/// is emulated slower than in real time.
const RESTART: Duration = Duration::from_secs(60);

/// Longest time for which a request of the installation is repeated: that of a quick stop, twice.
const COMING_TO_REST: Duration = Duration::from_secs(1);

/// The time in which a program that drives writes an image.
const STAGING: Duration = Duration::from_secs(60);

/// The time in which a new program confirms itself, or is rolled back.
const TRIAL: Duration = Duration::from_secs(30);

/// Time between two requests of the flash status.
const POLL: Duration = Duration::from_millis(100);

/// Identity of a node: its product code.
const PRODUCT: (u16, u8) = (0x1018, 2);
const PROGRAM_DATA: (u16, u8) = (0x1f50, 1);
const PROGRAM_CONTROL: (u16, u8) = (0x1f51, 1);
const PROGRAM_IDENTITY: (u16, u8) = (0x1f56, 1);
const FLASH_STATUS: (u16, u8) = (0x1f57, 1);
const KEPT_IMAGE: (u16, u8) = (0x2104, 1);
const KEPT_BYTES: (u16, u8) = (0x2104, 2);
const NEXT_OFFSET: (u16, u8) = (0x2104, 3);

/// Bits of the flash status: the flash is being written, and the program is on trial.
const BUSY: u32 = 1;
const TRIAL_RUNS: u32 = 1 << 24;

/// What 1F51h:1 reads of a program that runs, and not of a waiting bootloader.
const STARTED: u32 = 1;

/// Loads an image into a node, has it installed, and waits until the new program has confirmed
/// itself. `progress` receives how many bytes the node has. A node that drives takes the image
/// meanwhile; it is to be without power, and at rest, when the image is there. A download of this
/// image that was broken off before is continued, and one that is complete is not repeated.
///
/// # Errors
/// [`UpdateError`]. The node runs its program on, or waits for another image.
pub fn update(
    link: &mut dyn Link,
    node: u8,
    (header, image): (&Header, &[u8]),
    progress: &mut dyn FnMut(usize),
) -> Result<(), UpdateError> {
    let mut sdo = Sdo::new(link, node);
    let (index, sub) = PROGRAM_DATA;
    sdo.abort(index, sub)?;
    let state = match number(&mut sdo, PROGRAM_CONTROL) {
        Err(SdoError::Abort { .. }) => return Err(UpdateError::NoBootloader(node)),
        other => other?,
    };
    if state == STARTED && number(&mut sdo, PROGRAM_IDENTITY)? == 0 {
        return Err(UpdateError::NoBootloader(node));
    }
    let found = number(&mut sdo, PRODUCT)?;
    if found != header.hardware {
        let image = header.hardware;
        return Err(UpdateError::Hardware { node, image, found });
    }
    let loaded = load(&mut sdo, header, image, progress);
    if let Err(error) = loaded {
        return Err(why(&mut sdo, node).unwrap_or(error.into()));
    }
    wait_for_staging(&mut sdo, node)?;
    if let Err(error) = start(&mut sdo) {
        return Err(why(&mut sdo, node).unwrap_or(error.into()));
    }
    wait_for_boot_up(link, node)?;
    wait_for_confirmation(&mut Sdo::new(link, node), node, header)
}

/// Loads what the node does not have of the image.
fn load(
    sdo: &mut Sdo<'_>,
    header: &Header,
    image: &[u8],
    progress: &mut dyn FnMut(usize),
) -> Result<(), SdoError> {
    let kept = kept(sdo, header)?.min(image.len());
    let rest = image.get(kept..).unwrap_or_default();
    if kept > 0 {
        progress(kept);
    }
    if rest.is_empty() {
        return Ok(());
    }
    if kept > 0 {
        let (index, sub) = NEXT_OFFSET;
        sdo.download(index, sub, &(kept as u32).to_le_bytes())?;
    }
    sdo.download_block(PROGRAM_DATA, rest, &mut |bytes| progress(kept + bytes))
}

/// Bytes of this image that the node has already.
fn kept(sdo: &mut Sdo<'_>, header: &Header) -> Result<usize, SdoError> {
    match number(sdo, KEPT_IMAGE) {
        Ok(identity) if identity == header.identity() => Ok(number(sdo, KEPT_BYTES)? as usize),
        // An earlier program has no such object.
        Ok(_) | Err(SdoError::Abort { .. }) => Ok(0),
        Err(error) => Err(error),
    }
}

/// Waits until the image is written.
fn wait_for_staging(sdo: &mut Sdo<'_>, node: u8) -> Result<(), UpdateError> {
    let end = Instant::now() + STAGING;
    while Instant::now() < end {
        let status = number(sdo, FLASH_STATUS)?;
        if status & BUSY == 0 {
            return if status >> 1 & 0x7f == 0 {
                Ok(())
            } else {
                Err(UpdateError::Refused { node, status })
            };
        }
        std::thread::sleep(POLL);
    }
    Err(UpdateError::NotStaged(node))
}

/// Requests the installation. It is refused while the shaft is not at rest, which may pass.
fn start(sdo: &mut Sdo<'_>) -> Result<(), SdoError> {
    let end = Instant::now() + COMING_TO_REST;
    let (index, sub) = PROGRAM_CONTROL;
    loop {
        match sdo.download(index, sub, &[1]) {
            Err(SdoError::Abort { code, .. })
                if code == Abort::DeviceState.code() && Instant::now() < end =>
            {
                std::thread::sleep(POLL);
            }
            done => return done,
        }
    }
}

/// Waits until the program that runs is the one of this header, and confirmed. Starts in between
/// leave a request without an answer.
fn wait_for_confirmation(sdo: &mut Sdo<'_>, node: u8, header: &Header) -> Result<(), UpdateError> {
    let end = Instant::now() + TRIAL;
    while Instant::now() < end {
        let (Ok(state), Ok(identity), Ok(status)) = (
            number(sdo, PROGRAM_CONTROL),
            number(sdo, PROGRAM_IDENTITY),
            number(sdo, FLASH_STATUS),
        ) else {
            continue;
        };
        if state == STARTED && status & TRIAL_RUNS == 0 {
            return if identity == header.identity() {
                Ok(())
            } else {
                Err(UpdateError::RolledBack(node))
            };
        }
        std::thread::sleep(POLL);
    }
    Err(UpdateError::Silent(node))
}

fn number(sdo: &mut Sdo<'_>, (index, sub): (u16, u8)) -> Result<u32, SdoError> {
    let bytes = sdo.upload(index, sub)?;
    let number = bytes.iter().rev();
    Ok(number.fold(0, |number, byte| number << 8 | u32::from(*byte)))
}

/// The reason in the flash status, if any.
fn why(sdo: &mut Sdo<'_>, node: u8) -> Option<UpdateError> {
    let status = number(sdo, FLASH_STATUS).ok()?;
    match status {
        _ if status >> 1 & 0x7f != 0 => Some(UpdateError::Refused { node, status }),
        _ if status & TRIAL_RUNS != 0 => Some(UpdateError::OnTrial(node)),
        _ => None,
    }
}

fn wait_for_boot_up(link: &mut dyn Link, node: u8) -> Result<(), UpdateError> {
    let end = Instant::now() + RESTART;
    loop {
        let left = end.saturating_duration_since(Instant::now());
        let Some(frame) = link.receive(left)? else {
            return Err(UpdateError::Silent(node));
        };
        let is_boot_up = frame.raw_id() == (HEARTBEAT + u32::from(node), false)
            && frame.dlc() == 1
            && frame.bytes()[0] == 0;
        if is_boot_up {
            return Ok(());
        }
    }
}
