//! Tells whether JPEG data are whole: decoders fill what is missing with grey and say nothing.

/// Start of a JPEG file.
pub(super) fn is_jpeg(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xFF, 0xD8])
}

/// Follows the markers from the start to the end-of-image marker; a thumbnail's own end does not count, for
/// it lies within a segment that is skipped.
pub(super) fn is_whole(bytes: &[u8]) -> bool {
    const END: u8 = 0xD9;
    const STUFFED: u8 = 0x00;
    const FILL: u8 = 0xFF;
    let mut at = 2;
    while let Some(&byte) = bytes.get(at) {
        if byte != 0xFF {
            // Picture data, which follow a start-of-scan segment.
            at += 1;
            continue;
        }
        match bytes.get(at + 1) {
            Some(&END) => return true,
            Some(&FILL) => at += 1,
            // Stuffed bytes, temporary and restart markers and a start of image have no length.
            Some(&STUFFED | 0x01 | 0xD0..=0xD8) => at += 2,
            Some(_) => {
                let (Some(&high), Some(&low)) = (bytes.get(at + 2), bytes.get(at + 3)) else { return false };
                at += 2 + usize::from(u16::from_be_bytes([high, low])).max(2);
            }
            None => return false,
        }
    }
    false
}
