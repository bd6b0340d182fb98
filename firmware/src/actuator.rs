//! A whole actuator on the PC: the control loop and the communication, in the order of the board.

use canopen::{Node, NodeId};
use embedded_can::Frame;

use crate::{
    application::{Outputs, Samples, Start},
    control_loop::{Inputs, Loop},
    drive::{Device, Messages, RPDOS, StoredParameters, TPDOS},
};

/// An actuator on a CAN bus: frames and samples go in, frames and the bridge's state come out.
#[derive(Debug)]
pub struct Actuator<'a> {
    /// The communication.
    pub device: Device<'a>,
    control_loop: Loop,
    was_late: bool,
}

impl<'a> Actuator<'a> {
    /// Powers the actuator on with these stored parameters, the node-ID among them, and a buffer
    /// for captures.
    ///
    /// ```
    /// use canopen::CanFrame;
    /// use firmware::{actuator::Actuator, application::Start, drive::StoredParameters};
    ///
    /// let mut buffer = [0; 80];
    /// let set = StoredParameters::DEFAULT;
    /// let mut actuator = Actuator::new(set, Start::default(), &mut buffer, 0);
    /// let boot_up = actuator.transmit::<CanFrame>().unwrap();
    /// assert_eq!(boot_up.raw_id(), (0x701, false));
    /// ```
    pub fn new(stored: StoredParameters, start: Start, buffer: &'a mut [i32], now_us: u64) -> Self {
        Self::of(Device::new(stored, buffer, now_us), start)
    }

    /// As [`Actuator::new`], with this node-ID; `None` waits for LSS.
    pub fn with_node_id(
        stored: StoredParameters,
        start: Start,
        buffer: &'a mut [i32],
        now_us: u64,
        node_id: Option<NodeId>,
    ) -> Self {
        Self::of(Device::with_node_id(stored, buffer, now_us, node_id), start)
    }

    fn of(device: Device<'a>, start: Start) -> Self {
        let control_loop = device.drive.messages.start(start);
        Self {
            device,
            control_loop,
            was_late: false,
        }
    }

    /// The node.
    pub fn node(&self) -> &Node<RPDOS, TPDOS> {
        self.device.node()
    }

    /// The control loop.
    pub fn control_loop(&self) -> &Loop {
        &self.control_loop
    }

    /// Takes a frame from the bus.
    pub fn receive(&mut self, frame: &impl Frame, now_us: u64) {
        self.device.receive(frame, now_us);
    }

    /// The next frame for the bus, if there is one.
    pub fn transmit<F: Frame>(&mut self) -> Option<F> {
        self.device.transmit()
    }

    /// The last step ended too late: see [`Inputs::was_late`].
    pub fn was_late(&mut self) {
        self.was_late = true;
    }

    /// One control period, at its time: [`Actuator::control_period`], then
    /// [`Actuator::communicate`].
    pub fn step(&mut self, samples: &Samples, now_us: u64) -> Outputs {
        let outputs = self.control_period(samples);
        self.communicate(now_us);
        outputs
    }

    /// One control period of the loop; the next [`Actuator::communicate`] reports it to the
    /// network.
    pub fn control_period(&mut self, samples: &Samples) -> Outputs {
        let Messages {
            commands,
            parameters,
            excitation,
        } = &self.device.drive.messages;
        let outputs = *self.control_loop.step(&Inputs {
            samples,
            was_late: core::mem::take(&mut self.was_late),
            commands: commands.unverified(),
            parameters: parameters.unverified(),
            excitation: excitation.unverified(),
        });
        self.device.observe(&outputs);
        outputs
    }

    /// Does what is due on the network. To be called at least once in a control period.
    pub fn communicate(&mut self, now_us: u64) {
        self.device.communicate(now_us);
    }
}
