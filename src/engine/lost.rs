//! Searches a folder for the missing files of a session. Each found file replaces at most one missing file, and only if no
//! other missing file fits it equally well.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::{
    engine::project::{SessionFile, absolute},
    export::sha256,
};

struct Claim {
    of: usize,
    path: PathBuf,
    /// How well the found file fits the missing one: true if their contents are equal, and the number of equal path
    /// components, counted from the file name.
    fits: (bool, usize),
}

/// Returns the indices of the missing files that were found, with their new paths. `place` is one of the files or their
/// folder. Files are recognised by name, by folder and by content. Files in `others` are already open and are not considered.
pub fn find(lost: &[SessionFile], place: &Path, others: &[PathBuf]) -> Vec<(usize, PathBuf)> {
    let place = absolute(place);
    let folder = if place.is_file() { place.parent().unwrap_or(Path::new("")) } else { &place };
    let parents = lost.iter().filter_map(|file| file.absolute.parent());
    let parents: BTreeSet<&Path> = parents.collect();
    let mut places: Vec<(usize, PathBuf)> = Vec::new();
    for (of, file) in lost.iter().enumerate() {
        let old = &file.absolute;
        for root in old.ancestors().skip(1) {
            places.push((of, folder.join(old.strip_prefix(root).unwrap_or(old))));
        }
        // If the last folder names of `folder` equal those of the old folder of another missing file, that folder was moved
        // to `folder`. This missing file may have been moved with it.
        for other in &parents {
            let n_same = common_tail(other, folder);
            let roots = other.ancestors().nth(n_same);
            if let Some((before, now)) = roots.zip(folder.ancestors().nth(n_same))
                && let Ok(inside) = old.strip_prefix(before)
            {
                places.push((of, now.join(inside)));
            }
        }
    }
    if place.is_file() && !places.iter().any(|(_, path)| *path == place) {
        // The user named this file, so it may be a missing file under a new name.
        let is_same = |of: &usize| lost.len() == 1 || holds_the_same(&lost[*of], &place);
        places.extend((0..lost.len()).find(is_same).map(|of| (of, place.clone())));
    }
    places.sort();
    places.dedup();
    places.retain(|(_, path)| path.is_file() && !others.contains(path));
    let claim = |(of, path): (usize, PathBuf)| Claim {
        of,
        fits: (false, common_tail(&lost[of].absolute, &path)),
        path,
    };
    choose(lost, places.into_iter().map(claim).collect())
}

/// Returns the best path for each missing file that was found. Equally good fits of one path to two missing files are left
/// out.
fn choose(lost: &[SessionFile], mut claims: Vec<Claim>) -> Vec<(usize, PathBuf)> {
    let meets = |a: &Claim, b: &Claim| a.of == b.of || a.path == b.path;
    for at in 0..claims.len() {
        let claim = &claims[at];
        // The contents are compared only where several paths or several missing files compete.
        if claims.iter().filter(|other| meets(claim, other)).count() > 1 {
            claims[at].fits.0 = holds_the_same(&lost[claim.of], &claim.path);
        }
    }
    claims.sort_by_key(|claim| std::cmp::Reverse(claim.fits));
    let mut found: Vec<(usize, PathBuf)> = Vec::new();
    for claim in &claims {
        let is_free = |other: &Claim| {
            let met = |(of, path): &(usize, PathBuf)| *of == other.of || *path == other.path;
            !found.iter().any(met)
        };
        let rivals = |other: &&Claim| {
            other.path == claim.path && other.of != claim.of && other.fits == claim.fits
        };
        if is_free(claim) && !claims.iter().filter(rivals).any(is_free) {
            found.push((claim.of, claim.path.clone()));
        }
    }
    found.sort();
    found
}

/// Returns true if the file has the content of the missing file. Contents are compared by the hash in the session.
fn holds_the_same(lost: &SessionFile, path: &Path) -> bool {
    lost.sha256.is_some() && !is_another(lost, path)
}

