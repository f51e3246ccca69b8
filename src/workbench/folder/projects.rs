//! Project files in the project's folder: saved, and unpacked beside what is there.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use tempfile::NamedTempFile;

use super::{placed, received};
use crate::profile::Base;
use crate::workbench::WorkbenchError;
use crate::workbench::archive::{Archive, ArchiveWriter, PLAN};
use crate::workbench::choices::Choices;
use crate::workbench::doors::{PROJECT, plain_of};

/// The largest profile that is read of a project.
const MOST_PROFILE: u64 = 1 << 20;

/// Unpacks the project file at `path` into `folder`, where it replaces no other file; what was chosen.
///
/// # Errors
///
/// [`WorkbenchError::ProjectUnread`], [`WorkbenchError::Folder`] and those of [`Archive`].
pub(in crate::workbench) fn unpack(path: &Path, folder: &Path) -> Result<Choices, WorkbenchError> {
    let (file, name, size) = found(path)?;
    unpacked(file, &name, size, folder)
}

/// What was chosen in the project file at `path`, by the names in it; nothing is unpacked.
///
/// # Errors
///
/// [`WorkbenchError::ProjectUnread`] and those of [`Archive`].
pub(in crate::workbench) fn chosen(path: &Path) -> Result<Choices, WorkbenchError> {
    let (file, name, size) = found(path)?;
    Archive::open(file, &name, size)?.choices()
}

/// A project file with its name and size.
fn found(path: &Path) -> Result<(BufReader<File>, String, u64), WorkbenchError> {
    let unread = |source| WorkbenchError::ProjectUnread { path: path.to_owned(), source };
    let file = File::open(path).map_err(unread)?;
    let size = file.metadata().map_err(unread)?.len();
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((BufReader::new(file), name, size))
}

/// The same of one that comes as the `length` bytes of `body`.
///
/// # Errors
///
/// Those of [`unpack`], and [`WorkbenchError::BadRequest`] where the body is too short.
pub(in crate::workbench) fn unpacked_upload(
    folder: &Path,
    name: &str,
    length: u64,
    body: &mut dyn Read,
) -> Result<Choices, WorkbenchError> {
    let failed = |source| WorkbenchError::Folder { path: folder.to_owned(), source };
    let mut file = received(folder, length, body)?;
    file.rewind().map_err(failed)?;
    unpacked(BufReader::new(file.as_file_mut()), name, length, folder)
}

fn unpacked(from: impl Read + Seek, name: &str, size: u64, folder: &Path) -> Result<Choices, WorkbenchError> {
    let failed = |source| WorkbenchError::Folder { path: folder.to_owned(), source };
    let mut archive = Archive::open(from, name, size)?;
    let mut choices = archive.choices()?;
    let mut all = Vec::new();
    let plan = archive.has(PLAN).then_some(PLAN);
    // Nothing has a place before everything is there.
    for member in choices.files().into_iter().chain(plan) {
        let mut file = NamedTempFile::new_in(folder).map_err(failed)?;
        archive.unpack(member, &mut file)?;
        all.push((member.to_owned(), file));
    }
    if let Some((machine, file)) = all.iter().find(|(member, _)| choices.machine.as_ref() == Some(member)) {
        by_itself(name, machine, file.path()).unwrap_or_else(|source| Err(failed(source)))?;
    }
    for (member, _) in &all {
        if leads_out(folder, member).map_err(failed)? {
            return Err(WorkbenchError::ProjectName { project: name.to_owned(), name: member.clone() });
        }
    }
    let mut places = BTreeMap::new();
    let mut plan = None;
    for (member, file) in all {
        if member == PLAN && !choices.files().contains(&PLAN) {
            plan = Some(file);
            continue;
        }
        let (below, plain) = member.rsplit_once('/').unwrap_or(("", &member));
        let place = folder.join(below);
        std::fs::create_dir_all(&place).map_err(failed)?;
        let named = placed(&place, plain, file).map_err(failed)?;
        places.insert(member.clone(), if below.is_empty() { named } else { format!("{below}/{named}") });
    }
    choices.renamed(&places);
    // A plan that is there is that of something else, or this one.
    if let (Some(plan), Some(output)) = (plan, choices.output("plan.json")) {
        let _ = plan.persist_noclobber(folder.join(output));
    }
    Ok(choices)
}

/// Whether a link that is there already leads out of `folder` on the way to this member's place.
fn leads_out(folder: &Path, member: &str) -> std::io::Result<bool> {
    let place = folder.join(member);
    let there = place.ancestors().skip(1).find(|path| path.exists()).unwrap_or(folder);
    Ok(!there.canonicalize()?.starts_with(folder.canonicalize()?))
}

/// That a profile needs no other file than itself.
fn by_itself(project: &str, machine: &str, path: &Path) -> std::io::Result<Result<(), WorkbenchError>> {
    let mut text = String::new();
    File::open(path)?.take(MOST_PROFILE).read_to_string(&mut text)?;
    // What is no profile is said when it is read as one.
    Ok(match Base::of(machine, &text) {
        Ok(Base::File(name)) => Err(WorkbenchError::ProjectName { project: project.to_owned(), name }),
        _ => Ok(()),
    })
}

/// What is saved besides the choices.
pub(in crate::workbench) struct Saving<'a> {
    /// The text of a machine that is a file.
    pub(in crate::workbench) machine: Option<String>,
    /// The plan's file, where it is that of what is chosen.
    pub(in crate::workbench) plan: Option<&'a str>,
    /// The file that this workbench has opened or saved, and may replace.
    pub(in crate::workbench) own: Option<&'a str>,
    /// The name of a new one, without its ending.
    pub(in crate::workbench) stem: &'a str,
}

/// Saves a project in `folder`; the file's name.
///
/// # Errors
///
/// [`WorkbenchError::NotYet`], [`WorkbenchError::ProjectUnread`] and [`WorkbenchError::Folder`].
pub(in crate::workbench) fn save(
    folder: &Path,
    choices: &Choices,
    saving: &Saving<'_>,
) -> Result<String, WorkbenchError> {
    let failed = |source| WorkbenchError::Folder { path: folder.to_owned(), source };
    let mut inside = choices.clone();
    let members = inside.name_for_project(saving.machine.is_some());
    let mut file = NamedTempFile::new_in(folder).map_err(failed)?;
    let mut archive = ArchiveWriter::new(file.as_file_mut(), &inside.prepare()?).map_err(failed)?;
    for (path, member) in &members {
        let open =
            File::open(folder.join(path)).map_err(|source| WorkbenchError::ProjectUnread { path: path.into(), source });
        archive.add(member, &mut open?).map_err(failed)?;
    }
    if let (Some(text), Some(member)) = (&saving.machine, &inside.machine) {
        archive.add(member, &mut text.as_bytes()).map_err(failed)?;
    }
    if let Some(mut plan) = saving.plan.and_then(|name| File::open(folder.join(name)).ok()) {
        archive.add(PLAN, &mut plan).map_err(failed)?;
    }
    archive.finish().map_err(failed)?;
    match saving.own {
        Some(own) => {
            #[cfg(unix)]
            file.as_file().set_permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644)).map_err(failed)?;
            file.persist(folder.join(own)).map_err(|error| failed(error.error))?;
            Ok(own.to_owned())
        }
        None => placed(folder, &plain_of(&format!("{}{PROJECT}", saving.stem)), file).map_err(failed),
    }
}
