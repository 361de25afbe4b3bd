//! Atomic writing: a file is written completely, or not at all.
//!
//! Guarantees: new content goes to a temporary file in the same folder, reaches the disk, and only then takes the file's
//! name. If anything fails before, an old file of that name stays unchanged. A temporary file is locked by its program and
//! removed when the program is asked to end. Files left by a killed program are removed when the same file is written again.
//! Pipes and devices are never replaced. Files that are written [`Together`] take their names once all are complete.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use crate::{panicked::locked, progress::Progress};

/// Prefix and suffix of the names of temporary files. Between them are the name of the final file and some random letters.
const TEMPORARY: (&str, &str) = (".loopscope-", ".part");
/// Maximum number of characters of the final file's name in a temporary name, so that the temporary name is not too long.
const NAME_CHARS: usize = 50;

/// Error of writing a file. A file that existed before is unchanged.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", .path.display())]
pub struct WriteError {
    pub path: PathBuf,
    pub source: io::Error,
}

/// Replaces the file at `path` by what the function `write` writes.
///
/// # Errors
/// [`WriteError`] if the folder does not exist, the file cannot be written, or `write` fails.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
) -> Result<(), WriteError> {
    let mut files = Together::default();
    files.write(path, write)?;
    files.finish()
}

/// Set of files that get their final names together, all or none. Dropping the set before [`Self::finish`] removes its
/// temporary files.
#[derive(Debug, Default)]
pub struct Together {
    /// Each final file with its temporary file. An interrupt removes the temporary file, until it is renamed.
    written: Vec<(Target, tempfile::NamedTempFile, Forget)>,
    folders: Vec<(Target, tempfile::TempDir)>,
}

impl Together {
    /// Writes the new content of the file at `path` to a temporary file. The file at `path` is unchanged until
    /// [`finish`](Self::finish).
    ///
    /// # Errors
    /// [`WriteError`] if the folder does not exist, the file cannot be written, or `write` fails.
    pub fn write(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        self.written.push(whole(path, write).map_err(at(path))?);
        Ok(())
    }

    /// Writes a new folder for `path` from the files that `make` returns, each with its path in the folder and its content.
    ///
    /// # Errors
    /// [`WriteError`] if `path` is an existing file, the folder cannot be written, or `make` fails.
    pub fn folder(
        &mut self,
        path: &Path,
        make: impl FnOnce() -> io::Result<Vec<(String, String)>>,
    ) -> Result<(), WriteError> {
        let folder = whole_folder(path, make).map_err(at(path))?;
        self.folders.push(folder);
        Ok(())
    }

