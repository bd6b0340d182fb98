//! The whole server for one frame type and one application, linked for the board's processor, so
//! that its size and whether it can panic can be looked at. On other targets there is nothing in
//! it.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod dictionary;

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod board {
    use core::hint::black_box;
    use core::panic::PanicInfo;

    use canopen::cia402::{Axis, Input, Parameters};
    use canopen::dictionary::Address;
    use canopen::{Abort, Application, BusEvent, CanFrame, Emergency, ErrorCode, Node, NodeId};

    /// One number behind every address.
    struct Number(u64);

    impl Application for Number {
        fn read(&mut self, _: Address) -> Result<u64, Abort> {
            Ok(self.0)
        }

        fn write(&mut self, _: Address, value: u64) -> Result<(), Abort> {
            self.0 = value;
            Ok(())
        }
    }

    /// All memory that a node takes; there is no other.
    const _: () = assert!(size_of::<Node<4, 4>>() <= 1792);

    /// Uses the whole interface with arguments of which the compiler knows nothing.
    #[expect(unsafe_code, reason = "the symbol that the linker starts from")]
    // SAFETY: no other symbol has this name; nothing calls it but the processor's reset.
    #[unsafe(no_mangle)]
    pub extern "C" fn _start() -> ! {
        let mut app = Number(black_box(0));
        let id = black_box(NodeId::new(5));
        let mut node =
            Node::<4, 4>::new(&crate::dictionary::DICTIONARY, id, &mut app, black_box(0));
        let mut axis = Axis::new();
        let (input, parameters) = (Input::default(), Parameters::default());
        loop {
            // By reference: what is behind it may have become anything, and nothing is copied.
            let node = black_box(&mut node);
            let axis = black_box(&mut axis);
            black_box(&axis.step(black_box(&input), black_box(&parameters)));
            node.tick(black_box(0), &mut app);
            if let Some(frame) = black_box(&node.transmit::<CanFrame>(&mut app)) {
                node.receive(frame, black_box(0), &mut app);
            }
            for identifier in node.identifiers() {
                black_box(&identifier);
            }
            node.bus_event(black_box(BusEvent::Overrun), &mut app);
            node.raise(black_box(Emergency::new(ErrorCode::NONE, 0)), &mut app);
            node.clear(black_box(ErrorCode::NONE), black_box(0));
            node.request_tpdo(black_box(1));
            node.object_changed(black_box(Address::new(0x6041, 0)));
            black_box((node.state(), node.error_register(), node.node_id()));
        }
    }

    #[panic_handler]
    fn panic(_: &PanicInfo) -> ! {
        loop {}
    }
}
