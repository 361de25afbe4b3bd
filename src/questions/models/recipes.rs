//! Candidates of a model search. They follow from the list of feature blocks, so a new block needs no line here.

use crate::calibration::{Learner, Regressor};
use crate::features::{Appends, Auxiliary, BLOCKS, Block, FixedLag};

/// Candidate whose thresholds, radii and times are still to be chosen from the training recordings.
#[derive(Clone, Debug)]
pub(super) struct Recipe {
    pub name: String,
    pub look_back: bool,
    pub blocks: Vec<&'static dyn Block>,
    /// Degree of the polynomial; zero without one.
    pub degree: f64,
    pub times: Times,
    pub regressor: Regressor,
    /// Factor by which a network's epochs or a kernel's landmarks are multiplied.
    pub times_longer: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Times {
    /// A few times with the lowest cross-validation error of a linear fit.
    Chosen,
    /// Times spread evenly over the range that the recordings allow.
    Spread,
    /// Times of the latest samples, one per sample, as in a filter with finite impulse response.
    EverySample,
}

const LEARNERS: [Regressor; 4] =
    [Regressor::HybridKernel, Regressor::HybridNetwork, Regressor::Kernel, Regressor::Network];

impl Recipe {
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

/// Returns the words in small letters after the first letter.
fn sentence(words: &str) -> String {
    let (first, rest) = words.split_at(1);
    format!("{first}{}", rest.to_lowercase())
}

/// Returns the linear candidates: first the conventional calibration, then from quick to slow.
pub(super) fn linear(has_auxiliary: bool) -> Vec<Recipe> {
    let pasts = blocks(|appends| matches!(appends, Appends::Past(_)));
    let polynomials = blocks(|appends| matches!(appends, Appends::Monomials(_)));
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

pub(super) fn learned() -> Vec<Recipe> {
    let pasts = blocks(|appends| matches!(appends, Appends::Past(_)));
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

fn blocks(is_meant: fn(Appends) -> bool) -> Vec<&'static dyn Block> {
    BLOCKS.iter().copied().filter(|block| is_meant(block.appends())).collect()
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
