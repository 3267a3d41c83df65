//! The classical machines and one slanted machine, by name.
//!
//! A turns about x, B about y, C about z; the tool stands along z at home. Two ordered pairs of each class are
//! missing because they are of no use: a C next to the tool turns about the tool, and a mixed machine with the same
//! letter twice has one axis too few. All pivots are 0 and all travel unlimited until the definition is changed.

use super::{Class, Definition};
use crate::geometry::{Rotation, Vector};
use crate::math::Real;

/// Every preset's name. `mixed_ba`: table B, head A.
pub const PRESETS: [&str; 13] = [
    "head_ab", "head_ba", "head_ca", "head_cb", "table_ab", "table_ba", "table_ac", "table_bc",
    "mixed_ba", "mixed_ca", "mixed_ab", "mixed_cb", "s45",
];

/// The machine of that name; `None` if there is none.
pub fn preset<R: Real>(name: &str) -> Option<Definition<R>> {
    let a = Vector::X;
    let b = Vector::Y;
    let c = Vector::Z;
    Some(match name {
        "head_ab" => classical(Class::Head, a, b),
        "head_ba" => classical(Class::Head, b, a),
        "head_ca" => classical(Class::Head, c, a),
        "head_cb" => classical(Class::Head, c, b),
        "table_ab" => classical(Class::Table, a, b),
        "table_ba" => classical(Class::Table, b, a),
        "table_ac" => classical(Class::Table, a, c),
        "table_bc" => classical(Class::Table, b, c),
        "mixed_ba" => classical(Class::Mixed, b, a),
        "mixed_ca" => classical(Class::Mixed, c, a),
        "mixed_ab" => classical(Class::Mixed, a, b),
        "mixed_cb" => classical(Class::Mixed, c, b),
        "s45" => slanted(),
        _ => return None,
    })
}

fn classical<R: Real>(class: Class, n1: Vector<R>, n2: Vector<R>) -> Definition<R> {
    Definition {
        class,
        n1,
        n2,
        q1: Vector::ZERO,
        q2: Vector::ZERO,
        v1: Vector::Z,
        t0: Vector::ZERO,
        w0: Vector::ZERO,
        rw: Rotation::IDENTITY,
        linear: [Vector::X, Vector::Y, Vector::Z],
        limits: [None; 5],
        weights: [R::ONE; 2],
        speeds: None,
    }
}

/// Table C without limit, head B about (0, 1, 1) at a height of 350 mm, +-180 deg: our stand-in for the slanted mixed
/// machine of the paper, whose axis vector is lost. Reachable tilts 0 to 90 deg.
fn slanted<R: Real>() -> Definition<R> {
    Definition {
        q2: Vector::new(R::ZERO, R::ZERO, R::of(350.0)),
        limits: [None, None, None, None, Some([-R::PI, R::PI])],
        ..classical(
            Class::Mixed,
            Vector::Z,
            Vector::new(R::ZERO, R::ONE, R::ONE),
        )
    }
}
