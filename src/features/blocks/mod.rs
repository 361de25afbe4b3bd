//! All feature blocks except the look-back, one file each.

mod auxiliary;
mod creep;
mod fixed_lag;
mod play;
mod polynomial;

use crate::features::block::Block;

pub use auxiliary::Auxiliary;
pub use creep::Creep;
pub use fixed_lag::FixedLag;
pub use play::Play;
pub use polynomial::Polynomial;

/// All feature blocks except the look-back, in the order of their columns: past gauges, monomials, auxiliary channels.
pub const BLOCKS: &[&dyn Block] = &[&FixedLag, &Creep, &Play, &Polynomial, &Auxiliary];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::block::Appends;

    /// All columns of past gauges must be neighbours, because they are standardised as one range. Keys must be unique.
    #[test]
    fn histories_come_first_and_no_two_blocks_share_a_name() {
        let is_history = |block: &&dyn Block| matches!(block.appends(), Appends::Past(_));
        assert!(
            BLOCKS.iter().skip_while(|block| is_history(block)).all(|block| !is_history(block))
        );
        for (at, block) in BLOCKS.iter().enumerate() {
            let names = |block: &dyn Block| {
                let setting = block.setting();
                [block.name(), setting.key, setting.option, setting.label]
            };
            for other in &BLOCKS[..at] {
                let (these, others) = (names(*block), names(*other));
                assert!(these.iter().zip(others).all(|(these, other)| *these != other));
            }
        }
    }
}
