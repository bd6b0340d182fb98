//! The hash that identifies the layout of a stored set.

/// Name and type of one word of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Name; empty for an object that its address identifies.
    pub name: &'static str,
    /// Index and sub-index of an object as `index << 8 | sub`; 0 for a named field.
    pub address: u32,
    /// Type.
    pub data_type: &'static str,
}

/// Hashes the fields of a set in their order (FNV-1a, 32 bits), for constant expressions: a field
/// that moves, or has another name or type, gives another hash.
///
/// ```
/// use firmware::store::{Field, layout_hash};
/// let field = |name| Field { name, address: 0, data_type: "i32" };
/// let (a, b) = (field("a"), field("b"));
/// assert_ne!(layout_hash(&[a, b]), layout_hash(&[b, a]));
/// ```
#[must_use]
pub const fn layout_hash(fields: &[Field]) -> u32 {
    let mut hash = 0x811C_9DC5;
    let mut rest = fields;
    while let [field, after @ ..] = rest {
        hash = with_bytes(hash, field.name.as_bytes());
        hash = with_bytes(hash, &field.address.to_le_bytes());
        hash = with_bytes(hash, field.data_type.as_bytes());
        rest = after;
    }
    hash
}

/// Adds bytes and their end to a hash.
const fn with_bytes(hash: u32, bytes: &[u8]) -> u32 {
    let mut hash = hash;
    let mut rest = bytes;
    while let [byte, after @ ..] = rest {
        hash = (hash ^ *byte as u32).wrapping_mul(0x0100_0193);
        rest = after;
    }
    // No byte of a text.
    (hash ^ 0xFF).wrapping_mul(0x0100_0193)
}
