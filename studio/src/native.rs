//! Actuators of this program's own, for those who have none at hand.

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;

use canopen::NodeId;
use host_sim::can::bus::Bus;
use host_sim::can::native_node::{CAPTURE_VALUES, NativeNode};
use host_sim::can::server::Server;
use model_core::parameter::ParameterError;
use model_core::plant::board::BoardPlantOptions;

use crate::StudioError;

/// Simulated actuators on a bus, which other programs of this computer can use too.
pub struct NativeBus {
    address: SocketAddr,
    encoder_switches: Vec<Arc<AtomicBool>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl NativeBus {
    /// Starts this many actuators with node-IDs from 1, with the noise and friction of real ones;
    /// `notify` receives messages about the bus.
    ///
    /// # Errors
    /// [`StudioError::Serve`] if there is no port.
    pub fn start(
        actuators: u8,
        notify: impl Fn(&str) + Send + 'static,
    ) -> Result<Self, StudioError> {
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let serve = |source| StudioError::Serve {
            address: any,
            source,
        };
        let listener = TcpListener::bind(any).map_err(serve)?;
        let address = listener.local_addr().map_err(serve)?;
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let encoder_switches: Vec<Arc<AtomicBool>> =
            (0..actuators).map(|_| Arc::default()).collect();
        let switches = encoder_switches.clone();
        let thread = std::thread::spawn(move || {
            let mut buffers = vec![vec![0; CAPTURE_VALUES]; usize::from(actuators)];
            let nodes = (1..).zip(&mut buffers).zip(switches);
            let nodes = nodes.map(|((number, buffer), switch)| {
                let plant = BoardPlantOptions::realistic(u64::from(number));
                let id = NodeId::new(number);
                let node = NativeNode::new(u32::from(number), id, &plant, buffer)?;
                Ok::<_, ParameterError>(node.with_encoder_switch(switch))
            });
            let ended = match nodes.collect::<Result<_, _>>() {
                Ok(nodes) => {
                    let mut forward = |notice: &_| notify(&format!("{notice}"));
                    Server::new(Bus::new(nodes)).run(Some(listener), &flag, &mut forward)
                }
                Err(error) => return notify(&error.to_string()),
            };
            if let Err(error) = ended {
                notify(&error.to_string());
            }
        });
        Ok(Self {
            address,
            encoder_switches,
            stop,
            thread: Some(thread),
        })
    }

    /// The bus as `--bus` takes it.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// For each actuator, what breaks a wire of its encoder while it is set.
    pub fn encoder_switches(&self) -> Vec<Arc<AtomicBool>> {
        self.encoder_switches.clone()
    }
}

impl Drop for NativeBus {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that has failed has been reported.
            let _ = thread.join();
        }
    }
}
