//! Instructions and exceptions on the second emulator.

use super::Shadow;
use crate::frames::Frames;
use crate::registers::{Registers, holds, with_it};
use crate::replay::size;
use crate::unicorn::Register;

impl Shadow {
    /// Executes instructions on the second emulator.
    pub(super) fn execute(&mut self, instructions: u64) -> Result<(), String> {
        self.compared.instructions += instructions;
        let mut left = instructions;
        while left > 0 {
            if let Some(link) = self.returning.take() {
                self.leave(link)?;
            }
            if self.it != 0 {
                self.execute_in_block()?;
                left -= 1;
                continue;
            }
            let executed = self.run(left, None)?;
            left -= executed;
            if self.second.host().before_block {
                let [pc] = self.second.read([Register::core(15)]);
                let half = self.second.memory().half(pc).unwrap_or(0);
                self.it = half as u8;
                self.second.write([(Register::core(15), (pc + 2) | 1)]);
                left -= 1;
            } else if executed == 0 && self.returning.is_none() {
                let [pc] = self.second.read([Register::core(15)]);
                return Err(format!("the second emulator does not execute {pc:08x}"));
            }
        }
        Ok(())
    }

    /// Runs the second emulator; returns the number of executed instructions.
    pub(super) fn run(&mut self, instructions: u64, end: Option<u32>) -> Result<u64, String> {
        let [pc] = self.second.read([Register::core(15)]);
        self.second.host().begin(instructions);
        let ended = self.second.run(pc, end);
        let host = self.second.host();
        self.accesses = host.accesses;
        let difference = host.difference.take();
        let (executed, returned) = (host.executed, host.returned);
        self.overran |= host.overran;
        if let Some(difference) = difference.filter(|_| !self.overran) {
            return Err(difference);
        }
        ended.map_err(|error| format!("{error} after {pc:08x}"))?;
        if returned {
            // The program jumped to EXC_RETURN, whose lowest bit selects Thumb code.
            let [pc] = self.second.read([Register::core(15)]);
            self.returning = Some(pc | 1);
        }
        Ok(executed)
    }

    /// Executes one instruction within the block of an IT instruction: as the last one of a block
    /// with its condition.
    pub(super) fn execute_in_block(&mut self) -> Result<(), String> {
        let [status, pc] = self.second.read([Register::XPSR, Register::core(15)]);
        let half = self.second.memory().half(pc).unwrap_or(0);
        let next = pc + size(half);
        if holds(self.it >> 4, status) {
            let alone = self.it & 0xf0 | 0b1000;
            self.second
                .write([(Register::XPSR, with_it(status, alone))]);
            self.run(1, Some(next))?;
        } else {
            self.second.write([(Register::core(15), next | 1)]);
        }
        self.it = if self.it & 0b111 == 0 {
            0
        } else {
            self.it & 0xe0 | self.it << 1 & 0x1f
        };
        Ok(())
    }

    pub(super) fn leave(&mut self, link: u32) -> Result<(), String> {
        let [status] = self.second.read([Register::XPSR]);
        *self.compared.handlers.entry(status & 0x1ff).or_default() += 1;
        self.handler_ended = true;
        self.it = self.frames.leave(&mut self.second, link)?;
        Ok(())
    }

    /// Takes or returns from an exception where the board's core has.
    pub(super) fn follow_exceptions(&mut self, board: &Registers) -> Result<(), String> {
        let number = board.exception();
        let vector = self
            .second
            .memory()
            .word(self.vectors + 4 * number)
            .unwrap_or(0);
        let is_at_handler = number != 0 && board.core[15] == vector & !1;
        if let Some(link) = self.returning.take() {
            let [at, status] = self.second.read([Register::core(13), Register::XPSR]);
            if is_at_handler && board.core[13] == at && board.core[14] == link {
                *self.compared.handlers.entry(status & 0x1ff).or_default() += 1;
                self.handler_ended = true;
                Frames::chain(&mut self.second, link, (number, vector & !1));
                return Ok(());
            }
            self.leave(link)?;
        }
        let [pc, status] = self.second.read([Register::core(15), Register::XPSR]);
        if is_at_handler && (status & 0x1ff != number || pc != board.core[15]) {
            self.frames.enter(
                &mut self.second,
                (number, vector & !1),
                self.it,
                board.core[14],
            )?;
            self.it = 0;
        }
        Ok(())
    }
}
