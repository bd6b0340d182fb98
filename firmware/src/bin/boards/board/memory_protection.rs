//! Memory protection: what the program must not do is a fault at once, and opens all switches.

use cortex_m::peripheral::MPU;

/// Access permissions and memory type (DDI 0403, section B3.5.9): privileged access, and normal
/// memory with write-back.
mod attributes {
    const CACHEABLE: u32 = 1 << 17 | 1 << 16;
    pub const NO_ACCESS: u32 = NEVER_EXECUTED;
    pub const READ_AND_WRITE: u32 = 0b001 << 24 | NEVER_EXECUTED | CACHEABLE;
    pub const READ_AND_EXECUTE: u32 = 0b101 << 24 | CACHEABLE;
    const NEVER_EXECUTED: u32 = 1 << 28;
}

/// Base, logarithm of the size and attributes of each region; a later one takes precedence
/// (`memory.x` has the same memories).
const REGIONS: [(u32, u32, u32); 4] = [
    // The program writes only to bank 2.
    (0x0800_0000, 20, attributes::READ_AND_EXECUTE),
    (0x2000_0000, 18, attributes::READ_AND_WRITE),
    (0x1000_0000, 16, attributes::READ_AND_WRITE),
    // Below the stack.
    (0x0fff_0000, 16, attributes::NO_ACCESS),
];

/// Enables the protection. All other addresses keep the attributes of the architecture.
pub fn enable(mpu: &mut MPU) {
    const ENABLE_WITH_DEFAULT_MAP: u32 = 1 << 2 | 1;
    for (number, (base, size, attributes)) in (0..).zip(REGIONS) {
        // SAFETY: the regions permit all accesses that the program makes: it executes from flash,
        // and its data are in the two RAMs.
        unsafe {
            mpu.rnr.write(number);
            mpu.rbar.write(base);
            mpu.rasr.write(attributes | (size - 1) << 1 | 1);
        }
    }
    cortex_m::asm::dsb();
    // SAFETY: as above.
    unsafe { mpu.ctrl.write(ENABLE_WITH_DEFAULT_MAP) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
