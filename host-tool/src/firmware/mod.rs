//! Firmware images on the computer: what is built is read, signed, joined with the boot loader and written as a board's boot
//! ROM takes it.
//!
//! ```text
//! firmware/build.sh -> ELF files -> image()   what the processor sees behind the header
//!                                   sign()    header and image: what an update sends
//!                                   join()    boot loader and signed image: the flash of a new board
//!                                   uf2()     the same, as the boot ROM's USB disk takes it
//! ```

mod elf;
mod key;
mod signed;
mod uf2;

pub use elf::{Sizes, bootloader, image, sizes};
pub use key::{KeyError, SecretKey};
pub use signed::{SignedImage, join, sign};
pub use uf2::uf2;
pub use vitrine_protocol::firmware::ImageFault;

#[cfg(test)]
mod tests;

use std::{io, path::PathBuf};

use miette::Diagnostic;
use thiserror::Error;

/// Why a file is no firmware.
#[derive(Debug, Error, Diagnostic)]
pub enum FirmwareError {
    /// It cannot be read.
    #[error("{} cannot be read", path.display())]
    #[diagnostic(code(vitrine::firmware::unreadable), help("is it there, and may you read it?"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// It is no ELF file of the firmware.
    #[error("{} is no firmware for this board: {what}", path.display())]
    #[diagnostic(
        code(vitrine::firmware::no_elf),
        help("give the ELF file that firmware/build.sh leaves: target/firmware/vitrine-pico.elf")
    )]
    NoElf {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// It is no signed image.
    #[error("{}: {fault}", path.display())]
    #[diagnostic(code(vitrine::firmware::no_image), help("{}", fault_help(*fault)))]
    NoImage {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: ImageFault,
    },
}

/// What to do about an image that is none.
pub(crate) const fn fault_help(fault: ImageFault) -> &'static str {
    match fault {
        ImageFault::NoImage => {
            "`vitrine firmware sign` makes a signed image of what firmware/build.sh leaves"
        }
        ImageFault::OtherBoard | ImageFault::OtherAddress | ImageFault::Length => {
            "build and sign it with the firmware sources of this board"
        }
        ImageFault::OtherKey => {
            "sign it with the secret key that belongs to the public key which the board was built with"
        }
        ImageFault::Signature | ImageFault::Damaged => "sign it again, or fetch the file again",
    }
}
