//! The colours of Calc., Conv., Comp. and Factory on a light ground, apart for colour-blind eyes too (Okabe and Ito 2008).

/// Calc.: red, green, blue.
pub const CALCULATED: [u8; 3] = [60, 60, 60];
/// Conv.
pub const CONVENTIONAL: [u8; 3] = [213, 94, 0];
/// Comp.
pub const COMPENSATED: [u8; 3] = [0, 114, 178];
/// Factory.
pub const FACTORY: [u8; 3] = [160, 70, 120];
