//! Candidates of a model search. A new feature block becomes a candidate as soon as the list of feature blocks has a line for
//! it.

use crate::{
    calibration::{Learner, Regressor},
    features::{Appends, Auxiliary, BLOCKS, Block, FixedLag},
};

/// Lists of candidates that a search can try.
#[derive(Clone, Copy, Debug, Default)]
pub enum Candidates {
    /// Every feature block alone and in pairs, with every regressor.
    #[default]
    All,
    /// Models of the paper of Koike et al. (2019): linear, network, kernel and both in two stages, without and with look-back.
    Paper,
}

/// Candidate model whose thresholds, play radii and times are not chosen yet.
#[derive(Clone, Debug)]
pub(super) struct Recipe {
    pub name: String,
    pub look_back: bool,
    pub blocks: Vec<&'static dyn Block>,
    /// Degree of the polynomial; zero without a polynomial.
    pub degree: f64,
    pub times: Times,
    pub regressor: Regressor,
    /// Factor on a network's epochs or a kernel's landmarks, for a longer training.
    pub times_longer: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Times {
    /// The times (s) that give the lowest cross-validation error of a linear fit.
    Chosen,
    /// Times spread evenly over the range that the recordings allow.
    Spread,
    /// Times of the latest samples, one time per sample, as in a filter with finite impulse response.
    EverySample,
    /// Times that double from one sample to the slowest time that the recordings allow.
    Doubling,
}

/// From the fastest to the slowest training, because a search may end early.
const LEARNERS: [Regressor; 4] =
    [Regressor::HybridNetwork, Regressor::Network, Regressor::HybridKernel, Regressor::Kernel];

impl Recipe {
    /// Returns a linear candidate; a `degree` above zero adds a polynomial of this degree.
    fn linear(look_back: bool, blocks: &[&'static dyn Block], degree: f64) -> Self {
        let polynomials = BLOCKS
            .iter()
            .copied()
            .filter(|block| degree > 0.0 && matches!(block.appends(), Appends::Monomials(_)));
        let blocks: Vec<&'static dyn Block> = blocks.iter().copied().chain(polynomials).collect();
        let named = blocks.iter().map(|block| match block.appends() {
            Appends::Monomials(_) => format!("{} of degree {degree}", block.name()),
            _ => block.name().to_owned(),
        });
        let names: Vec<String> =
            look_back.then(|| "Look-back".to_owned()).into_iter().chain(named).collect();
        Self {
            name: match &names[..] {
                [] => "Conventional".to_owned(),
                names => sentence(&names.join(" + ")),
            },
            look_back,
            blocks,
            degree,
            times: Times::Chosen,
            regressor: Regressor::Linear,
            times_longer: 1,
        }
    }

    fn learned(regressor: Regressor, blocks: &[&'static dyn Block], times: Times) -> Self {
        let features = Self::linear(false, blocks, 0.0);
        let name = match blocks {
            [] => regressor.label().to_owned(),
            _ => format!("{} on {}", regressor.label(), features.name.to_lowercase()),
        };
        Self { name, times, regressor, ..features }
    }

    fn of_every_sample(self) -> Self {
        Self { name: format!("{} of every sample", self.name), times: Times::EverySample, ..self }
    }

    pub fn longer(&self) -> Self {
        let (how, times_longer) = match self.regressor.learner() {
            Some(Learner::Kernel) => ("more landmarks", 3),
            _ => ("trained longer", 4),
        };
        Self { name: format!("{}, {how}", self.name), times_longer, ..self.clone() }
    }
}

/// Returns the words in lower case, except for the first letter of the sentence.
fn sentence(words: &str) -> String {
    let (first, rest) = words.split_at(1);
    format!("{first}{}", rest.to_lowercase())
}

/// Returns the linear candidates: first the conventional calibration, then the others, from the fastest fit to
/// the slowest.
pub(super) fn linear(has_auxiliary: bool) -> Vec<Recipe> {
    let pasts = pasts();
    let (alone, pairs) = (alone(&pasts), pairs(&pasts));
    let each = |lists: &[Vec<&'static dyn Block>], degree: f64| -> Vec<Recipe> {
        lists.iter().map(|blocks| Recipe::linear(false, blocks, degree)).collect()
    };
    let mut recipes = vec![Recipe::linear(false, &[], 0.0)];
    if has_auxiliary {
        let name = "Auxiliary channels".to_owned();
        recipes.push(Recipe { name, ..Recipe::linear(false, &[&Auxiliary], 0.0) });
    }
    recipes.extend([2.0, 3.0].map(|degree| Recipe::linear(false, &[], degree)));
    recipes.push(Recipe::linear(true, &[], 0.0));
    recipes.extend(each(&alone, 0.0));
    recipes.push(Recipe::linear(false, &[&FixedLag], 0.0).of_every_sample());
    recipes.push(Recipe::linear(true, &[], 2.0));
    recipes.extend(each(&alone, 2.0));
    recipes.extend([0.0, 2.0, 3.0].into_iter().flat_map(|degree| each(&pairs, degree)));
    let name = "Everything".to_owned();
    recipes.push(Recipe { name, ..Recipe::linear(true, &pasts, 2.0) });
    recipes
}

/// Returns the models that the paper of Koike et al. (2019) compares, with the kernels that it cites. Load cases have no past,
/// so `is_static` leaves out the look-back.
pub(super) fn paper(is_static: bool) -> Vec<Recipe> {
    let mut recipes = vec![Recipe::linear(false, &[], 0.0), Recipe::linear(false, &[], 2.0)];
    recipes.extend((!is_static).then(|| Recipe::linear(true, &[], 0.0)));
    for learner in LEARNERS {
        let present = Recipe::learned(learner, &[], Times::Chosen);
        let name = format!("{} on look-back", present.name);
        let with_past = Recipe { name, look_back: true, ..present.clone() };
        recipes.push(present);
        recipes.extend((!is_static).then_some(with_past));
    }
    recipes
}

pub(super) fn learned() -> Vec<Recipe> {
    let pasts = pasts();
    let (alone, pairs) = (alone(&pasts), pairs(&pasts));
    let mut recipes = Vec::new();
    for learner in LEARNERS {
        recipes.push(Recipe::learned(learner, &[], Times::Chosen));
        recipes.extend(alone.iter().map(|blocks| Recipe::learned(learner, blocks, Times::Spread)));
        let several = pairs.iter().chain([&pasts]);
        recipes.extend(several.map(|blocks| Recipe::learned(learner, blocks, Times::Chosen)));
    }
    let filter = |learner| Recipe::learned(learner, &[&FixedLag], Times::EverySample);
    let hybrid = [Regressor::HybridNetwork, Regressor::HybridKernel];
    recipes.extend(hybrid.map(|learner| filter(learner).of_every_sample()));
    recipes
}

/// Returns the network that is always trained fully: a short training does not tell how good it becomes.
pub(super) fn always_trained() -> Recipe {
    let recipe = Recipe::learned(Regressor::HybridNetwork, &[&FixedLag], Times::Doubling);
    Recipe { name: format!("{} at doubling times", recipe.name), ..recipe }
}

/// Returns the feature blocks that append earlier gauge values.
fn pasts() -> Vec<&'static dyn Block> {
    let all = BLOCKS.iter().copied();
    all.filter(|block| matches!(block.appends(), Appends::Past(_))).collect()
}

fn alone(blocks: &[&'static dyn Block]) -> Vec<Vec<&'static dyn Block>> {
    blocks.iter().map(|block| vec![*block]).collect()
}

fn pairs(blocks: &[&'static dyn Block]) -> Vec<Vec<&'static dyn Block>> {
    let with_earlier =
        |at: usize| blocks[..at].iter().map(move |earlier| vec![*earlier, blocks[at]]);
    (0..blocks.len()).flat_map(with_earlier).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_is_tried_alone_in_pairs_and_by_every_learner() {
        let (linear, learned) = (linear(true), learned());
        assert_eq!(linear[0].name, "Conventional");
        let names: Vec<&str> =
            linear.iter().chain(&learned).map(|recipe| recipe.name.as_str()).collect();
        let mut distinct = names.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), names.len(), "{names:?}");
        for block in BLOCKS {
            let alone = linear.iter().find(|recipe| recipe.blocks == [*block] && !recipe.look_back);
            assert!(alone.is_some(), "{block:?}");
        }
        assert_eq!((paper(false).len(), paper(true).len()), (11, 6));
        assert!(paper(true).iter().all(|recipe| !recipe.look_back));
        for expected in ["Creep + play", "Linear + network on fixed lag", "Network on play"] {
            assert!(names.contains(&expected), "{names:?}");
        }
    }
}
