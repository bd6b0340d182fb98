//! Test bench: one node with node-ID 5 on its own bus.

use canopen::{CanFrame, Node, NodeId};
use embedded_can::{Frame, StandardId};

use crate::device::Device;
use crate::dictionary::DICTIONARY;

/// Identifier (bit 29 set for a 29-bit identifier) and data of a transmitted frame.
pub type SentFrame = (u32, Vec<u8>);

/// A data frame with an 11-bit identifier.
pub fn data_frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(StandardId::new(id).expect("11 bits"), data).expect("eight bytes")
}

pub struct Bench {
    pub node: Node<2, 2>,
    pub device: Device,
    pub now_us: u64,
}

impl Bench {
    /// A node after power-on; boot-up is not transmitted yet.
    pub fn powered_on(node_id: Option<u8>) -> Self {
        let mut device = Device::new();
        let node_id = node_id.and_then(NodeId::new);
        let node = Node::new(&DICTIONARY, node_id, &mut device, 0);
        Self {
            node,
            device,
            now_us: 0,
        }
    }

    /// A node in PRE-OPERATIONAL.
    pub fn new() -> Self {
        let mut bench = Self::powered_on(Some(5));
        assert_eq!(bench.drain(), [(0x705, vec![0])]);
        bench
    }

    /// A node in OPERATIONAL; the frames transmitted on the way are discarded.
    pub fn operational() -> Self {
        let mut bench = Self::new();
        bench.start();
        bench
    }

    pub fn start(&mut self) {
        self.send(0, &[1, 5]);
        self.wait_us(0);
    }

    pub fn drain(&mut self) -> Vec<SentFrame> {
        let mut sent = Vec::new();
        while let Some(frame) = self.node.transmit::<CanFrame>(&mut self.device) {
            let (id, extended) = frame.raw_id();
            assert!(!frame.is_remote_frame());
            sent.push((id | u32::from(extended) << 29, frame.data().to_vec()));
            assert!(sent.len() < 1000, "the node transmits without end");
        }
        sent
    }

    pub fn receive(&mut self, frame: &CanFrame) -> Vec<SentFrame> {
        self.node.receive(frame, self.now_us, &mut self.device);
        self.drain()
    }

    /// Frames that the node transmits in response to a frame, without a tick.
    pub fn send(&mut self, id: u16, data: &[u8]) -> Vec<SentFrame> {
        self.receive(&data_frame(id, data))
    }

    pub fn remote(&mut self, id: u16, length: u8) -> Vec<SentFrame> {
        self.receive(&CanFrame::raw(u32::from(id), false, true, length, [0; 8]).expect("a frame"))
    }

    /// One tick after `time_us`.
    pub fn wait_us(&mut self, time_us: u64) -> Vec<SentFrame> {
        self.now_us += time_us;
        self.node.tick(self.now_us, &mut self.device);
        self.drain()
    }

    /// Ticks of 1 ms; returns each transmitted frame with its time in milliseconds.
    pub fn run_ms(&mut self, time_ms: u64) -> Vec<(u64, SentFrame)> {
        (1..=time_ms)
            .flat_map(|at| self.wait_us(1000).into_iter().map(move |sent| (at, sent)))
            .collect()
    }

    /// The response of the SDO server.
    pub fn sdo(&mut self, request: [u8; 8]) -> Option<[u8; 8]> {
        let mut sent = self.send(0x605, &request);
        sent.retain(|(id, _)| *id == 0x585);
        assert!(sent.len() < 2, "one response per request");
        sent.pop()
            .map(|(_, data)| data.try_into().expect("eight bytes"))
    }

    /// Expedited upload, or the abort code.
    pub fn read(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        let [low, high] = index.to_le_bytes();
        let answer = self
            .sdo([0x40, low, high, sub, 0, 0, 0, 0])
            .expect("an answer");
        assert_eq!(answer[1..4], [low, high, sub]);
        let word = u32::from_le_bytes(answer[4..].try_into().expect("four bytes"));
        match answer[0] {
            0x80 => Err(word),
            0x43 | 0x47 | 0x4B | 0x4F => Ok(word),
            other => panic!("command {other:#X}"),
        }
    }

    /// Expedited download, or the abort code.
    pub fn write(&mut self, index: u16, sub: u8, bytes: &[u8]) -> Result<(), u32> {
        let [low, high] = index.to_le_bytes();
        let mut data = [0; 4];
        data[..bytes.len()].copy_from_slice(bytes);
        let command = 0x23 | (4 - bytes.len() as u8) << 2;
        let [a, b, c, d] = data;
        let answer = self
            .sdo([command, low, high, sub, a, b, c, d])
            .expect("an answer");
        assert_eq!(answer[1..4], [low, high, sub]);
        match answer[0] {
            0x80 => Err(u32::from_le_bytes(
                answer[4..].try_into().expect("four bytes"),
            )),
            0x60 => Ok(()),
            other => panic!("command {other:#X}"),
        }
    }

    pub fn write_u32(&mut self, index: u16, sub: u8, value: u32) -> Result<(), u32> {
        self.write(index, sub, &value.to_le_bytes())
    }

    pub fn write_u16(&mut self, index: u16, sub: u8, value: u16) -> Result<(), u32> {
        self.write(index, sub, &value.to_le_bytes())
    }

    /// Writes the signature to 1010h and waits until the application has stored.
    pub fn save(&mut self, sub: u8) {
        assert_eq!(
            self.sdo([0x23, 0x10, 0x10, sub, b's', b'a', b'v', b'e']),
            None,
            "not yet"
        );
        let answers = self.run_ms(10);
        assert_eq!(answers.len(), 1);
        assert_eq!(
            answers[0].1,
            (0x585, vec![0x60, 0x10, 0x10, sub, 0, 0, 0, 0])
        );
    }
}
