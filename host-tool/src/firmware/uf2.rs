//! UF2, the format of files that a board in its boot ROM takes from a USB disk: <https://github.com/microsoft/uf2>, "File
//! format".

/// Where the processor sees the flash.
const FLASH_BASE: u32 = 0x1000_0000;

const BLOCK_BYTES: usize = 512;
/// What the RP2040's boot ROM wants in each block (RP2040 data sheet, 2.8.4.2).
const PAYLOAD_BYTES: usize = 256;
const FIRST_MAGIC: u32 = 0x0A32_4655;
const SECOND_MAGIC: u32 = 0x9E5D_5157;
const LAST_MAGIC: u32 = 0x0AB1_6F30;
/// The word behind the counts names the family of chips.
const HAS_FAMILY: u32 = 0x2000;
/// The RP2040's (uf2families.json).
const FAMILY: u32 = 0xE48B_FF56;

/// A file that writes these bytes to flash, from its beginning on; the last block is filled up as erased flash.
pub fn uf2(flash: &[u8]) -> Vec<u8> {
    let blocks = flash.len().div_ceil(PAYLOAD_BYTES) as u32;
    let mut file = Vec::with_capacity(blocks as usize * BLOCK_BYTES);
    for (number, payload) in (0..blocks).zip(flash.chunks(PAYLOAD_BYTES)) {
        let words = [
            FIRST_MAGIC,
            SECOND_MAGIC,
            HAS_FAMILY,
            FLASH_BASE + number * PAYLOAD_BYTES as u32,
            PAYLOAD_BYTES as u32,
            number,
            blocks,
            FAMILY,
        ];
        let end = file.len() + BLOCK_BYTES;
        words.iter().for_each(|word| file.extend_from_slice(&word.to_le_bytes()));
        file.extend_from_slice(payload);
        file.resize(file.len() + PAYLOAD_BYTES - payload.len(), 0xff);
        file.resize(end - 4, 0);
        file.extend_from_slice(&LAST_MAGIC.to_le_bytes());
    }
    file
}
