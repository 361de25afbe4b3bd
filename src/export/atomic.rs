//! Files are written whole or not at all.
//!
//! Guarantees: the new content goes to a temporary file in the same directory, reaches the disk, and only then takes the
//! name; whatever goes wrong before, an old file of that name stays as it was. A temporary file is locked by whoever
//! writes it and goes when the program is asked to end; what a killed program left goes when the same file is written
//! again. Pipes and devices are never replaced. Files that are written [`Together`] take their names once all are whole.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::progress::Progress;

/// How temporary files begin and end; between the two are the name that they are to take, and some letters by chance.
const TEMPORARY: (&str, &str) = (".loopscope-", ".part");
/// Maximum number of characters taken from a name: the whole must be a file name, too.
const NAME_CHARS: usize = 50;

/// A file could not be written; what was there is unchanged.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", .path.display())]
pub struct WriteError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// What went wrong.
    pub source: io::Error,
}

/// Replaces the file at `path` by what `write` writes.
///
/// # Errors
/// [`WriteError`] if the directory is not there, the file cannot be written, or `write` fails.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let mut files = Together::default();
    files.write(path, write)?;
    files.finish()
}

/// Files that take their names together: all of them, or none.
///
/// Dropped before it is finished it leaves nothing behind.
#[derive(Debug, Default)]
pub struct Together {
    written: Vec<(Target, tempfile::NamedTempFile, Forget)>,
    folders: Vec<(Target, tempfile::TempDir)>,
}

impl Together {
    /// Writes what is to replace the file at `path`; until [`finish`](Self::finish) that stays as it is.
    ///
    /// # Errors
    /// [`WriteError`] if the directory is not there, the file cannot be written, or `write` fails.
    pub fn write(
        &mut self,
        path: &Path,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        self.written.push(whole(path, write).map_err(at(path))?);
        Ok(())
    }

    /// Makes what is to be the folder at `path`, of files, each a path in it with its content.
    ///
    /// # Errors
    /// [`WriteError`] if a file is there already, it cannot be written, or `make` fails.
    pub fn folder(
        &mut self,
        path: &Path,
        make: impl FnOnce() -> io::Result<Vec<(String, String)>>,
    ) -> Result<(), WriteError> {
        let folder = whole_folder(path, make).map_err(at(path))?;
        self.folders.push(folder);
        Ok(())
    }

