//! Fabrics by name.
//!
//! Where the numbers come from:
//!
//! - *Area density*: usual weights of the trade, as given with each.
//! - *Flexural rigidity*: the geometric mean of warp and weft, as the median of the fabrics of that weight
//!   (within 15 %) among the 618 that Feng, Huang, Xu and Wang measured (2022, "Learning-Based Bending
//!   Stiffness Parameter Estimation by a Drape Tester", data set); of canvas, which is the stiff one of its
//!   weight, the eighth decile. Of denim what Wang, O'Brien and Ramamoorthi measured (2011,
//!   "Data-Driven Elastic Models for Cloth", 11 oz black denim), as is its area density.
//! - *Thread stiffness*: 490 N/m, the load of Kawabata's tensile test, over an extension under it in the middle
//!   of what is usual for such cloth: 2 % of canvas, 3 % of silk and denim, 4 % of cotton, 6 % of wool
//!   (Kawabata and Niwa 1989, "Fabric Performance in Clothing and Clothing Manufacture", whose range for
//!   wool suiting is 4 to 8 %). Cloth is softer at first, as its yarns straighten: this is the secant.
//! - *Shear stiffness*: usual results of Kawabata's shear test: 0.3, 0.8, 0.6, 2 and 3 gf/cm a degree for silk,
//!   cotton, wool, denim and canvas; one is 56.2 N/m.
//! - *Bending friction*: 23/m times the rigidity, an assumption: 2HB is taken as 0.46 times B a centimetre, of the size that
//!   Kawabata's test of bending gives for wovens (Kawabata 1980, "The Standardization and Analysis of Hand Evaluation"). No
//!   table was at hand for each of these fabrics. Of rubber, what a loss factor of 0.05 makes at a radius of 5 cm.
//! - *Rubber* is worked out: a sheet of 1 mm, 930 kg/m3, Young's modulus `E = 1.5 MPa`, Poisson's ratio 1/2. A
//!   square lattice is isotropic where threads have `3/4 E h` and shear springs half of it; its
//!   rigidity is `E h^3 / (12 (1 - 1/4))`.
//!
//! Friction and the strain limit are a modeller's choice: 10 % is more than any of these cloths is
//! stretched in use, and five times its length what such rubber bears.

use crate::cloth::material::ClothMaterial;

impl ClothMaterial {
    /// Habotai silk, 60 g/m2: falls in many small folds.
    pub const SILK: Self = Self {
        area_density: 0.06,
        thread_stiffness: 16_000.0,
        shear_stiffness: 17.0,
        flexural_rigidity: 3.4e-6,
        bending_friction: 8e-5,
        friction: 0.3,
        ..Self::USUAL
    };

    /// Cotton shirting, 120 g/m2.
    pub const COTTON: Self = Self {
        area_density: 0.12,
        thread_stiffness: 12_000.0,
        shear_stiffness: 45.0,
        flexural_rigidity: 5.4e-6,
        bending_friction: 1.2e-4,
        ..Self::USUAL
    };

    /// Wool suiting, 250 g/m2: falls in wide, round folds.
    pub const WOOL: Self = Self {
        area_density: 0.25,
        thread_stiffness: 8000.0,
        shear_stiffness: 34.0,
        flexural_rigidity: 1.8e-5,
        bending_friction: 4.1e-4,
        friction: 0.6,
        ..Self::USUAL
    };

    /// Denim of 11 oz a square yard, 324 g/m2.
    pub const DENIM: Self = Self {
        area_density: 0.324,
        thread_stiffness: 16_000.0,
        shear_stiffness: 110.0,
        flexural_rigidity: 6e-5,
        bending_friction: 1.4e-3,
        friction: 0.6,
        ..Self::USUAL
    };

    /// Canvas of 10 oz a square yard, 340 g/m2, as of tents and sails: stands more than it falls.
    pub const CANVAS: Self = Self {
        area_density: 0.34,
        thread_stiffness: 25_000.0,
        shear_stiffness: 170.0,
        flexural_rigidity: 5e-5,
        bending_friction: 1.2e-3,
        friction: 0.6,
        ..Self::USUAL
    };

    /// A rubber sheet of 1 mm: stretches to several times its length.
    pub const RUBBER: Self = Self {
        area_density: 0.93,
        thread_stiffness: 1125.0,
        shear_stiffness: 562.5,
        flexural_rigidity: 1.67e-4,
        bending_friction: 1.7e-4,
        max_strain: 5.0,
        friction: 1.0,
        ..Self::USUAL
    };

    /// All of them, with their names.
    pub const FABRICS: [(&'static str, Self); 6] = [
        ("silk", Self::SILK),
        ("cotton", Self::COTTON),
        ("wool", Self::WOOL),
        ("denim", Self::DENIM),
        ("canvas", Self::CANVAS),
        ("rubber", Self::RUBBER),
    ];
}
