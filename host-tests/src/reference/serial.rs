//! Any serial machine forward, as 4x4 matrices: a list of joints on two chains, or an arm by its table.
//!
//! Shares no formula with the library, and for its built-in machines no number either: they are written down again here,
//! from the specifications.

use super::five_axis::reference_forward;
use super::matrix::{Matrix, about, inverted, multiply, translation};
use hexstep::machines::five_axis::Definition;

/// Where the tool is: its tip [mm], its axis from the tip into the body, and its x axis where that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolAt {
    pub tip: [f64; 3],
    pub axis: [f64; 3],
    pub across: Option<[f64; 3]>,
}

/// A joint as it is written down, in bed coordinates at home.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SerialJoint {
    /// On the work's chain and not on the tool's.
    pub carries_work: bool,
    pub turns: bool,
    /// Any length.
    pub axis: [f64; 3],
    /// A point on the axis of a joint that turns [mm].
    pub point: [f64; 3],
}

/// Joints from the bed outwards, and where tool and work stand at home.
#[derive(Clone, Debug, PartialEq)]
pub struct Serial {
    pub joints: Vec<SerialJoint>,
    /// Tip [mm] and axis in the bed.
    pub tip: [f64; 3],
    pub axis: [f64; 3],
    /// Work frame in the bed.
    pub work: Matrix,
}

/// A machine forward.
#[derive(Clone, Debug)]
pub enum Forward {
    FiveAxis(Box<Definition<f64>>),
    Serial(Serial),
    /// Rows (a, alpha [deg], d) of the modified Denavit-Hartenberg table, the tool on the flange, the work in the base.
    Arm {
        rows: [[f64; 3]; 6],
        tool: Matrix,
        work: Matrix,
    },
}

impl Forward {
    /// The tool in the work frame at these joints [mm, rad].
    pub fn at(&self, q: &[f64; 6]) -> ToolAt {
        match self {
            Self::FiveAxis(machine) => {
                let (tip, axis) = reference_forward(machine, &[q[0], q[1], q[2], q[3], q[4]]);
                ToolAt {
                    tip,
                    axis,
                    across: None,
                }
            }
            Self::Serial(serial) => serial.at(q),
            Self::Arm { rows, tool, work } => {
                let mut base = inverted(work);
                for ([a, alpha, d], theta) in rows.iter().zip(q) {
                    // RotX(alpha) TransX(a) RotZ(theta) TransZ(d)
                    let bent = about([1.0, 0.0, 0.0], [0.0; 3], alpha.to_radians());
                    let turned = about([0.0, 0.0, 1.0], [0.0; 3], *theta);
                    for next in [
                        bent,
                        translation([*a, 0.0, 0.0]),
                        turned,
                        translation([0.0, 0.0, *d]),
                    ] {
                        base = multiply(&base, &next);
                    }
                }
                let at = multiply(&base, tool);
                ToolAt {
                    tip: column(&at, 3),
                    // The tool's z points out of the flange, its axis from the tip into the body.
                    axis: column(&at, 2).map(|x| -x),
                    across: Some(column(&at, 0)),
                }
            }
        }
    }
}

impl Serial {
    /// The tool in the work frame at these joints [mm, rad], as many as there are.
    pub fn at(&self, q: &[f64]) -> ToolAt {
        let (mut tool, mut work) = (translation([0.0; 3]), translation([0.0; 3]));
        for (joint, q) in self.joints.iter().zip(q) {
            let moved = if joint.turns {
                about(joint.axis, joint.point, *q)
            } else {
                let length = joint.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
                translation(joint.axis.map(|x| x / length * q))
            };
            let chain = if joint.carries_work {
                &mut work
            } else {
                &mut tool
            };
            *chain = multiply(chain, &moved);
        }
        let seen = multiply(&inverted(&multiply(&work, &self.work)), &tool);
        let length = self.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apply = |x: [f64; 3], w: f64| {
            std::array::from_fn(|i| (0..3).map(|j| seen[i][j] * x[j]).sum::<f64>() + seen[i][3] * w)
        };
        ToolAt {
            tip: apply(self.tip, 1.0),
            axis: apply(self.axis.map(|x| x / length), 0.0),
            across: None,
        }
    }
}

/// The tools of two machines that share the bed, both in the work frame of the first, whose work chains rest.
pub fn tools_at([mill, support]: [&Serial; 2], q1: &[f64], q2: &[f64]) -> [ToolAt; 2] {
    let seen = multiply(&inverted(&mill.work), &support.work);
    let through = |x: [f64; 3], w: f64| {
        std::array::from_fn(|i| (0..3).map(|j| seen[i][j] * x[j]).sum::<f64>() + seen[i][3] * w)
    };
    let own = support.at(q2);
    let support = ToolAt {
        tip: through(own.tip, 1.0),
        axis: through(own.axis, 0.0),
        across: None,
    };
    [mill.at(q1), support]
}

fn column(m: &Matrix, j: usize) -> [f64; 3] {
    [m[0][j], m[1][j], m[2][j]]
}

/// The sides of the two reference machines of the mirror milling specification, section 8: `m4` and `m5`, mill (1) and
/// support (2).
pub fn two_sided(name: &str) -> Option<Serial> {
    let (axes, mill) = match name {
        "m4-mill" => (4, true),
        "m4-support" => (4, false),
        "m5-mill" => (5, true),
        "m5-support" => (5, false),
        _ => return None,
    };
    let sign = if mill { 1.0 } else { -1.0 };
    let slide = |axis| SerialJoint {
        carries_work: false,
        turns: false,
        axis,
        point: [0.0; 3],
    };
    let turn = |axis, z| SerialJoint {
        turns: true,
        point: [0.0, 0.0, z],
        ..slide(axis)
    };
    let mut joints = vec![
        slide([sign, 0.0, 0.0]),
        slide([0.0, 1.0, 0.0]),
        slide([0.0, 0.0, sign]),
    ];
    match (axes, mill) {
        (4, true) => joints.push(turn([0.0, 1.0, 0.0], 450.0)),
        (4, false) => joints.push(turn([0.0, 1.0, 0.0], -430.0)),
        (_, true) => {
            joints.push(turn([0.0, 1.0, 0.0], 510.0));
            joints.push(turn([1.0, 0.0, 0.0], 450.0));
        }
        (_, false) => {
            joints.push(turn([0.0, 1.0, 0.0], -490.0));
            joints.push(turn([1.0, 0.0, 0.0], -430.0));
        }
    }
    Some(Serial {
        joints,
        tip: [0.0, 0.0, 50.0 * sign],
        axis: [0.0, 0.0, sign],
        work: [
            [sign, 0.0, 0.0, 600.0],
            [0.0, 1.0, 0.0, 450.0],
            [0.0, 0.0, sign, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ],
    })
}

/// The ER3B of the surface grinding specification, section 9.
pub const ER3B: [[f64; 3]; 6] = [
    [0.0, 0.0, 320.0],
    [50.0, -90.0, 0.0],
    [270.0, 0.0, 0.0],
    [70.0, -90.0, 299.0],
    [0.0, 90.0, 0.0],
    [0.0, -90.0, 78.5],
];
