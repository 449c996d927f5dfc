//! What of an ELF file goes to flash.

use std::{fs, ops::Range, path::Path};

use object::{
    LittleEndian,
    elf::{EM_ARM, FileHeader32, PT_LOAD},
    read::elf::{ElfFile32, FileHeader, ProgramHeader},
};
use vitrine_boot::{HEADER_BYTES, LAYOUT};
use vitrine_storage::map::PROGRESS;

use super::FirmwareError;

/// Where the processor sees the flash.
const FLASH_BASE: u32 = 0x1000_0000;

/// The processor's RAM: six banks in a row (RP2040 data sheet, 2.6.2).
const RAM: Range<u32> = 0x2000_0000..0x2004_2000;

/// How much an image takes, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Sizes {
    /// Of flash.
    pub flash: u32,
    /// Of RAM, without the stack.
    pub static_ram: u32,
}

/// The image that the firmware's ELF file holds: what lies in flash behind the active place's header.
///
/// # Errors
/// The file cannot be read, or is no firmware for this board.
pub fn image(path: &Path) -> Result<Vec<u8>, FirmwareError> {
    let start = LAYOUT.active.start() + HEADER_BYTES;
    let image = flash_of(path, start..LAYOUT.active.start() + LAYOUT.active.bytes())?;
    let word = |at: usize| {
        image.get(at..at + 4).map_or(0, |word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    let (stack, entry) = (word(0), word(4));
    let end = LAYOUT.address() + image.len() as u32;
    if !(RAM.start..=RAM.end).contains(&stack) || !(LAYOUT.address()..end).contains(&entry) || entry % 2 == 0
    {
        let what = format!("there is no vector table at {:#010x}", LAYOUT.address());
        return Err(FirmwareError::NoElf { path: path.to_owned(), what });
    }
    Ok(image)
}

/// What of an ELF file lies within these addresses of the flash, from the first of them to the last byte that is there.
///
/// # Errors
/// The file cannot be read, or holds nothing there.
fn flash_of(path: &Path, place: Range<u32>) -> Result<Vec<u8>, FirmwareError> {
    let no_elf = |what: &str| FirmwareError::NoElf { path: path.to_owned(), what: what.to_owned() };
    let bytes = read(path)?;
    let elf = parse(&bytes).map_err(|what| no_elf(&what))?;
    let mut flash = Vec::new();
    for segment in elf.elf_program_headers() {
        let (address, length) = (segment.p_paddr(LittleEndian), segment.p_filesz(LittleEndian));
        let Some(address) = address.checked_sub(FLASH_BASE) else { continue };
        if segment.p_type(LittleEndian) != PT_LOAD || length == 0 || !place.contains(&address) {
            continue;
        }
        let data = segment.data(LittleEndian, &*bytes).map_err(|()| no_elf("it is cut off"))?;
        let at = (address - place.start) as usize;
        let end = at + data.len();
        if end > place.len() {
            return Err(no_elf("it is larger than its place in flash"));
        }
        if flash.len() < end {
            flash.resize(end, 0xff);
        }
        flash[at..end].copy_from_slice(data);
    }
    if flash.is_empty() { Err(no_elf("nothing of it lies in its place in flash")) } else { Ok(flash) }
}

/// How much the program in an ELF file takes.
///
/// # Errors
/// The file cannot be read, or is no ELF file.
pub fn sizes(path: &Path) -> Result<Sizes, FirmwareError> {
    let bytes = read(path)?;
    let elf = parse(&bytes).map_err(|what| FirmwareError::NoElf { path: path.to_owned(), what })?;
    let loaded =
        || elf.elf_program_headers().iter().filter(|segment| segment.p_type(LittleEndian) == PT_LOAD);
    let flash = loaded()
        .filter(|segment| (FLASH_BASE..RAM.start).contains(&segment.p_paddr(LittleEndian)))
        .map(|segment| segment.p_filesz(LittleEndian))
        .sum();
    let static_ram = loaded()
        .filter(|segment| RAM.contains(&segment.p_vaddr(LittleEndian)))
        .map(|segment| segment.p_memsz(LittleEndian))
        .sum();
    Ok(Sizes { flash, static_ram })
}

/// The boot loader that an ELF file holds, from the beginning of the flash on.
///
/// # Errors
/// The file cannot be read, or is no boot loader for this board.
pub fn bootloader(path: &Path) -> Result<Vec<u8>, FirmwareError> {
    flash_of(path, 0..PROGRESS.start())
}

fn read(path: &Path) -> Result<Vec<u8>, FirmwareError> {
    fs::read(path).map_err(|source| FirmwareError::Unreadable { path: path.to_owned(), source })
}

fn parse(bytes: &[u8]) -> Result<ElfFile32<'_, LittleEndian>, String> {
    let elf =
        ElfFile32::<LittleEndian>::parse(bytes).map_err(|error| format!("no 32-bit ELF file ({error})"))?;
    let header: &FileHeader32<LittleEndian> = elf.elf_header();
    if header.e_machine(LittleEndian) == EM_ARM {
        Ok(elf)
    } else {
        Err("it is for another processor".to_owned())
    }
}
