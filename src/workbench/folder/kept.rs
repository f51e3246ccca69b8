//! Models that were removed: their bytes, so that taking the step back brings back the same ones, whatever has become of their files.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

use super::{placed, stamp};
use crate::workbench::WorkbenchError;
use crate::workbench::choices::ChosenModel;
use crate::workbench::project::Stamp;
use crate::world::scratch;

/// All copies together, bytes. Of what goes beyond, the file itself is all there is.
const MOST_KEPT: u64 = 2 << 30;

/// A removed model.
#[derive(Debug)]
struct KeptModel {
    stamp: Stamp,
    copy: Option<PathBuf>,
}

/// The removed models by their numbers, in a folder that goes with the workbench, or, where that is killed, with the next slicer.
#[derive(Debug, Default)]
pub(in crate::workbench) struct Kept {
    folder: Option<(tempfile::TempDir, File)>,
    models: BTreeMap<u64, KeptModel>,
}

impl Kept {
    /// Keeps what the file of a model is now; where there is no space, only what it was.
    pub(in crate::workbench) fn keep(&mut self, model: &ChosenModel, folder: &Path) {
        let path = folder.join(&model.path);
        let now = stamp(&path);
        let all: u64 =
            self.models.values().filter(|kept| kept.copy.is_some()).filter_map(|kept| Some(kept.stamp?.0)).sum();
        let fits = now.is_some_and(|(size, _)| all.saturating_add(size) <= MOST_KEPT);
        let copy = fits.then(|| self.copy(model.id, &path)).flatten();
        self.models.insert(model.id, KeptModel { stamp: now, copy });
    }

    fn copy(&mut self, id: u64, path: &Path) -> Option<PathBuf> {
        let folder = match self.folder.take() {
            Some(folder) => folder,
            None => scratch(&format!("removed-{}-", std::process::id())).ok()?,
        };
        let to = self.folder.insert(folder).0.path().join(id.to_string());
        std::fs::copy(path, &to).ok().map(|_| to)
    }

    /// Puts a model back: where its file is another one now, beside it. Its file's name.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotKept`] and [`WorkbenchError::Folder`].
    pub(in crate::workbench) fn bring_back(
        &self,
        model: &ChosenModel,
        folder: &Path,
    ) -> Result<String, WorkbenchError> {
        let own = model.path.clone();
        let Some(kept) = self.models.get(&model.id) else { return Ok(own) };
        // One that was not there before is not there now.
        if kept.stamp.is_none() || stamp(&folder.join(&own)) == kept.stamp {
            return Ok(own);
        }
        let copy = kept.copy.as_ref().ok_or_else(|| WorkbenchError::NotKept { name: model.name().to_owned() })?;
        let failed = |source| WorkbenchError::Folder { path: folder.to_owned(), source };
        // Beyond the project's folder nothing is written.
        let inside = Path::new(&own).parent().filter(|parent| parent.is_relative() && folder.join(parent).is_dir());
        let below = inside.unwrap_or(Path::new(""));
        let mut from = File::open(copy).map_err(failed)?;
        let mut file = tempfile::NamedTempFile::new_in(folder.join(below)).map_err(failed)?;
        std::io::copy(&mut from, &mut file).map_err(failed)?;
        let when = kept.stamp.map(|(_, ns)| UNIX_EPOCH + Duration::from_nanos(u64::try_from(ns).unwrap_or(u64::MAX)));
        // What was made of it is current again: it is the same file.
        when.map(|when| file.as_file().set_modified(when)).transpose().map_err(failed)?;
        let name = placed(&folder.join(below), model.name(), file).map_err(failed)?;
        Ok(below.join(name).to_string_lossy().into_owned())
    }

    /// Forgets all but these.
    pub(in crate::workbench) fn retain(&mut self, wanted: &BTreeSet<u64>) {
        self.models.retain(|id, kept| {
            let stays = wanted.contains(id);
            kept.copy.as_ref().filter(|_| !stays).into_iter().for_each(|copy| _ = std::fs::remove_file(copy));
            stays
        });
    }

    /// Forgets all.
    pub(in crate::workbench) fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(path: &str) -> ChosenModel {
        ChosenModel { id: 7, path: path.to_owned(), copies: 1 }
    }

    #[test]
    fn a_model_comes_back_with_its_bytes_and_replaces_no_other_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sub/a.stl");
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        std::fs::write(&path, "one").unwrap();
        let (mut kept, a, before) = (Kept::default(), model("sub/a.stl"), stamp(&path));
        kept.keep(&a, folder.path());
        assert_eq!(kept.bring_back(&a, folder.path()).unwrap(), "sub/a.stl");
        std::fs::remove_file(&path).unwrap();
        assert_eq!(kept.bring_back(&a, folder.path()).unwrap(), "sub/a.stl");
        assert_eq!((std::fs::read_to_string(&path).unwrap().as_str(), stamp(&path)), ("one", before));
        std::fs::write(&path, "another").unwrap();
        assert_eq!(kept.bring_back(&a, folder.path()).unwrap(), "sub/a-2.stl");
        assert_eq!(std::fs::read_to_string(folder.path().join("sub/a-2.stl")).unwrap(), "one");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "another");
        let copies = kept.folder.as_ref().unwrap().0.path().to_owned();
        assert!(copies.join("7").exists());
        kept.retain(&BTreeSet::new());
        assert!(!copies.join("7").exists());
        kept.clear();
        assert!(!copies.exists());
    }

    #[test]
    fn outside_of_the_folder_nothing_is_written_and_what_was_not_kept_is_said() {
        let (folder, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let path = outside.path().join("b.stl");
        std::fs::write(&path, "far").unwrap();
        let (mut kept, b) = (Kept::default(), model(&path.display().to_string()));
        kept.keep(&b, folder.path());
        std::fs::remove_file(&path).unwrap();
        assert_eq!(kept.bring_back(&b, folder.path()).unwrap(), "b.stl");
        assert!(!path.exists());
        // Of a file that was too large or not to be read there is no copy.
        kept.models.get_mut(&7).unwrap().copy = None;
        assert_eq!(kept.bring_back(&b, folder.path()).unwrap_err().code(), "workbench/not-kept");
    }
}
