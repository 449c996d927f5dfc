//! Which controllers there are: serial ports, and virtual controllers on this computer.
//!
//! A virtual controller announces itself by a small file while it runs. Serial ports that belong to something else
//! are listed but never opened: opening a port can reset what is behind it.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
};

use serialport::{SerialPortInfo, SerialPortType, available_ports};
use vitrine_protocol::{Hello, USB_IDS, USB_PRODUCT};

use super::{Address, Client, LinkError};
use crate::plain;

/// One port, and what is behind it.
#[derive(Debug)]
pub struct Device {
    /// Where it is.
    pub address: Address,
    /// What it is, in words: its USB product name, or "simulated controller".
    pub kind: String,
    /// Its serial number, as told by the controller or by USB.
    pub serial_number: Option<String>,
    /// How the controller greeted, or why it cannot be used.
    pub state: Result<Hello, LinkError>,
}

/// Lists all ports: controllers first, each greeted; then those that are not ours.
pub fn devices() -> Vec<Device> {
    let mut devices = serial_devices();
    devices.extend(
        announced().into_iter().map(|address| greeted(address, "simulated controller".to_owned(), None)),
    );
    devices.sort_by_key(|device| (device.state.is_err(), device.address.to_string()));
    devices
}

/// Gives the address that a user meant: the one given, that of the controller whose serial number is given, or
/// that of the only controller there is.
///
/// # Errors
/// Where there is none, or more than one.
pub fn choose(given: Option<Address>) -> Result<Address, LinkError> {
    match given {
        Some(Address::Serial(name)) if may_be_serial_number(&name) => by_serial_number(&name, devices()),
        Some(address) => Ok(address),
        None => the_only_one(devices()),
    }
}

/// Ports have a path, or are called COM with a number; serial numbers have neither.
fn may_be_serial_number(name: &str) -> bool {
    !name.contains(['/', '\\']) && !name.to_ascii_uppercase().starts_with("COM")
}

/// The controller whose serial number begins as `wanted` does, if it is the only one.
pub(super) fn by_serial_number(wanted: &str, devices: Vec<Device>) -> Result<Address, LinkError> {
    let numbered = |device: &Device| device.serial_number.clone().unwrap_or_default().to_ascii_uppercase();
    let beginning = wanted.to_ascii_uppercase();
    let known: Vec<String> = devices.iter().filter_map(|device| device.serial_number.clone()).collect();
    let mut found: Vec<Address> = devices
        .into_iter()
        .filter(|device| numbered(device).starts_with(&beginning))
        .map(|device| device.address)
        .collect();
    match found.len() {
        0 => Err(LinkError::NoSuchSerialNumber { wanted: wanted.to_owned(), known }),
        1 => Ok(found.remove(0)),
        _ => Err(LinkError::SeveralFound { found }),
    }
}

fn the_only_one(devices: Vec<Device>) -> Result<Address, LinkError> {
    let mut usable: Vec<_> = devices
        .into_iter()
        .filter(|device| !matches!(device.state, Err(LinkError::NotOurs { .. } | LinkError::Missing { .. })))
        .map(|device| device.address)
        .collect();
    match usable.len() {
        0 => Err(LinkError::NoneFound),
        1 => Ok(usable.remove(0)),
        _ => Err(LinkError::SeveralFound { found: usable }),
    }
}

fn serial_devices() -> Vec<Device> {
    behind(available_ports().unwrap_or_default())
}

/// Greets what may be a controller; other ports are not opened.
pub(super) fn behind(ports: Vec<SerialPortInfo>) -> Vec<Device> {
    ports
        .into_iter()
        .filter_map(|port| {
            let address = Address::Serial(port.port_name);
            match port.port_type {
                SerialPortType::UsbPort(usb) if is_ours(&usb) => {
                    let kind = told(usb.product).unwrap_or_else(|| USB_PRODUCT.to_owned());
                    Some(greeted(address, kind, told(usb.serial_number)))
                }
                SerialPortType::UsbPort(usb) => Some(Device {
                    kind: told(usb.product).unwrap_or_else(|| format!("USB {:04x}:{:04x}", usb.vid, usb.pid)),
                    serial_number: told(usb.serial_number),
                    state: Err(LinkError::NotOurs { address: address.clone() }),
                    address,
                }),
                SerialPortType::PciPort | SerialPortType::BluetoothPort | SerialPortType::Unknown => None,
            }
        })
        .collect()
}

/// What a board calls itself, as it can be told.
fn told(name: Option<String>) -> Option<String> {
    name.map(|name| plain::name(&name).into_owned())
}

fn is_ours(usb: &serialport::UsbPortInfo) -> bool {
    (usb.vid, usb.pid) == USB_IDS && usb.product.as_deref().is_none_or(|name| name == USB_PRODUCT)
}

fn greeted(address: Address, kind: String, serial_number: Option<String>) -> Device {
    let state = Client::open(&address).map(|client| client.hello().clone());
    let told = state.as_ref().ok().map(|hello| hello.serial_number.as_str().to_owned());
    Device { address, kind, serial_number: told.or(serial_number), state }
}

/// A virtual controller's announcement; withdrawn when dropped.
#[derive(Debug)]
pub struct Announcement {
    file: PathBuf,
}

impl Announcement {
    /// Announces a controller at `HOST:PORT` on this computer.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn new(place: &str) -> io::Result<Self> {
        Self::in_folder(&announcements(), place)
    }

    pub(super) fn in_folder(folder: &Path, place: &str) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let name: String =
            place.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '_' }).collect();
        let file = folder.join(name);
        let fresh = file.with_extension(format!("{}.new", std::process::id()));
        fs::write(&fresh, place)?;
        fs::rename(&fresh, &file)?;
        Ok(Self { file })
    }
}

impl Drop for Announcement {
    fn drop(&mut self) {
        let _gone_already = fs::remove_file(&self.file);
    }
}

fn announced() -> Vec<Address> {
    announced_in(&announcements())
}

pub(super) fn announced_in(folder: &Path) -> Vec<Address> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    entries
        .flatten()
        .filter(|entry| entry.path().extension().is_none_or(|extension| extension != "new"))
        .filter_map(|entry| fs::read_to_string(entry.path()).ok())
        .filter(|place| plain::is_plain(place))
        .map(Address::Tcp)
        .collect()
}

/// The folder of announcements: in the user's runtime folder, or among temporary files.
fn announcements() -> PathBuf {
    match env::var_os("VITRINE_RUNTIME_DIR").or_else(|| env::var_os("XDG_RUNTIME_DIR")) {
        Some(folder) => Path::new(&folder).join("vitrine-controllers"),
        None => {
            let user =
                env::var("USER").or_else(|_| env::var("USERNAME")).unwrap_or_else(|_| "user".to_owned());
            env::temp_dir().join(format!("vitrine-controllers-{user}"))
        }
    }
}
