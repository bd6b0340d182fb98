//! Files that are written completely or not at all.

use std::{
    collections::BTreeSet,
    fs::{self, File},
    io::{self, BufWriter, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// A file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", sink(path))]
pub struct WriteError {
    /// The file, or `-` for standard output.
    pub path: PathBuf,
    /// The error of the operating system.
    pub source: io::Error,
}

fn sink(path: &Path) -> String {
    if path == Path::new("-") {
        return "standard output".into();
    }
    path.display().to_string()
}

impl WriteError {
    /// The error at this file, or at `-` for standard output.
    pub fn new(path: &Path, source: io::Error) -> Self {
        Self {
            path: path.into(),
            source,
        }
    }
}

/// Why files are refused before anything is written.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Two options name one file.
    #[error("{} and {} both write {}, expected two files", options[0], options[1], path.display())]
    Twice {
        /// The options.
        options: [String; 2],
        /// The file.
        path: PathBuf,
    },
    /// A file that is read would be replaced.
    #[error(
        "{option} is {}, which is read, expected another file: it would be replaced",
        path.display()
    )]
    Input {
        /// The option.
        option: String,
        /// The file.
        path: PathBuf,
    },
    /// The name of standard output, where a file or folder is expected.
    #[error("{option} is `-`, expected the name of a file or folder; `./-` is one")]
    StandardOutput {
        /// The option.
        option: String,
    },
}

/// A file that is written under the name `FILE.part` and renamed on completion, so that an old file
/// is replaced atomically. A file that is dropped before [`WholeFile::complete`] is removed, as is
/// one of a program that calls [`abandon`] at its end; a program that is killed leaves `FILE.part`.
///
/// A device or a pipe of that name is written directly.
#[derive(Debug)]
pub struct WholeFile {
    writer: BufWriter<File>,
    /// The temporary and the final path; `None` for a device.
    places: Option<(PathBuf, PathBuf)>,
}

impl WholeFile {
    /// Opens a file of this name.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn create(path: &Path) -> io::Result<Self> {
        if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Ok(Self {
                writer: BufWriter::new(File::create(path)?),
                places: None,
            });
        }
        // A symbolic link to a file is kept.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".part");
        let part = path.with_file_name(name);
        let mut unfinished = unfinished();
        let file = File::create(&part)?;
        unfinished.insert(part.clone());
        Ok(Self {
            writer: BufWriter::new(file),
            places: Some((part, path)),
        })
    }

    /// Completes the file and renames it.
    ///
    /// # Errors
    /// The error of the operating system; the file is removed then.
    pub fn complete(mut self) -> io::Result<()> {
        self.writer.flush()?;
        if let Some((part, path)) = &self.places {
            let mut unfinished = unfinished();
            fs::rename(part, path)?;
            unfinished.remove(part);
            self.places = None;
        }
        Ok(())
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if let Some((part, _)) = &self.places {
            let mut unfinished = unfinished();
            // A failure cannot be handled here.
            let _: io::Result<()> = fs::remove_file(part);
            unfinished.remove(part);
        }
    }
}

/// The temporary paths of all files that are being written.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // No code panics while it holds the lock.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all files that are not complete, for a program that ends now: threads that create or
/// complete a file wait from now on.
pub fn abandon() {
    let unfinished = unfinished();
    for part in unfinished.iter() {
        // A failure cannot be handled here.
        let _: io::Result<()> = fs::remove_file(part);
    }
    // The lock is never released.
    std::mem::forget(unfinished);
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl Seek for WholeFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.writer.seek(to)
    }
}

/// Writes a file as a [`WholeFile`].
///
/// # Errors
/// That of the operating system.
pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let result = WholeFile::create(path).and_then(|mut file| {
        file.write_all(content.as_ref())?;
        file.complete()
    });
    result.map_err(|source| WriteError::new(path, source))
}

/// Creates a folder that an option names, unless it exists.
///
/// # Errors
/// For a folder that cannot be created, and for `-`.
pub fn create_folder(option: &str, path: &Path) -> Result<(), CheckError> {
    if path == Path::new("-") {
        return Err(CheckError::StandardOutput {
            option: option.to_owned(),
        });
    }
    fs::create_dir_all(path).map_err(|source| WriteError::new(path, source).into())
}