    /// Renames all temporary files and folders to their final names.
    ///
    /// # Errors
    /// [`WriteError`] if a file cannot be renamed. The files before it then already have their final names.
    pub fn finish(self) -> Result<(), WriteError> {
        // This list is declared before the lock, so that it is dropped after the lock is released. Dropping its elements
        // takes the lock again.
        let mut forgotten = Vec::new();
        let mut named = Ok(());
        // The lock is held until the last file has its final name, so that an interrupt never leaves only some of the files.
        let being_written = being_written();
        for (target, temporary, forget) in self.written {
            forgotten.push(forget);
            if named.is_ok() {
                named = temporary
                    .persist(&target.path)
                    .map(drop)
                    .map_err(|error| at(&target.path)(error.error));
                // The rename in the folder is also flushed to the disk. A failure is ignored, because the file itself is
                // complete.
                #[cfg(unix)]
                let _ = File::open(target.directory()).and_then(|directory| directory.sync_all());
            }
        }
        for (target, around) in self.folders {
            if named.is_ok() {
                let made = fs::rename(around.path().join(INSIDE), &target.path);
                named = made.map_err(at(&target.path));
            }
        }
        drop(being_written);
        named
    }
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> WriteError {
    let path = path.to_owned();
    |source| WriteError { path, source }
}

pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Checks whether a file could be written, without writing it.
pub(super) fn check_writable(path: &Path) -> Result<(), WriteError> {
    let check = || {
        let target = Target::of(path)?;
        tempfile::tempfile_in(target.directory()).map(drop)
    };
    check().map_err(at(path))
}

/// Exit code of an interrupted program, as shells report it: 128 + SIGINT, or 128 + SIGTERM if the program was asked to end.
static EXIT_CODE: AtomicU8 = AtomicU8::new(130);

/// Installs the handler that runs when the program is interrupted or asked to end. It removes temporary files and ends the
/// program. If work is registered by [`interrupt_stops`], the first interrupt stops only this work. A signal that the program
/// is started to ignore (`nohup`) stays ignored.
pub fn clean_up_when_asked_to_end() {
    let is_terminated = Arc::new(AtomicBool::new(false));
    let asked_to_end = Arc::clone(&is_terminated);
    // If the handler cannot be installed, temporary files are removed when the same file is written again.
    let set = ctrlc::try_set_handler(move || {
        // Waits until the second handler, which sets the flag for SIGTERM, has run.
        std::thread::sleep(Duration::from_millis(5));
        let word = if asked_to_end.load(Ordering::SeqCst) {
            EXIT_CODE.store(143, Ordering::SeqCst);
            "asked to end"
        } else {
            "interrupted"
        };
        let work = work().take();
        if let Some(work) = work {
            let _ = writeln!(
                io::stderr(),
                "loopscope: {word}; the results so far follow. Interrupt again to end at once"
            );
            work.cancel();
            return;
        }
        // The lock is held until the program ends, so that no new temporary file is begun.
        let being_written = being_written();
        for path in being_written.iter() {
            let _ = fs::remove_file(path);
        }
        let _ = writeln!(io::stderr(), "loopscope: {word}");
        std::process::exit(interrupted_code().into())
    });
    #[cfg(unix)]
    if set.is_ok() {
        // The handler above also runs on SIGTERM. This second handler sets a flag on SIGTERM, which tells the two signals
        // apart.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGTERM, is_terminated);
    }
    #[cfg(not(unix))]
    let _ = (set, is_terminated);
}

/// Returns the exit code of a program that was interrupted or asked to end.
pub fn interrupted_code() -> u8 {
    EXIT_CODE.load(Ordering::SeqCst)
}

/// Registers work that the first interrupt stops. The program then still prints the results so far.
pub fn interrupt_stops(progress: &Progress) {
    *work() = Some(progress.clone());
}

fn work() -> MutexGuard<'static, Option<Progress>> {
    static WORK: Mutex<Option<Progress>> = Mutex::new(None);
    locked(&WORK)
}

fn being_written() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    static PATHS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    locked(&PATHS)
}

#[derive(Debug)]
struct Target {
    path: PathBuf,
    permissions: Option<fs::Permissions>,
}

impl Target {
    fn of(path: &Path) -> io::Result<Self> {
        // If the path is a symbolic link, the file that it points to is replaced, so that the link stays a link.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let old = fs::metadata(&path).ok();
        if old.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(io::Error::other(
                "this is a folder; name a file in it, or add a / for a new folder",
            ));
        }
        if old.as_ref().is_some_and(|old| !old.is_file()) {
            return Err(io::Error::other("this is a pipe or a device; name a file"));
        }
        let permissions = old.map(|old| old.permissions());
        let target = Self { path, permissions };
        if !target.directory().is_dir() {
            // The system's own error message would name the temporary file, which the user does not know.
            let message = format!("there is no folder {}", target.directory().display());
            return Err(io::Error::new(io::ErrorKind::NotFound, message));
        }
        let is_read_only = fs::Permissions::readonly;
        if target.permissions.as_ref().is_some_and(is_read_only) {
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
        }
        Ok(target)
    }

    fn directory(&self) -> &Path {
        folder_of(&self.path)
    }

    /// Returns the prefix that the names of all temporary files for this final file share.
    fn prefix(&self) -> String {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let name: String = name.chars().take(NAME_CHARS).collect();
        format!("{}{name}-", TEMPORARY.0)
    }
}

