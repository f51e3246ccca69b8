//! The project's folder: models that are dropped into it, what a job has written there, and whether a file has changed.

mod kept;
mod projects;

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use super::WorkbenchError;
use super::doors::model_name;
use super::project::Stamp;

pub(super) use kept::Kept;
pub(super) use projects::{Saving, chosen, save, unpack, unpacked_upload};

const PIECE: usize = 1 << 16;
/// Names that are tried for a model whose own name is taken.
const MOST_NAMES: usize = 1000;

/// The folder, which must take files.
///
/// # Errors
///
/// [`WorkbenchError::Folder`].
pub(super) fn opened(path: &Path) -> Result<PathBuf, WorkbenchError> {
    let failed = |source| WorkbenchError::Folder { path: path.to_owned(), source };
    std::fs::create_dir_all(path).map_err(failed)?;
    tempfile::NamedTempFile::new_in(path).map_err(failed)?;
    std::fs::canonicalize(path).map_err(failed)
}

/// The working folder.
///
/// # Errors
///
/// [`WorkbenchError::Folder`].
pub(super) fn working() -> Result<PathBuf, WorkbenchError> {
    std::env::current_dir().map_err(|source| WorkbenchError::Folder { path: PathBuf::from("."), source })
}

/// Makes `folder` the working folder, so that names of files mean here what they mean to a job.
///
/// # Errors
///
/// [`WorkbenchError::Folder`].
pub(super) fn work_in(folder: &Path) -> Result<(), WorkbenchError> {
    std::env::set_current_dir(folder).map_err(|source| WorkbenchError::Folder { path: folder.to_owned(), source })
}

/// A page that sends a browser to `address`, for this user's eyes alone; it goes when it is dropped.
///
/// # Errors
///
/// [`WorkbenchError::Folder`].
pub(super) fn leading_to(address: &str, folder: &Path) -> Result<tempfile::NamedTempFile, WorkbenchError> {
    let made = || -> std::io::Result<tempfile::NamedTempFile> {
        // In the project's folder, with a name that is not hidden: some browsers see no other files.
        let mut file = tempfile::Builder::new().prefix("trunnion-open-").suffix(".html").tempfile_in(folder)?;
        let head = "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>trunnion</title>";
        writeln!(
            file,
            "{head}<meta http-equiv=\"refresh\" content=\"0;url={address}\"><a href=\"{address}\">trunnion workbench</a></html>"
        )?;
        Ok(file)
    };
    made().map_err(|source| WorkbenchError::Folder { path: folder.to_owned(), source })
}

/// What the file is now.
pub(super) fn stamp(path: &Path) -> Stamp {
    let data = std::fs::metadata(path).ok()?;
    let changed = data.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    Some((data.len(), changed.as_nanos()))
}

/// `model` (relative to the working folder, or absolute) as a command in `folder` names it.
pub(super) fn named(model: &Path, here: &Path, folder: &Path) -> String {
    let full = std::fs::canonicalize(here.join(model)).unwrap_or_else(|_| here.join(model));
    full.strip_prefix(folder).unwrap_or(&full).to_string_lossy().into_owned()
}

/// Writes a model of `length` bytes out of `body`; its name, which has a number where another file has the name already.
///
/// # Errors
///
/// [`WorkbenchError::BadName`], [`WorkbenchError::Folder`], and [`WorkbenchError::BadRequest`] where the body is too short.
pub(super) fn take(folder: &Path, name: &str, length: u64, body: &mut dyn Read) -> Result<String, WorkbenchError> {
    let name = model_name(name)?;
    let file = received(folder, length, body)?;
    placed(folder, name, file).map_err(|source| WorkbenchError::Folder { path: folder.to_owned(), source })
}

/// The `length` bytes of `body`, in a file that goes where it has no place.
fn received(folder: &Path, length: u64, body: &mut dyn Read) -> Result<tempfile::NamedTempFile, WorkbenchError> {
    let failed = |source| WorkbenchError::Folder { path: folder.to_owned(), source };
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(failed)?;
    let (mut left, mut piece) = (length, vec![0; PIECE]);
    while left > 0 {
        let most = piece.len().min(usize::try_from(left).unwrap_or(PIECE));
        let count = body.read(&mut piece[..most]).unwrap_or(0);
        if count == 0 {
            return Err(WorkbenchError::BadRequest { what: "the file ends early" });
        }
        file.write_all(&piece[..count]).map_err(failed)?;
        left -= count as u64;
    }
    Ok(file)
}

