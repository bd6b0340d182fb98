//! `actuator update`: a new program over the bus.

use std::path::PathBuf;

use bootloader::layout::STM32F427;
use clap::Args;
use host_sim::can::client::Client;
use host_sim::can::update::update;
use program_image::signed::{SignError, inspect};

use super::{AtNode, service::ServiceAccess};
use crate::error::Error;
use crate::image;
use crate::output::{self, print};

/// Loads a signed image into an actuator and has its bootloader install it
///
/// The image is checked before: it must be whole, and for this hardware. The bootloader checks its
/// signature and that it is not older than the program before.
#[derive(Debug, Args)]
pub struct Update {
    /// The image, made by `actuator image sign`
    image: PathBuf,
    #[command(flatten)]
    access: ServiceAccess,
    #[command(flatten)]
    at: AtNode,
}

impl Update {
    /// Loads the image, and waits until the actuator has started again.
    ///
    /// # Errors
    /// For an image that is damaged or refused; those of the bus.
    pub fn run(self) -> Result<(), Error> {
        let path = &self.image;
        let image = image::read(path)?;
        let header = inspect(&image, &STM32F427).map_err(|refusal| SignError::Refused {
            path: path.clone(),
            refusal,
        })?;
        let mut client: Client = self.at.open()?;
        let node = client.node();
        let bar = output::progress(image.len() as u64, "bytes");
        let mut progress = |bytes: usize| bar.set_position(bytes as u64);
        self.access.during(&mut client, |client| {
            let image = (&header, image.as_slice());
            Ok(update(client.link(), node, image, &mut progress)?)
        })?;
        bar.finish_and_clear();
        print(&format!("node {node} has version {}\n", header.version))
    }
}