/// Removes all temporary files in a folder that programs left when they were killed.
pub(crate) fn clean_up_in(folder: &Path) {
    clean_up(folder, TEMPORARY.0);
}

/// Removes temporary files with this prefix that killed programs left. The file of a running program stays, because the
/// program holds a lock on it.
fn clean_up(folder: &Path, prefix: &str) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_temporary = name.starts_with(prefix) && name.ends_with(TEMPORARY.1);
        if !is_temporary || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        if let Ok(left) = OpenOptions::new().write(true).open(entry.path())
            && left.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Creates a new temporary file, locked so that no other program removes it as a leftover.
fn new_file(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    // The file gets the permissions of any new file. The crate `tempfile` would make it readable by its owner only.
    options.write(true).create_new(true);
    loop {
        let file = options.open(path)?;
        // On a file system without locks, leftovers are never removed either, so a failure is ignored.
        let _ = file.lock();
        // Another program may have locked this file first and removed it as a leftover.
        if path.exists() {
            return Ok(file);
        }
    }
}

#[derive(Debug)]
struct Forget(PathBuf);

impl Drop for Forget {
    fn drop(&mut self) {
        being_written().remove(&self.0);
    }
}

fn whole(
    path: &Path,
    write: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
) -> io::Result<(Target, tempfile::NamedTempFile, Forget)> {
    let target = Target::of(path)?;
    let prefix = target.prefix();
    clean_up(target.directory(), &prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(TEMPORARY.1);
    let temporary = builder.make_in(target.directory(), |path| {
        let mut being_written = being_written();
        let file = new_file(path)?;
        being_written.insert(path.to_owned());
        Ok(file)
    })?;
    let forget = Forget(temporary.path().to_owned());
    // Errors of the `tempfile` wrapper would name the temporary file, so its inner file handle is used.
    let file = temporary.as_file();
    if let Some(permissions) = &target.permissions {
        file.set_permissions(permissions.clone())?;
    }
    let mut out = BufWriter::new(file);
    write(&mut out)?;
    out.flush()?;
    drop(out);
    file.sync_all()?;
    Ok((target, temporary, forget))
}

/// Writes a temporary folder beside its final place, from files each with its path in the folder and its content.
fn whole_folder(
    path: &Path,
    make: impl FnOnce() -> io::Result<Vec<(String, String)>>,
) -> io::Result<(Target, tempfile::TempDir)> {
    let target = Target::of(path)?;
    if target.permissions.is_some() {
        return Err(io::Error::other("this is an existing file"));
    }
    let files = make()?;
    // The outer temporary folder is removed with all its content after a failure. The inner folder has the permissions of any
    // new folder.
    let mut builder = tempfile::Builder::new();
    let around = builder.prefix(TEMPORARY.0).suffix(TEMPORARY.1);
    let around = around.tempdir_in(target.directory())?;
    let folder = around.path().join(INSIDE);
    for (name, content) in files {
        let file = folder.join(name);
        fs::create_dir_all(file.parent().unwrap_or(&folder))?;
        fs::write(file, content)?;
    }
    Ok((target, around))
}

const INSIDE: &str = "folder";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_whole_and_nothing_beside_it() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("kept.txt");
        fs::write(&path, "old").unwrap();
        let failed = write_atomically(&path, |out| {
            out.write_all(b"half of the n")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_takes_its_name_with_the_files_or_not_at_all() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        let mut files = Together::default();
        let content = || Ok(vec![("src/a.h".to_owned(), "a".to_owned())]);
        files.folder(&at("new/"), content).unwrap();
        files.write(&at("b.txt"), |out| out.write_all(b"b")).unwrap();
        assert!(!at("new").exists());
        drop(files);
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
        let mut files = Together::default();
        files.folder(&at("new/"), content).unwrap();
        files.finish().unwrap();
        assert_eq!(fs::read_to_string(at("new/src/a.h")).unwrap(), "a");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
        let again = Together::default().folder(&at("new/"), content);
        assert!(again.unwrap_err().to_string().contains("new folder"));
    }

    #[test]
    fn a_new_content_replaces_the_old() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        for content in ["first, longer", "second"] {
            write_atomically(&path, |out| out.write_all(content.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
    }

    /// The second file fails when the first is already written. The third cannot take its name, although all are written.
    #[test]
    fn files_written_together_are_all_there_or_none_is() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::write(at("a.txt"), "old").unwrap();
        let mut files = Together::default();
        files.write(&at("a.txt"), |out| out.write_all(b"new")).unwrap();
        assert!(!being_written().is_empty());
        let failed = files.write(&at("b.txt"), |_| Err(io::Error::other("disk full")));
        assert!(failed.unwrap_err().to_string().contains("b.txt: disk full"));
        drop(files);
        assert_eq!(fs::read_to_string(at("a.txt")).unwrap(), "old");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);

        let mut files = Together::default();
        for name in ["a.txt", "b.txt"] {
            files.write(&at(name), |out| out.write_all(name.as_bytes())).unwrap();
        }
        assert_eq!(fs::read_to_string(at("a.txt")).unwrap(), "old");
        files.finish().unwrap();
        for name in ["a.txt", "b.txt"] {
            assert_eq!(fs::read_to_string(at(name)).unwrap(), name);
        }
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_missing_directory_is_an_error_that_names_the_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("gone").join("a.txt");
        let error = write_atomically(&path, |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("a.txt"));
    }

    /// Of four temporary files, one belongs to a program that still writes, and one to another file. The other two are removed.
    #[test]
    fn files_of_ended_programs_are_removed_and_those_of_running_programs_stay() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        for name in ["a.txt-1", "a.txt-2", "a.txt-3", "b.txt-4"] {
            fs::write(at(&format!(".loopscope-{name}.part")), "half").unwrap();
        }
        let living = File::open(at(".loopscope-a.txt-2.part")).unwrap();
        living.lock().unwrap();
        write_atomically(&at("a.txt"), |out| out.write_all(b"whole")).unwrap();
        let entries = fs::read_dir(directory.path()).unwrap();
        let mut left: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        let expected = [".loopscope-a.txt-2.part", ".loopscope-b.txt-4.part", "a.txt"];
        assert_eq!(left, expected);
    }

    #[test]
    fn a_file_is_registered_and_locked_while_it_is_written() {
        let directory = tempfile::tempdir().unwrap();
        let mut temporary = PathBuf::new();
        write_atomically(&directory.path().join("a.txt"), |_| {
            let mut entries = fs::read_dir(directory.path())?;
            temporary = entries.next().expect("the temporary file")?.path();
            assert!(being_written().contains(&temporary));
            assert!(File::open(&temporary)?.try_lock().is_err());
            Ok(())
        })
        .unwrap();
        assert!(!being_written().contains(&temporary) && !temporary.exists());
    }

    #[test]
    fn names_of_any_length_can_be_written() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("力".repeat(80));
        write_atomically(&path, |out| out.write_all(b"x")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"x");
    }

    /// The file system is full. The error has the system's own words and the requested name.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_failure_names_the_file_and_not_the_temporary() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        let error = write_atomically(&path, |_| {
            File::options().write(true).open("/dev/full")?.write_all(b"x")
        });
        let message = error.unwrap_err().to_string();
        assert!(message.contains("a.txt") && message.contains("No space"), "{message}");
        assert!(!message.contains(".part"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_never_replaced() {
        let error = write_atomically(Path::new("/dev/null"), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("a device"), "{error}");
    }
}
