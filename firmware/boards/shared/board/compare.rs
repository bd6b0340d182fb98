//! Comparison of memory, word by word.
//!
//! The compiler makes calls of this function when it compares values of several fields. That of the
//! compiler's own library compares one byte at a time.

/// Bytes of a word.
const WORD: usize = size_of::<u32>();

/// The difference of the first bytes that differ, 0 if none does (ISO C, 7.24.4.1).
///
/// # Safety
/// Both are valid for reads of `length` bytes.
#[unsafe(no_mangle)]
unsafe extern "C" fn memcmp(mut a: *const u8, mut b: *const u8, mut length: usize) -> i32 {
    // SAFETY: the reads stay within the regions; the core reads words at any address.
    unsafe {
        while length >= WORD && a.cast::<u32>().read_unaligned() == b.cast::<u32>().read_unaligned()
        {
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
