//! Writes a folder whole or not at all: beside its place first, then renamed into it.
//!
//! A failed write, a full disk, a panic and an interrupt (Ctrl-C, a termination signal) leave nothing behind and leave
//! what was there before untouched.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempDir;

/// The folders that an interrupt has to take away.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The exit code of a process that an interrupt has ended: 128 plus the number of SIGINT, as shells have it.
pub const INTERRUPTED: u8 = 130;

/// How often a folder is removed in which another thread may still begin files.
const REMOVALS: usize = 1000;

/// What the next interrupt does in place of ending the process.
static INSTEAD: Mutex<Option<Box<dyn FnOnce() + Send>>> = Mutex::new(None);

/// Takes unfinished folders away when the process is interrupted, and ends it.
///
/// # Errors
/// Fails when the signal handler cannot be installed, or has been already.
pub fn clean_up_on_interrupt() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        let action = instead().take();
        if let Some(action) = action {
            return action();
        }
        // The lock is held until the process ends: no folder is put in its place after this.
        let unfinished = unfinished();
        for folder in unfinished.iter() {
            // Another thread may begin a file between the removal's passes, but no folder.
            for _ in 0..REMOVALS {
                if fs::remove_dir_all(folder).is_ok() || !folder.exists() {
                    break;
                }
            }
        }
        std::process::exit(INTERRUPTED.into());
    })
}

/// As long as this is kept, the next interrupt does something else than end the process; a second one ends it.
#[derive(Debug)]
pub struct Interrupt(());

impl Interrupt {
    /// Lets the next interrupt do `action`.
    pub fn does(action: impl FnOnce() + Send + 'static) -> Self {
        *instead() = Some(Box::new(action));
        Self(())
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        *instead() = None;
    }
}

fn instead() -> MutexGuard<'static, Option<Box<dyn FnOnce() + Send>>> {
    INSTEAD.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder being written beside its place. Dropped without [`WholeFolder::commit`], it is gone.
#[derive(Debug)]
pub struct WholeFolder {
    place: PathBuf,
    beside: TempDir,
}

impl WholeFolder {
    /// Starts a folder that is to stand at `place`; missing parent folders are made.
    ///
    /// # Errors
    /// Fails when nothing can be written beside `place`.
    pub fn beside(place: &Path) -> io::Result<Self> {
        let parent = parent_of(place);
        fs::create_dir_all(parent)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(".vitrine-unfinished-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // The user's umask is taken off these.
            builder.permissions(fs::Permissions::from_mode(0o777));
        }
        let mut unfinished = unfinished();
        let beside = builder.tempdir_in(parent)?;
        unfinished.push(beside.path().to_owned());
        Ok(Self { place: place.to_owned(), beside })
    }

    /// Where the folder is while it is unfinished.
    pub fn path(&self) -> &Path {
        self.beside.path()
    }

    /// Writes one file, `name` being relative to the folder, through to the disk.
    ///
    /// # Errors
    /// Fails when the file cannot be written; a full disk shows here.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let mut file = self.create(name)?;
        file.write_all(bytes)?;
        file.sync_all()
    }

    /// Makes one file to be written, `name` being relative to the folder.
    ///
    /// # Errors
    /// Fails when the file cannot be made.
    pub fn create(&self, name: &str) -> io::Result<File> {
        let path = self.path().join(name);
        if let Some(parent) = path.parent() {
            // An interrupt holds the lock while it takes folders away: none is made again behind its back.
            let _unfinished = unfinished();
            fs::create_dir_all(parent)?;
        }
        File::create(path)
    }

    /// Puts the folder in its place; what was there is taken away afterwards.
    ///
    /// # Errors
    /// Fails when the folder cannot be renamed; then what was there is there still.
    pub fn commit(self) -> io::Result<()> {
        let mut unfinished = unfinished();
        put_in_place(self.beside.path(), &self.place)?;
        unfinished.retain(|folder| folder != self.beside.path());
        Ok(())
    }
}

/// Renames a folder to where it is to stand; what stands there is moved aside first, and back if the folder cannot take
/// its place, and taken away in the end.
pub(super) fn put_in_place(folder: &Path, place: &Path) -> io::Result<()> {
    if place.symlink_metadata().is_err() {
        return fs::rename(folder, place);
    }
    let aside = tempfile::Builder::new().prefix(".vitrine-replaced-").tempdir_in(parent_of(place))?;
    let old = aside.path().join("old");
    fs::rename(place, &old)?;
    fs::rename(folder, place).inspect_err(|_| {
        if fs::rename(&old, place).is_err() {
            eprintln!("the former folder is kept in {}", old.display());
        }
    })
}

impl Drop for WholeFolder {
    fn drop(&mut self) {
        unfinished().retain(|folder| folder != self.beside.path());
    }
}

/// Writes one file whole or not at all.
///
/// # Errors
/// Fails when the file cannot be written beside its place or renamed into it.
pub fn write_file(place: &Path, bytes: &[u8]) -> io::Result<()> {
    // It says what is wrong without the name of an unfinished file.
    try_file(place)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".vitrine-unfinished-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(parent_of(place))?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(place)?;
    Ok(())
}

/// Tries whether the file `place` can be written, before any work is done for it.
///
/// # Errors
/// Where a folder is there, or the folder that it is to be in is missing or takes no file.
pub fn try_file(place: &Path) -> io::Result<()> {
    let parent = parent_of(place);
    if !parent.exists() {
        let missing = format!("there is no folder {}", parent.display());
        return Err(io::Error::new(io::ErrorKind::NotFound, missing));
    }
    if place.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "a folder is there"));
    }
    try_beside(place)
}

/// Tries whether something can be written where `place` is to be, before any work is done for it.
///
/// # Errors
/// Where the folder that `place` is in, or the nearest above it that there is, takes no file.
pub(crate) fn try_beside(place: &Path) -> io::Result<()> {
    let there = parent_of(place).ancestors().find(|folder| folder.as_os_str().is_empty() || folder.exists());
    let folder = there.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    tempfile::tempfile_in(folder).map(drop)
}

/// The folder that `path` is in.
fn parent_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_committed_folder_replaces_the_old_one_and_leaves_nothing_beside() {
        let root = tempfile::tempdir().unwrap();
        let place = root.path().join("build");
        for text in ["first", "second"] {
            let folder = WholeFolder::beside(&place).unwrap();
            folder.write("films/one.txt", text.as_bytes()).unwrap();
            folder.commit().unwrap();
            assert_eq!(fs::read_to_string(place.join("films/one.txt")).unwrap(), text);
        }
        assert_eq!(names(root.path()), ["build"]);
    }

    #[test]
    fn a_dropped_folder_leaves_nothing_and_the_old_one_untouched() {
        let root = tempfile::tempdir().unwrap();
        let place = root.path().join("build");
        let folder = WholeFolder::beside(&place).unwrap();
        folder.write("a", b"old").unwrap();
        folder.commit().unwrap();
        let folder = WholeFolder::beside(&place).unwrap();
        folder.write("a", b"new").unwrap();
        drop(folder);
        assert_eq!(fs::read(place.join("a")).unwrap(), b"old");
        assert_eq!(names(root.path()), ["build"]);
    }

    #[test]
    fn a_place_that_cannot_be_made_is_an_error() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("file"), b"").unwrap();
        assert!(WholeFolder::beside(&root.path().join("file/build")).is_err());
        assert_eq!(names(root.path()), ["file"]);
    }
}
