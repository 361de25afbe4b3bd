//! Writes files, and asks before it replaces existing ones.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Engine;
use crate::{
    calibration::Calibration,
    engine::{
        notice::Level,
        project::Project,
        saving::{Doubt, Existing, FileContent, Output, Unwritten},
        session::trained_beside,
        tasks::Task,
    },
    export::{TargetError, check_targets, known_target},
    finding::{Advice, Face},
    progress::Progress,
    questions::question::Unanswered,
    shown::file_name,
};

impl Engine {
    /// Writes the files that wait for confirmation in [`Engine::replacing`] if `yes`; otherwise drops them.
    pub(super) fn replace(&mut self, yes: bool) {
        let answered = std::mem::replace(&mut self.replacing, self.replaced_next.pop());
        match answered.filter(|_| yes) {
            None => {}
            Some((output, Doubt::IsThere)) => {
                self.save(Output { existing: Existing::Replace, ..output });
            }
            Some((output, Doubt::Undetermined(_))) => self.save_whole(output),
        }
    }

    pub(super) fn save(&mut self, mut output: Output) {
        for path in &mut output.paths {
            if let Ok(absolute) = std::path::absolute(&*path) {
                *path = absolute;
            }
        }
        // The files of the loaded recordings must not be overwritten.
        let inputs: Vec<PathBuf> = self.project.files().map(Path::to_owned).collect();
        let Output { content, paths, existing } = output;
        let title = match &paths[..] {
            [one] => format!("Writing {}", file_name(one)),
            many => format!("Writing {} files", many.len()),
        };
        let is_seen = content.takes_long();
        let write = move |progress: &Progress| {
            let whole = content.handed_over(progress).map_err(Unanswered::Because)?;
            let replaces = existing == Existing::Replace;
            let write = |path: &PathBuf| match check_targets(&inputs, &whole.files(path), replaces)
            {
                Err(TargetError::Exists { .. }) => Err(Unwritten::Exists),
                Err(error) => Err(Unwritten::Because(error.text(Face::Window))),
                Ok(()) => whole.write(path, progress).map_err(Unwritten::Because),
            };
            let written: Vec<_> = paths.iter().map(|path| (path.clone(), write(path))).collect();
            Ok((content, written))
        };
        let take = |engine: &mut Self, (content, files)| engine.take_written(content, files);
        self.tasks.begin(Task::new(title, write, take).seen_if(is_seen), None);
    }

    pub(super) fn export(&mut self, mut paths: Vec<PathBuf>, existing: Existing) {
        let Some(content) = self.calibration_content() else {
            self.notice(Level::Error, "There is no calibration to export yet");
            return;
        };
        paths.retain(|path| {
            let unknown = known_target(path).err();
            let is_known = unknown.is_none();
            unknown.into_iter().for_each(|text| self.notice(Level::Error, text));
            is_known
        });
        let output = Output { content, paths, existing };
        // A calibration that comes with a request was fitted in this session, not read from a file.
        if let FileContent::Calibration(calibration, Some(_)) = &output.content
            && let Some(undetermined) = calibration.undetermined()
        {
            self.ask_before_writing(output, Doubt::Undetermined(undetermined));
        } else {
            self.save_whole(output);
        }
    }

    /// Writes the whole content to its files, with a warning for each file format that cannot hold a part of a calibration.
    fn save_whole(&mut self, output: Output) {
        for caution in output.paths.iter().filter_map(|path| output.content.caution(path)) {
            self.notice(Level::Warning, caution);
        }
        self.save(output);
    }

    /// Reports which files were written, and asks whether those that exist may be replaced.
    fn take_written(&mut self, content: FileContent, files: Vec<(PathBuf, Result<(), Unwritten>)>) {
        let (mut existing, mut results) = (Vec::new(), BTreeMap::new());
        for (path, written) in files {
            let result = match (written, &content) {
                (Err(Unwritten::Exists), _) => {
                    existing.push(path);
                    continue;
                }
                (Err(Unwritten::Because(reason)), _) => Err(reason),
                (Ok(()), FileContent::Session(session, trained)) => {
                    self.take_saved(session.project.clone(), trained.clone(), path);
                    continue;
                }
                (Ok(()), _) => Ok(()),
            };
            match &result {
                Ok(()) => self.notice(Level::Info, format!("Wrote {}", path.display())),
                Err(reason) => self.notice(Level::Error, reason),
            }
            results.insert(path, result);
        }
        if let FileContent::Calibration(..) | FileContent::Report(..) = content {
            let earlier = self.exported.take().filter(|(of, _)| *of == self.project);
            let mut all = earlier.map_or_else(BTreeMap::new, |(_, files)| files);
            all.extend(results);
            self.exported = Some((self.project.clone(), all));
        }
        if !existing.is_empty() {
            let output = Output { content, paths: existing, existing: Existing::Ask };
            self.ask_before_writing(output, Doubt::IsThere);
        }
    }

    fn ask_before_writing(&mut self, output: Output, doubt: Doubt) {
        if self.replacing.is_none() {
            self.replacing = Some((output, doubt));
        } else {
            self.replaced_next.push((output, doubt));
        }
    }

    fn take_saved(&mut self, project: Project, trained: Option<Arc<Calibration>>, path: PathBuf) {
        self.preferences.remember(&path);
        let beside = trained.as_ref().map(|_| trained_beside(&path));
        let beside = beside.map_or_else(String::new, |path| {
            format!(", with the trained calibration {}", path.display())
        });
        self.notice(Level::Info, format!("Saved the session {}{beside}", path.display()));
        self.session = Some(path);
        self.saved = Some(project);
        self.saved_trained = trained;
        if !self.is_unsaved() {
            self.leave();
        }
    }
}
