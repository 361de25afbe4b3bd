//! Actions of the user. Quick actions are done at once, slow ones in the background.

use std::sync::Arc;

use super::{Action, Engine, Leaving};
use crate::{
    engine::{live::Follow, query::Background as _, saving::Output, undo::History},
    questions::models::asked::{Train, TryModels},
};

impl Engine {
    /// Carries out an action of the user. Slow work runs in the background.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Edit(edit) => self.edit(edit),
            Action::Undo => self.travel(History::undo),
            Action::Redo => self.travel(History::redo),
            Action::Show(view) => self.project.view = view,
            Action::New => self.leave_for(Leaving::New),
            Action::Close => self.leave_for(Leaving::Close),
            Action::Stay => self.leaving = None,
            Action::Discard => self.leave(),
            Action::Restore(path) => self.restore(path),
            Action::DropLeft(path) => self.drop_left(&path),
            Action::ShowLeft(yes) => self.show_left(yes),
            Action::Open(paths) => self.open(paths),
            Action::OpenBuiltIn(late) => self.simulate(late),
            Action::Tare(which, tare) => self.tare(&which, tare),
            Action::ChangeColumns(change) => self.change_columns(change),
            Action::LeaveOutFaulty => self.leave_out_faulty(),
            Action::Locate(place) => self.locate(place),
            Action::Forget(at) => self.forget(at),
            Action::Import(command) => self.import(command),
            Action::Save(content, path, existing) => {
                self.save(Output { content, paths: vec![path], existing });
            }
            Action::Export(paths, existing) => self.export(paths, existing),
            Action::Replace(yes) => self.replace(yes),
            Action::Train => self.train(),
            Action::StopTraining => self.lane::<Train>().cancel(),
            Action::ChooseBlock(block, measure) => self.choose_block(block, measure),
            Action::FindBest(candidates, limit) => self.find_best(candidates, limit),
            Action::StopTrying => self.lane::<TryModels>().cancel(),
            Action::KeepModel => self.keep_model(),
            Action::RemoveModel(id) => self.models.remove(id),
            Action::BringBack(id) => self.bring_back(id),
            Action::Follow(path) => {
                self.following.cancel();
                self.following.ask_again(Follow { path, calibration: Arc::clone(&self.current) });
            }
            Action::StopFollowing => self.following.forget(),
            Action::Cancel => {
                self.lanes.cancel();
                self.tasks.cancel();
            }
            Action::Notice(notice) => self.show_notice(notice),
            Action::Dismiss(at) if at < self.notices.len() => drop(self.notices.remove(at)),
            Action::Dismiss(_) => {}
            Action::DismissAll => self.notices.clear(),
            Action::Prefer(preferences) => self.preferences = preferences,
        }
        self.follow();
    }
}