/// Checks in advance that files, each with its option, can be written, are different, and are none
/// of the files that are read. No file is created or changed.
///
/// # Errors
/// For a file that cannot be written, for two options with one file, for a file that is read, and
/// for `-`: a caller that can write to standard output leaves it out.
pub fn check<'a>(
    files: &[(&str, &Path)],
    read: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), CheckError> {
    let read: BTreeSet<PathBuf> = read.into_iter().map(|path| place(path)).collect();
    for (index, (option, path)) in files.iter().enumerate() {
        let option_name = || (*option).to_owned();
        if *path == Path::new("-") {
            return Err(CheckError::StandardOutput {
                option: option_name(),
            });
        }
        if is_file(path) && read.contains(&place(path)) {
            return Err(CheckError::Input {
                option: option_name(),
                path: (*path).into(),
            });
        }
        let is_it = |(_, other): &&(&str, &Path)| is_file(path) && place(other) == place(path);
        if let Some((other, _)) = files[..index].iter().find(is_it) {
            return Err(CheckError::Twice {
                options: [other, option].map(|option| (*option).into()),
                path: (*path).into(),
            });
        }
        check_one(path).map_err(|source| WriteError::new(path, source))?;
    }
    Ok(())
}

/// Whether the path is a file or will be one: several outputs may go to one device.
fn is_file(path: &Path) -> bool {
    fs::metadata(path).map_or(true, |found| found.is_file())
}

fn check_one(path: &Path) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|found| found.is_dir()) {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    // Opening a pipe would affect its reader.
    match is_file(path) {
        true => WholeFile::create(path).map(drop),
        false => Ok(()),
    }
}

/// The canonical path of a file that may not exist yet.
fn place(path: &Path) -> PathBuf {
    let by_folder = || {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let folder = fs::canonicalize(folder.unwrap_or(Path::new(".")));
        folder.map(|folder| folder.join(path.file_name().unwrap_or_default()))
    };
    let place = fs::canonicalize(path).or_else(|_| by_folder());
    place.unwrap_or_else(|_| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_else_remains() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("report.html");
        write(&path, "old").expect("a first one");
        write(&path, "new").expect("a second one");
        assert_eq!(fs::read_to_string(&path).expect("the file"), "new");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
    }

    #[test]
    fn the_error_of_an_unwritable_file_names_it_and_no_file_remains() {
        let folder = tempfile::tempdir().expect("a folder");
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).expect("a folder in the way");
        let error = write(&taken, "text").expect_err("no file").to_string();
        assert!(error.contains("taken"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
    }

    #[test]
    fn the_old_file_is_kept_until_the_new_one_is_complete() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.csv");
        write(&path, "old").expect("an old one");
        let mut half = WholeFile::create(&path).expect("a new one");
        half.write_all(b"ne").expect("its first half");
        half.flush().expect("on the disk");
        assert_eq!(fs::read_to_string(&path).expect("the file"), "old");
        drop(half);
        assert_eq!(fs::read_to_string(&path).expect("the file"), "old");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
    }

    #[test]
    fn files_are_checked_without_a_trace() {
        let folder = tempfile::tempdir().expect("a folder");
        let [page, data] = ["page.html", "data.json"].map(|name| folder.path().join(name));
        let none: [PathBuf; 0] = [];
        check(&[("--html", &page), ("--json", &data)], &none).expect("both can be written");
        write(&page, "old").expect("an old one");
        check(&[("--html", &page)], &[data]).expect("it can be replaced");
        assert_eq!(fs::read_to_string(&page).expect("the file"), "old");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);

        let roundabout = folder.path().join(".").join("page.html");
        let both = [("--html", &*page), ("--json", &*roundabout)];
        let error = check(&both, &none).expect_err("one file");
        assert!(
            error.to_string().contains("--html and --json both write"),
            "{error}"
        );
        let read = check(&both[..1], [&roundabout]).expect_err("it is read");
        assert!(read.to_string().contains("which is read"), "{read}");
        let dash = check(&[("--html", Path::new("-"))], &none).expect_err("no file");
        assert!(dash.to_string().contains("--html is `-`"), "{dash}");
        for bad in [folder.path().into(), folder.path().join("none/page.html")] {
            assert!(matches!(
                check(&[("--html", &bad)], &none),
                Err(CheckError::Write(_))
            ));
        }
        let device = Path::new("/dev/null");
        if cfg!(unix) {
            let both = [("--html", device), ("--json", device)];
            check(&both, &[device.into()]).expect("a device takes both");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_and_devices_are_written_through() {
        let folder = tempfile::tempdir().expect("a folder");
        let [path, link] = ["run.csv", "latest.csv"].map(|name| folder.path().join(name));
        write(&path, "old").expect("the file");
        std::os::unix::fs::symlink(&path, &link).expect("a link");
        write(&link, "new").expect("through the link");
        assert!(fs::symlink_metadata(&link).expect("it is").is_symlink());
        assert_eq!(fs::read_to_string(&path).expect("the file"), "new");

        write(Path::new("/dev/null"), "text").expect("a device takes it");
        assert!(!fs::metadata("/dev/null").expect("it is").is_file());
    }
}
