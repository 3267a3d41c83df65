//! The pair M4, and a pair of one's own: its eight joints as a list, where its tips are and where the panel stands.

use super::super::model::{LENGTH, read_joint};
use super::super::reader::Table;
use super::super::{JobError, Places};
use super::{MOTORS, NAMES, SIDE};
use crate::reference::matrix::translation;
use crate::reference::serial::{Serial, two_sided};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::kinematics::chain::{Carries, Chain, Joint};
use hexstep::machines::two_sided as library;

/// Keys of `[machine]` that a pair of one's own has besides.
pub(super) const OWN: &[&str] = &["mill_tip", "support_tip", "work_origin"];

/// A pair written down twice: for the solver and for the reference.
pub(super) struct Written {
    pub chains: [Chain<SIDE, f64>; 2],
    pub forward: [Serial; 2],
    pub names: [String; MOTORS],
}

pub(super) fn built_in() -> Written {
    let forward = ["m4-mill", "m4-support"].map(|name| two_sided(name).expect("it is built in"));
    Written {
        chains: [library::m4_1(), library::m4_2()],
        forward,
        names: NAMES.map(String::from),
    }
}

/// `[[joint]]` eight times: the mill's, then the support's.
///
/// # Errors
/// `BadAxis`; `Contradictory` where a joint goes another way than that of M4, along which the controller trims.
pub(super) fn read(
    root: &Table<'_>,
    machine: &Table<'_>,
    places: &Places,
) -> Result<Written, JobError> {
    let tables = root.tables("joint")?;
    if tables.len() != MOTORS {
        let detail = format!(
            "expected the four joints of the mill and then the four of the support, found {}",
            tables.len()
        );
        return Err(places.refuse("joint", "WrongType", detail));
    }
    let Written {
        chains,
        forward: [mut mill, mut support],
        mut names,
    } = built_in();
    let wanted = mill.joints.iter().chain(&support.joints).cloned();
    let wanted: Vec<_> = wanted.collect();
    let mut list = Vec::with_capacity(MOTORS);
    for (index, (table, wanted)) in tables.iter().zip(&wanted).enumerate() {
        let read = read_joint(table, index, places)?;
        let length = read.serial.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        let axis = read.serial.axis.map(|x| x / length);
        let off = (0..3).map(|i| (axis[i] - wanted.axis[i]).abs());
        let goes_so = read.serial.turns == wanted.turns
            && !read.serial.carries_work
            && off.fold(0.0, f64::max) < 1e-6;
        if !goes_so {
            let detail = format!(
                "the controller trims along the joints of the pair M4: {} carries the tool and {} {:?}, with the numbers of your machine in point, mill_tip, support_tip and work_origin",
                NAMES[index],
                if wanted.turns {
                    "turns about"
                } else {
                    "slides along"
                },
                wanted.axis
            );
            return Err(places.refuse(&format!("joint[{index}]"), "Contradictory", detail));
        }
        if table.has("name") {
            names[index] = read.name.clone();
        }
        list.push(read);
    }
    let vector = |key: &str, default: [f64; 3]| match machine.has(key) {
        true => machine.numbers::<3>(key, LENGTH),
        false => Ok(default),
    };
    let tips = [
        vector("mill_tip", mill.tip)?,
        vector("support_tip", support.tip)?,
    ];
    let origin = vector("work_origin", [600.0, 450.0, 0.0])?;
    let frame = |rotation: Rotation<f64>, [x, y, z]: [f64; 3]| Pose {
        rotation,
        p: Vector::new(x, y, z),
    };
    let chain = |side: usize| {
        let preset = chains[side].series();
        let (tool, work) = (preset.tool_home.rotation, preset.work_home.rotation);
        let mut joints = [Joint::held(Carries::Tool); SIDE];
        for (slot, read) in joints.iter_mut().zip(&list[side * SIDE..]) {
            *slot = read.joint;
        }
        let homed = Chain::new(joints).with_homes(frame(tool, tips[side]), frame(work, origin));
        homed.map_err(|_| {
            let detail = "the machine cannot be computed with".into();
            places.refuse("machine.work_origin", "BadPose", detail)
        })
    };
    let made = [chain(0)?, chain(1)?];
    for (side, serial) in [&mut mill, &mut support].into_iter().enumerate() {
        let own = list.iter().skip(side * SIDE).take(SIDE);
        serial.joints = own.map(|read| read.serial).collect();
        serial.tip = tips[side];
        let shift = translation(origin);
        for (row, shifted) in serial.work.iter_mut().zip(shift) {
            row[3] = shifted[3];
        }
    }
    Ok(Written {
        chains: made,
        forward: [mill, support],
        names,
    })
}
