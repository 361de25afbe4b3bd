//! Which models a search tries: they follow from the list of blocks.

use crate::calibration::{Learner, Regressor};
use crate::features::{Appends, Auxiliary, BLOCKS, Block, FixedLag};

/// A way to calibrate, its numbers still open: they are chosen from the training recordings.
#[derive(Clone, Debug)]
pub(super) struct Recipe {
    /// Name in tables.
    pub name: String,
    /// Whether there is a look-back.
    pub look_back: bool,
    /// Other blocks.
    pub blocks: Vec<&'static dyn Block>,
    /// Degree of the polynomial, where the blocks have one.
    pub degree: f64,
    /// Which values its blocks of times have.
    pub times: Times,
    /// How the load is made of the features.
    pub regressor: Regressor,
    /// How many times longer than others a network is trained, or how many times more landmarks a kernel has.
    pub times_longer: usize,
}

/// Which values a block of times has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Times {
    /// The few that a linear fit needs, by cross-validation.
    Chosen,
    /// Some over all that the recordings can show.
    Spread,
    /// Every sample of the nearest past, as in a filter of finite response.
    EverySample,
}

/// What each learner is called.
const LEARNERS: [(Regressor, &str); 4] = [
    (Regressor::HybridKernel, "Linear + kernel"),
    (Regressor::HybridNetwork, "Linear + network"),
    (Regressor::Kernel, "Kernel"),
    (Regressor::Network, "Network"),
];

impl Recipe {
    /// Returns a linear model.
    fn linear(look_back: bool, blocks: &[&'static dyn Block], degree: f64) -> Self {
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
            blocks: blocks.to_vec(),
            degree,
            times: Times::Chosen,
            regressor: Regressor::Linear,
            times_longer: 1,
        }
    }

    /// Returns a model that learns.
    fn learned(
        (regressor, name): (Regressor, &str),
        blocks: &[&'static dyn Block],
        times: Times,
    ) -> Self {
        let features = Self::linear(false, blocks, 0.0);
        let name = match blocks {
            [] => name.to_owned(),
            _ => format!("{name} on {}", features.name.to_lowercase()),
        };
        Self { name, times, regressor, ..features }
    }

    /// Returns the same model with lags of every sample.
    fn of_every_sample(self) -> Self {
        Self { name: format!("{} of every sample", self.name), times: Times::EverySample, ..self }
    }

    /// Returns the same network, trained longer, or the same kernel with more landmarks.
    pub fn longer(&self) -> Self {
        let (how, times_longer) = match self.regressor.learner() {
            Some(Learner::Kernel) => ("more landmarks", 3),
            _ => ("trained longer", 4),
        };
        Self { name: format!("{}, {how}", self.name), times_longer, ..self.clone() }
    }
}

/// The first letter alone stays as it is.
fn sentence(words: &str) -> String {
    let (first, rest) = words.split_at(words.len().min(1));
    format!("{first}{}", rest.to_lowercase())
}

/// Returns the linear models that are tried, cheap ones first; the first is the conventional calibration.
pub(super) fn linear(has_auxiliary: bool) -> Vec<Recipe> {
    let pasts = pasts();
    let polynomials: Vec<&'static dyn Block> = BLOCKS
        .iter()
        .copied()
        .filter(|block| matches!(block.appends(), Appends::Monomials(_)))
        .collect();
    let with = |own: &[&'static dyn Block]| [own, &polynomials].concat();
    let mut recipes = vec![Recipe::linear(false, &[], 0.0)];
    if has_auxiliary {
        let name = "Auxiliary channels".to_owned();
        recipes.push(Recipe { name, ..Recipe::linear(false, &[&Auxiliary], 0.0) });
    }
    recipes.extend([2.0, 3.0].map(|degree| Recipe::linear(false, &polynomials, degree)));
    recipes.push(Recipe::linear(true, &[], 0.0));
    recipes.extend(pasts.iter().map(|block| Recipe::linear(false, &[*block], 0.0)));
    recipes.push(Recipe::linear(false, &[&FixedLag], 0.0).of_every_sample());
    recipes.push(Recipe::linear(true, &polynomials, 2.0));
    recipes.extend(pasts.iter().map(|block| Recipe::linear(false, &with(&[*block]), 2.0)));
    let pairs = || pairs(&pasts);
    recipes.extend(pairs().map(|pair| Recipe::linear(false, &pair, 0.0)));
    recipes.extend(pairs().map(|pair| Recipe::linear(false, &with(&pair), 2.0)));
    recipes.extend(pairs().map(|pair| Recipe::linear(false, &with(&pair), 3.0)));
    let name = "Everything".to_owned();
    recipes.push(Recipe { name, ..Recipe::linear(true, &with(&pasts), 2.0) });
    recipes
}

/// Returns the models that learn.
pub(super) fn learned() -> Vec<Recipe> {
    let pasts = pasts();
    let mut recipes = Vec::new();
    for learner in LEARNERS {
        recipes.push(Recipe::learned(learner, &[], Times::Chosen));
        let alone = |block: &&'static dyn Block| Recipe::learned(learner, &[*block], Times::Spread);
        recipes.extend(pasts.iter().map(alone));
        let both = |pair: Vec<_>| Recipe::learned(learner, &pair, Times::Chosen);
        recipes.extend(pairs(&pasts).map(both));
    }
    let filter = |learner| Recipe::learned(learner, &[&FixedLag], Times::EverySample);
    recipes.extend(LEARNERS[..2].iter().map(|learner| filter(*learner).of_every_sample()));
    recipes
}

/// The blocks that append gauges of the past.
fn pasts() -> Vec<&'static dyn Block> {
    let all = BLOCKS.iter().copied();
    all.filter(|block| matches!(block.appends(), Appends::Past(_))).collect()
}

fn pairs(blocks: &[&'static dyn Block]) -> impl Iterator<Item = Vec<&'static dyn Block>> {
    (0..blocks.len())
        .flat_map(move |second| (0..second).map(move |first| vec![blocks[first], blocks[second]]))
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
        for expected in ["Creep + play", "Linear + network on fixed lag", "Network on play"] {
            assert!(names.contains(&expected), "{names:?}");
        }
    }
}
