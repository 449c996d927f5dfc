//! The controller's flash in memory, or in a file that every write reaches at once.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io::{self, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
};

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use miette::Diagnostic;
use thiserror::Error;

use crate::build_folder::try_file;
use vitrine_storage::map::{FLASH_BYTES, SECTOR_BYTES};

/// The whole chip.
const BYTES: usize = FLASH_BYTES as usize;

/// Why a flash file cannot be used.
#[derive(Debug, Error, Diagnostic)]
pub enum FlashError {
    /// Another controller has it.
    #[error("{} is in use by another simulated controller", path.display())]
    #[diagnostic(code(vitrine::controller::flash_busy), help("stop that one, or give this one another file"))]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// It is no flash file.
    #[error("{} is no flash file: it has {length} bytes instead of {BYTES}", path.display())]
    #[diagnostic(
        code(vitrine::controller::flash_size),
        help("give the path of a new file, or of one that `vitrine controller` wrote")
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// Its length.
        length: usize,
    },
    /// The operating system refuses.
    #[error("the flash file {} cannot be used", path.display())]
    #[diagnostic(
        code(vitrine::controller::flash_file),
        help("look at the folder, the disk's free space and the permissions")
    )]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
}

/// The flash: images, plan, settings, ledger and log.
#[derive(Debug)]
pub struct FlashFile {
    bytes: Vec<u8>,
    file: Option<File>,
}

impl FlashFile {
    /// Erased flash in memory.
    pub fn in_memory() -> Self {
        Self { bytes: vec![0xff; BYTES], file: None }
    }

    /// What stands in a flash's place while it is elsewhere.
    pub(super) const fn nothing() -> Self {
        Self { bytes: Vec::new(), file: None }
    }

    /// Flash in a file, for this program alone; a new file is erased flash.
    ///
    /// # Errors
    /// Where the file is in use, is something else, or cannot be read and written.
    pub fn open(path: &Path) -> Result<Self, FlashError> {
        let failed = |source| FlashError::File { path: path.to_owned(), source };
        let mut options = OpenOptions::new();
        let mut file =
            options.read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        let mut bytes = contents(&mut file, path)?;
        if bytes.is_empty() {
            bytes = vec![0xff; BYTES];
            if let Err(source) = file.write_all(&bytes).and_then(|()| file.sync_all()) {
                // An empty file is new flash; what is in it now is neither.
                let _ = file.set_len(0);
                return Err(failed(source));
            }
        }
        Ok(Self { bytes, file: Some(file) })
    }

    /// Looks whether flash could be kept in this file, and writes nothing; tells whether there is any in it yet.
    ///
    /// # Errors
    /// Those of [`FlashFile::open`].
    pub fn look(path: &Path) -> Result<bool, FlashError> {
        let failed = |source| FlashError::File { path: path.to_owned(), source };
        if !path.exists() {
            try_file(path).map_err(failed)?;
            return Ok(false);
        }
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
        Ok(!contents(&mut file, path)?.is_empty())
    }

    /// Whether nothing has been written there since it was erased.
    pub(super) fn is_erased(&self, address: u32, length: u32) -> bool {
        Self::range(address, length as usize)
            .is_ok_and(|range| self.bytes[range].iter().all(|byte| *byte == 0xff))
    }

    /// Writes erased flash, as a programmer does that a factory has.
    pub(super) fn program(&mut self, address: u32, bytes: &[u8]) -> Result<(), WriteError> {
        self.write(address, bytes)
    }

    fn range(address: u32, length: usize) -> Result<std::ops::Range<usize>, WriteError> {
        let start = address as usize;
        let end = start.checked_add(length).filter(|end| *end <= BYTES).ok_or(WriteError::OutOfBounds)?;
        Ok(start..end)
    }

    fn write_through(&mut self, range: std::ops::Range<usize>) -> Result<(), WriteError> {
        if let Some(file) = &mut self.file {
            file.seek(SeekFrom::Start(range.start as u64)).map_err(|_| WriteError::File)?;
            file.write_all(&self.bytes[range]).map_err(|_| WriteError::File)?;
        }
        Ok(())
    }
}

/// What a flash file holds, for this program alone for as long as it is open: nothing yet, or flash.
fn contents(file: &mut File, path: &Path) -> Result<Vec<u8>, FlashError> {
    let failed = |source| FlashError::File { path: path.to_owned(), source };
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Err(FlashError::Busy { path: path.to_owned() }),
        Err(TryLockError::Error(source)) => return Err(failed(source)),
    }
    let mut bytes = Vec::new();
    // A byte more than flash has tells that it is none, however large it is.
    file.take(BYTES as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
    match bytes.len() {
        0 | BYTES => Ok(bytes),
        _ => {
            let length = file.metadata().map_err(failed)?.len() as usize;
            Err(FlashError::Size { path: path.to_owned(), length })
        }
    }
}

/// Why flash could not be read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteError {
    /// Not within the flash, or not on a sector's edge.
    OutOfBounds,
    /// The file did not take the bytes.
    File,
}

impl NorFlashError for WriteError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::File => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for FlashFile {
    type Error = WriteError;
}

impl ReadNorFlash for FlashFile {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), WriteError> {
        bytes.copy_from_slice(&self.bytes[Self::range(offset, bytes.len())?]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        FLASH_BYTES as usize
    }
}

impl NorFlash for FlashFile {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), WriteError> {
        if !from.is_multiple_of(SECTOR_BYTES) || !to.is_multiple_of(SECTOR_BYTES) || to < from {
            return Err(WriteError::OutOfBounds);
        }
        let range = Self::range(from, (to - from) as usize)?;
        self.bytes[range.clone()].fill(0xff);
        self.write_through(range)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), WriteError> {
        let range = Self::range(offset, bytes.len())?;
        for (place, value) in self.bytes[range.clone()].iter_mut().zip(bytes) {
            *place &= value;
        }
        self.write_through(range)
    }
}
