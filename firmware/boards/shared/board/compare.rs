//! Comparison of memory, word by word.
//!
//! The compiler makes calls of this function when it compares values of several fields. That of the
//! compiler's own library compares one byte at a time.

/// Bytes of a word.
const WORD: usize = size_of::<u32>();

/// Bytes of a block.
const BLOCK: usize = 4 * WORD;

/// The difference of the first bytes that differ, 0 if none does (ISO C, 7.24.4.1).
///
/// # Safety
/// Both are valid for reads of `length` bytes.
#[unsafe(no_mangle)]
unsafe extern "C" fn memcmp(mut a: *const u8, mut b: *const u8, mut length: usize) -> i32 {
    // SAFETY: the reads stay within the regions; the core reads words at any address.
    unsafe {
        while length >= BLOCK && is_block_equal(a, b) {
            (a, b) = (a.add(BLOCK), b.add(BLOCK));
            length -= BLOCK;
        }
        while length >= WORD && word(a, 0) == word(b, 0) {
            (a, b) = (a.add(WORD), b.add(WORD));
            length -= WORD;
        }
        while length > 0 {
            let difference = i32::from(a.read()) - i32::from(b.read());
            if difference != 0 {
                return difference;
            }
            (a, b) = (a.add(1), b.add(1));
            length -= 1;
        }
    }
    0
}

/// Whether four words are equal: without a jump for each of them.
///
/// # Safety
/// Both are valid for reads of a block.
#[inline(always)]
unsafe fn is_block_equal(a: *const u8, b: *const u8) -> bool {
    // SAFETY: as for the caller.
    let differences = |at| unsafe { word(a, at) ^ word(b, at) };
    differences(0) | differences(1) | differences(2) | differences(3) == 0
}

/// The word of this number.
///
/// # Safety
/// It is valid for reads.
#[inline(always)]
unsafe fn word(of: *const u8, at: usize) -> u32 {
    // SAFETY: as for the caller; the core reads words at any address.
    unsafe { of.add(at * WORD).cast::<u32>().read_unaligned() }
}
