//! Why the processor started.

use firmware::supervisor::ResetCause;
use stm32f4xx_hal::pac::RCC;

/// Reads the cause and clears it for the next reset.
pub fn take(rcc: &RCC) -> ResetCause {
    let cause = ResetCause::of_csr(rcc.csr().read().bits());
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    cause
}