fn common_tail(one: &Path, other: &Path) -> usize {
    let names = |path: &Path| {
        let names = path.iter().map(ToOwned::to_owned);
        names.rev().collect::<Vec<_>>()
    };
    let both = names(one).into_iter().zip(names(other));
    both.take_while(|(one, other)| one == other).count()
}

/// Returns true if the file's length or hash differs from the values that the session has saved.
pub fn is_another(file: &SessionFile, found: &Path) -> bool {
    let bytes = fs::metadata(found).ok().map(|metadata| metadata.len());
    let other_length = file.bytes.is_some() && bytes.is_some() && file.bytes != bytes;
    let other_content = || {
        let hash = file.sha256.as_ref().zip(sha256(found).ok());
        hash.is_some_and(|(then, now)| *then != now)
    };
    other_length || other_content()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lost(path: &str) -> SessionFile {
        SessionFile { absolute: path.into(), ..SessionFile::default() }
    }

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, name).unwrap();
        }
        folder
    }

    fn found(lost: &[SessionFile], folder: &Path, place: &str) -> Vec<(usize, String)> {
        let found = find(lost, &folder.join(place), &[]).into_iter();
        let inside = |path: PathBuf| path.strip_prefix(folder).unwrap().to_str().unwrap().into();
        found.map(|(of, path)| (of, inside(path))).collect()
    }

    #[test]
    fn one_folder_or_one_file_finds_all_of_them() {
        let all = ["day1/a.csv", "day1/b.csv", "day2/c.csv"];
        let folder = folder(&["new/day1/a.csv", "new/day1/b.csv", "new/day2/c.csv"]);
        let lost: Vec<_> = all.map(|name| lost(&format!("/old/{name}"))).into();
        let expected: Vec<_> =
            all.iter().enumerate().map(|(of, name)| (of, format!("new/{name}"))).collect();
        for place in ["new", "new/day1", "new/day1/b.csv", "new/day2/c.csv"] {
            assert_eq!(found(&lost, folder.path(), place), expected, "{place}");
        }
        assert!(found(&lost, folder.path(), "gone").is_empty());
        let others = [folder.path().join("new/day1/a.csv")];
        let left = find(&lost, &folder.path().join("new"), &others);
        assert_eq!(left.len(), 2, "the file that is already open is excluded");
    }

    #[test]
    fn files_of_one_name_are_distinguished_by_folder_or_content() {
        let folder = folder(&["run.csv", "day1/run.csv", "day2/run.csv", "flat/run.csv"]);
        let mut both = ["/old/day1/run.csv", "/old/day2/run.csv"].map(lost);
        let expected = [0, 1].map(|of| (of, format!("day{}/run.csv", of + 1)));
        assert_eq!(found(&both, folder.path(), ""), expected);
        assert_eq!(found(&both, folder.path(), "day2"), expected);
        assert!(found(&both, folder.path(), "flat").is_empty());
        // The hash decides where folders do not, and has precedence over them.
        both[1].sha256 = sha256(&folder.path().join("flat/run.csv")).ok();
        let by_hash = [(1, "flat/run.csv".to_owned())];
        assert_eq!(found(&both, folder.path(), "flat"), by_hash);
        both[0].sha256 = sha256(&folder.path().join("run.csv")).ok();
        assert!(found(&both, folder.path(), "").contains(&(0, "run.csv".to_owned())));
    }

    #[test]
    fn a_renamed_file_is_found_by_its_content_or_if_it_alone_is_missing() {
        let folder = folder(&["moved.csv", "b.csv"]);
        let mut two = ["/old/a.csv", "/old/b.csv"].map(lost);
        let own = |of| (of, "moved.csv".to_owned());
        assert_eq!(found(&two[..1], folder.path(), "moved.csv"), [own(0)]);
        let beside = (1, "b.csv".to_owned());
        let only = std::slice::from_ref(&beside);
        assert_eq!(found(&two, folder.path(), "moved.csv"), only);
        two[0].sha256 = sha256(&folder.path().join("moved.csv")).ok();
        let expected = [own(0), beside];
        assert_eq!(found(&two, folder.path(), "moved.csv"), expected);
    }
}
