//! The schema's fingerprint, computed at compile time.

/// FNV-1a over the golden bytes of all messages: it differs as soon as a message's encoding differs.
pub const FINGERPRINT: u32 = fnv1a(include_bytes!("../golden/messages.txt"));

const fn fnv1a(bytes: &[u8]) -> u32 {
    let mut hash = 0x811c_9dc5_u32;
    let mut rest = bytes;
    while let [byte, tail @ ..] = rest {
        hash = (hash ^ *byte as u32).wrapping_mul(0x0100_0193);
        rest = tail;
    }
    hash
}