    /// Gives all files and folders their names.
    ///
    /// # Errors
    /// [`WriteError`] if one cannot have its name, though it could be written beside it; those before it have theirs, then.
    pub fn finish(self) -> Result<(), WriteError> {
        // Outlives the list's lock, which it takes when it goes.
        let mut forgotten = Vec::new();
        let mut named = Ok(());
        // Held until the last has its name, so that nobody who asks the program to end gets some of them.
        let being_written = being_written();
        for (target, temporary, forget) in self.written {
            forgotten.push(forget);
            if named.is_ok() {
                let made = temporary.persist(&target.path).map(drop);
                named = made.map_err(|error| at(&target.path)(error.error));
                // The name reaches the disk, too; where that cannot be had, the file is in its place all the same.
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

/// Says which file an error is of.
fn at(path: &Path) -> impl FnOnce(io::Error) -> WriteError {
    let path = path.to_owned();
    |source| WriteError { path, source }
}

/// The folder that a path stands in.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Checks, without writing it, whether a file can be written.
///
/// # Errors
/// [`WriteError`] if it cannot.
pub(super) fn check_writable(path: &Path) -> Result<(), WriteError> {
    let check = || {
        let target = Target::of(path)?;
        // Goes as it comes: it has no name, or loses it at once.
        tempfile::tempfile_in(target.directory()).map(drop)
    };
    check().map_err(at(path))
}

/// Exit code of an interrupted program (128 + SIGINT), as shells report it; 128 + SIGTERM where it was asked to end.
static EXIT_CODE: AtomicU8 = AtomicU8::new(130);

/// Removes temporary files when the program is interrupted or asked to end, says so, and ends it. Work that [`interrupt_stops`] is
/// stopped instead, the first time.
///
/// A signal that the program was started to ignore (`nohup`) stays ignored.
pub fn clean_up_when_asked_to_end() {
    let is_terminated = Arc::new(AtomicBool::new(false));
    let asked_to_end = Arc::clone(&is_terminated);
    // Without a handler, temporary files are removed when the same file is written again.
    let set = ctrlc::try_set_handler(move || {
        // Both handlers of the signal have run by then.
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
                "loopscope: {word}; what was found so far follows. Interrupt again to end at once"
            );
            work.cancel();
            return;
        }
        // Held until the end, so that no new one begins.
        let being_written = being_written();
        for path in being_written.iter() {
            let _ = fs::remove_file(path);
        }
        let _ = writeln!(io::stderr(), "loopscope: {word}");
        std::process::exit(interrupted_code().into())
    });
    #[cfg(unix)]
    if set.is_ok() {
        // It calls the handler above, too.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGTERM, is_terminated);
    }
    #[cfg(not(unix))]
    let _ = (set, is_terminated);
}

/// Returns the exit code of a program that was interrupted or asked to end.
pub fn interrupted_code() -> u8 {
    EXIT_CODE.load(Ordering::SeqCst)
}

/// Lets the first interrupt stop this work instead of the program.
pub fn interrupt_stops(progress: &Progress) {
    *work() = Some(progress.clone());
}

/// The work that an interrupt stops.
fn work() -> MutexGuard<'static, Option<Progress>> {
    static WORK: Mutex<Option<Progress>> = Mutex::new(None);
    WORK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The temporary files of this program.
fn being_written() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    static PATHS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    PATHS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where a file goes.
#[derive(Debug)]
struct Target {
    path: PathBuf,
    /// What the file there may be used for.
    permissions: Option<fs::Permissions>,
}

impl Target {
    fn of(path: &Path) -> io::Result<Self> {
        // Through a link to the file it names, so that the link stays a link.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let old = fs::metadata(&path).ok();
        if old.as_ref().is_some_and(fs::Metadata::is_dir) {
            return Err(io::Error::other(
                "this is a directory; name a file in it, or with a / at the end a new directory",
            ));
        }
        if old.as_ref().is_some_and(|old| !old.is_file()) {
            return Err(io::Error::other("this is no file but a pipe or a device; name a file"));
        }
        let permissions = old.map(|old| old.permissions());
        let target = Self { path, permissions };
        if !target.directory().is_dir() {
            // Not the system's own message: that names a temporary file which nobody asked for.
            let message = format!("there is no directory {}", target.directory().display());
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

    /// What the names of its temporary files begin with.
    fn prefix(&self) -> String {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let name: String = name.chars().take(NAME_CHARS).collect();
        format!("{}{name}-", TEMPORARY.0)
    }

    /// A new file beside it, which is forgotten once it is gone or has its name.
    fn temporary(&self) -> io::Result<(Forget, tempfile::NamedTempFile)> {
        let prefix = self.prefix();
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(TEMPORARY.1);
        let file = builder.make_in(self.directory(), |path| {
            let mut being_written = being_written();
            let file = new_file(path)?;
            being_written.insert(path.to_owned());
            Ok(file)
        })?;
        Ok((Forget(file.path().to_owned()), file))
    }
}

/// Takes away what programs that are gone left in a folder of their own, whatever it was to become.
pub(crate) fn clean_up_in(folder: &Path) {
    clean_up(folder, TEMPORARY.0);
}

/// Takes away what programs that are gone left under names that begin so; a living one holds its lock.
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

/// A new file that nobody else takes for one that was left.
fn new_file(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    // The permissions are those of any new file; the default for temporary files is for the owner alone.
    options.write(true).create_new(true);
    loop {
        let file = options.open(path)?;
        // Where files cannot be locked, nothing that is left is taken away either.
        let _ = file.lock();
        // Another program may have locked it first, and taken it away.
        if path.exists() {
            return Ok(file);
        }
    }
}

/// Strikes a temporary file off the list of those that are written.
#[derive(Debug)]
struct Forget(PathBuf);

impl Drop for Forget {
    fn drop(&mut self) {
        being_written().remove(&self.0);
    }
}

/// The whole content in a temporary file beside the one that it is to replace.
fn whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<(Target, tempfile::NamedTempFile, Forget)> {
    let target = Target::of(path)?;
    clean_up(target.directory(), &target.prefix());
    let (forget, temporary) = target.temporary()?;
    // The file itself: the messages of the temporary one say its name, which nobody asked for.
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

/// Makes a folder of files, each a path in it with its content, beside where it is to be.
fn whole_folder(
    path: &Path,
    make: impl FnOnce() -> io::Result<Vec<(String, String)>>,
) -> io::Result<(Target, tempfile::TempDir)> {
    let target = Target::of(path)?;
    if target.permissions.is_some() {
        return Err(io::Error::other("this is there already, as a file"));
    }
    let files = make()?;
    // In a folder that goes whatever happens; inside, so that the permissions are those of any new one.
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

/// What a folder is called until it has its name.
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
        assert!(again.unwrap_err().to_string().contains("new directory"));
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

    /// The second fails when the first is written already; the third, once all are, cannot have its name.
    #[test]
    fn files_that_are_written_together_are_all_there_or_none_is() {
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

    /// Two that were left, one of a program that still writes and one of another file.
    #[test]
    fn what_a_dead_program_left_goes_and_what_a_living_one_writes_stays() {
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
    fn while_it_is_written_a_file_is_known_and_locked() {
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

    /// The file system is full, or the reader is gone: the system's own words, and the name that was asked for.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_failure_names_the_file_and_not_the_temporary() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        let error = write_atomically(&path, |_| {
            File::options().write(true).open("/dev/full")?.write_all(b"x")
        });
        let told = error.unwrap_err().to_string();
        assert!(told.contains("a.txt") && told.contains("No space"), "{told}");
        assert!(!told.contains(".part"), "{told}");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_never_replaced() {
        let error = write_atomically(Path::new("/dev/null"), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("a device"), "{error}");
    }
}