/// Puts the file in its place, which no other file has; its name.
///
/// # Errors
///
/// The system's.
pub(super) fn placed(folder: &Path, name: &str, mut file: tempfile::NamedTempFile) -> std::io::Result<String> {
    let (stem, end) = name.rsplit_once('.').unwrap_or((name, ""));
    #[cfg(unix)]
    file.as_file().set_permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644))?;
    for number in 1..=MOST_NAMES {
        let name = if number == 1 { name.to_owned() } else { format!("{stem}-{number}.{end}") };
        let path = folder.join(&name);
        // The same file again is the same model.
        if path.is_file() && same(&path, file.path()).unwrap_or(false) {
            return Ok(name);
        }
        match file.persist_noclobber(&path) {
            Ok(_) => return Ok(name),
            Err(failed) if failed.error.kind() == std::io::ErrorKind::AlreadyExists => file = failed.file,
            Err(failed) => return Err(failed.error),
        }
    }
    Err(std::io::ErrorKind::AlreadyExists.into())
}

fn same(a: &Path, b: &Path) -> std::io::Result<bool> {
    let (mut a, mut b) = (File::open(a)?, File::open(b)?);
    if a.metadata()?.len() != b.metadata()?.len() {
        return Ok(false);
    }
    let (mut first, mut second) = (vec![0; PIECE], vec![0; PIECE]);
    loop {
        let count = a.read(&mut first)?;
        if count == 0 {
            return Ok(true);
        }
        b.read_exact(&mut second[..count])?;
        if first[..count] != second[..count] {
            return Ok(false);
        }
    }
}

/// A file that a job has made, and its length.
///
/// # Errors
///
/// [`WorkbenchError::NotFound`].
pub(super) fn result(folder: &Path, name: &str) -> Result<(Box<dyn Read>, u64), WorkbenchError> {
    let file = File::open(folder.join(name)).map_err(|_| WorkbenchError::NotFound)?;
    let data = file.metadata().ok().filter(std::fs::Metadata::is_file).ok_or(WorkbenchError::NotFound)?;
    Ok((Box::new(file), data.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_keeps_its_name_and_replaces_no_other_file() {
        let folder = tempfile::tempdir().unwrap();
        let take = |name: &str, text: &str| take(folder.path(), name, text.len() as u64, &mut text.as_bytes());
        assert_eq!(take("a.stl", "one").unwrap(), "a.stl");
        assert_eq!(take("a.stl", "one").unwrap(), "a.stl");
        assert_eq!(take("a.stl", "two").unwrap(), "a-2.stl");
        assert_eq!(take("a.stl", "six").unwrap(), "a-3.stl");
        assert_eq!(std::fs::read_to_string(folder.path().join("a.stl")).unwrap(), "one");
        assert_eq!(take("../a.stl", "x").unwrap_err().code(), "workbench/bad-name");
        let short = super::take(folder.path(), "b.stl", 9, &mut "short".as_bytes()).unwrap_err();
        assert_eq!(short.code(), "workbench/bad-request");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    #[test]
    fn the_way_to_the_page_is_this_users_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = leading_to("http://127.0.0.1:1/#0f", folder.path()).unwrap();
        assert!(std::fs::read_to_string(file.path()).unwrap().contains("url=http://127.0.0.1:1/#0f\""));
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(file.as_file().metadata().unwrap().permissions().mode() & 0o777, 0o600);
        }
        drop(file);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn models_are_named_from_the_folder_where_they_lie_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let here = std::fs::canonicalize(folder.path()).unwrap();
        std::fs::create_dir(here.join("sub")).unwrap();
        std::fs::write(here.join("sub/a.stl"), "x").unwrap();
        assert_eq!(named(Path::new("sub/a.stl"), &here, &here), "sub/a.stl");
        assert_eq!(named(Path::new("sub/a.stl"), &here, &here.join("sub")), "a.stl");
        assert!(Path::new(&named(Path::new("sub/a.stl"), &here, Path::new("/elsewhere"))).is_absolute());
        assert_eq!(stamp(&here.join("none")), None);
    }
}
