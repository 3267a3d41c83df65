//! A two-sided machine of four axes a side: `$MIRROR`, on motors X1 Y1 Z1 B1 X2 Y2 Z2 B2.
//!
//! | line | what it does |
//! |---|---|
//! | `$MIRROR=D1.5,V5` | the wall [mm], the feed of the support along the face [mm/s], `O`: how far both tools are drawn back |
//! | `$MIRROR=ON,1.5`, `=OFF` | the wall, and points follow; there are no more |
//! | `$MIRROR=GAUGE,1.44,1.45,...` | gauge readings of the walls of the last run: from three on, the next run is corrected |
//! | `$MIRROR=BIAS`, `=BIAS,0` | shows the correction; forgets it, as another wall does |
//! | `$KIN.B1=x,y,z,px,py,pz`, `B2` | turning axes: direction and a point [mm] |
//! | `$KIN.TIPS=z1,z2`, `$KIN.WORK=x,y,z` | height of the tips at home, origin of both work frames at home [mm] |
//!
//! Travel is that of `$1040` and `$1050`. No axis is commanded if either side fails.

use super::correction::Correction;
use super::fed::{Begun, Fed, Machine, Told};
use super::given::{Given, MOST, Numbers, Parameter, parameter, vector};
use super::{Order, Standing, say};
use crate::cycles::mirror_milling::{FaceError, FacePoint, PanelRows};
use crate::error::Error;
use crate::geometry::Vector;
use crate::joints::Joints;
use crate::kinematics::chain::ChainError;
use crate::kinematics::follow::Tolerance;
use crate::machines::two_sided::{AtWall, FourAxes, Pair, PairError, PairGuide, SideError};
use crate::math::Real;
use crate::path::Scale;
use crate::path::points::{PointPath, Shop, left_for_corners};
use crate::program::list::{Word, reading, word};
use core::fmt::Write;

/// Words of `$MIRROR`.
pub const MIRROR: [Word; 3] = [
    word('D', "wall", 1.5),
    word('V', "feed", 5.0),
    word('O', "clear", 10.0),
];

const KIN: [Parameter; 4] = [
    parameter("B1", 0, 6),
    parameter("B2", 6, 6),
    parameter("TIPS", 12, 2),
    parameter("WORK", 14, 3),
];

/// Share of the tolerance that the chords of the joints may use.
const CHORDS: f32 = 0.85;
/// How far the tools may lean beside what the machine leaves anyway [deg].
const LEAN: f32 = 0.05;
/// A pair with its wall, fed with points.
pub type PairProcesses = Fed<Pair8, 8>;

/// A pair with its wall.
pub struct Pair8 {
    numbers: Numbers<17>,
    words: Given<{ MIRROR.len() }>,
    correction: Correction,
}

impl Default for Pair8 {
    /// M4.
    fn default() -> Self {
        Self {
            numbers: Numbers {
                table: &KIN,
                values: [
                    0.0, 1.0, 0.0, 0.0, 0.0, 450.0, // B1
                    0.0, 1.0, 0.0, 0.0, 0.0, -430.0, // B2
                    50.0, -50.0, // tips
                    600.0, 450.0, 0.0, // work
                ],
            },
            words: Given::new(&MIRROR),
            correction: Correction::default(),
        }
    }
}

fn dimensions(values: &[f32; 17], travel: [[f32; 2]; 8]) -> FourAxes<f32> {
    let [
        x1,
        y1,
        z1,
        u1,
        v1,
        w1,
        x2,
        y2,
        z2,
        u2,
        v2,
        w2,
        t1,
        t2,
        x,
        y,
        z,
    ] = *values;
    let at = Vector::new;
    FourAxes {
        axes: [
            (at(x1, y1, z1), at(u1, v1, w1)),
            (at(x2, y2, z2), at(u2, v2, w2)),
        ],
        tips: [t1, t2],
        origin: at(x, y, z),
        travel,
    }
}

fn pair_of(
    values: &[f32; 17],
    travel: [[f32; 2]; 8],
    out: &mut dyn Write,
) -> Result<Pair<4, 4, f32>, Error> {
    let chains = dimensions(values, travel).chains().map_err(|error| {
        let (name, expected) = match error {
            ChainError::NonFinite => ("NonFinite", "finite numbers"),
            ChainError::BadAxis => ("BadAxis", "a direction longer than 1e-6"),
            _ => ("BadLimit", "a travel whose ends are in order"),
        };
        say(out, format_args!("{name}: expected {expected}"));
        Error::ValueRange
    })?;
    let [mill, support] = chains;
    Pair::new(mill, support).map_err(|error| {
        say(out, format_args!("{}: {}", error.name(), error.remedy()));
        Error::ValueRange
    })
}

fn check(values: &[f32; MIRROR.len()], out: &mut dyn Write) -> Result<(), Error> {
    let [wall, feed, clear] = *values;
    let refusal = if !(wall > 0.0 && wall.is_finite()) {
        ("BadWall wall", "a finite thickness above 0 mm")
    } else if !(feed > 0.0 && feed.is_finite()) {
        ("BadLimit feed", "a finite speed above 0 mm/s")
    } else if !(0.0..=1000.0).contains(&clear) {
        ("BadLimit clear", "0 to 1000 mm")
    } else {
        return Ok(());
    };
    say(out, format_args!("{}: expected {}", refusal.0, refusal.1));
    Err(Error::ValueRange)
}

impl Pair8 {
    fn mirror(
        &mut self,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        if value == Some("BIAS") {
            self.correction.show(out);
            return Ok(Order::Done);
        }
        let (name, rest) = value
            .and_then(|value| value.split_once(','))
            .unwrap_or_default();
        if !matches!((name, rest), ("ON" | "GAUGE", _) | ("BIAS", "0")) {
            return self.obey_words(value, is_idle, out);
        }
        if !is_idle {
            return Err(Error::NotIdle);
        }
        match name {
            "ON" => self.on(rest, out),
            "GAUGE" => {
                let [wall, ..] = self.words.values;
                self.correction.gauge(wall, rest, out)?;
                Ok(Order::Done)
            }
            _ => {
                self.correction = Correction::default();
                Ok(Order::Done)
            }
        }
    }

    /// A new wall makes what was learnt of the one before void.
    fn obey_words(
        &mut self,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        let [before, ..] = self.words.values;
        let order = self.words.obey("MIRROR", value, is_idle, out, check)?;
        let [wall, ..] = self.words.values;
        if wall != before {
            self.correction = Correction::default();
        }
        Ok(order)
    }

    fn on(&mut self, wall: &str, out: &mut dyn Write) -> Result<Order, Error> {
        let mut changed = self.words.values;
        let [before, ..] = changed;
        let wall = reading(wall).ok_or(Error::BadNumber)?;
        changed[0] = wall;
        check(&changed, out)?;
        self.words.values = changed;
        if wall != before {
            self.correction = Correction::default();
        }
        Ok(Order::Run { sim: false })
    }

    fn kin(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        match (name, value) {
            ("KIN", None) => {
                let _ = out.write_str("[KIN:MIRROR");
                self.numbers.write(out);
                let _ = out.write_str("]\r\n");
            }
            ("KIN", Some("MIRROR")) => {}
            ("KIN", Some(_)) => return Err(Error::Unavailable),
            (_, Some(value)) if is_idle => {
                let name = name.strip_prefix("KIN.").ok_or(Error::UnknownCommand)?;
                let changed = self.numbers.with(name, value)?;
                pair_of(&changed, [[-f32::INFINITY, f32::INFINITY]; 8], out)?;
                self.numbers.values = changed;
            }
            (_, Some(_)) => return Err(Error::NotIdle),
            _ => return Err(Error::UnknownCommand),
        }
        Ok(Order::Done)
    }

    /// The pair as it is set, with this travel.
    fn pair_in(&self, scale: &Scale<8>, out: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        let (lower, upper) = (scale.joints(&scale.lower), scale.joints(&scale.upper));
        let travel = core::array::from_fn(|i| [lower[i], upper[i]]);
        pair_of(&self.numbers.values, travel, out)
    }
}

impl Machine<8> for Pair8 {
    type Work = PanelRows<f32>;
    type Tool = PairGuide<f32>;

    fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        match name {
            "MIRROR" => self.mirror(value, is_idle, out),
            "PRECESS" | "SURF" => Err(Error::Unavailable),
            _ => self.kin(name, value, is_idle, out),
        }
    }

    fn begin(
        &mut self,
        standing: &Standing<8>,
        sim: bool,
        out: &mut dyn Write,
    ) -> Result<Begun<PanelRows<f32>, PairGuide<f32>, 8>, Error> {
        check(&self.words.values, out)?;
        let [wall, feed, clear] = self.words.values;
        let tool = PairGuide {
            machine: AtWall {
                pair: self.pair_in(&standing.scale, out)?,
                wall: wall + self.correction.of_next(),
            },
            speeds: Some(Joints(standing.speeds)),
        };
        let shop = Shop {
            tool,
            scale: standing.scale,
            tolerance: Tolerance {
                tip: CHORDS * standing.tolerance,
                axis: CHORDS * LEAN.to_radians(),
                subdivide: true,
            },
            is_chosen: true,
            clear,
            plunge: feed,
        };
        let rows = PanelRows::new(feed);
        let near = standing.scale.joints(&standing.at);
        if !sim {
            self.correction.begin();
        }
        let [_, _, _, _, _, b1, _, _, _, _, _, b2, t1, t2, ..] = self.numbers.values;
        // A turning axis carries its tip on the arm between them.
        let least = standing.tolerance / LEAN.to_radians();
        let levers =
            [(b1, t1), (b2, t2)].map(|(axis, tip)| Real::max(Real::abs(axis - tip), least));
        let weight = core::array::from_fn(|i| {
            let lever = match i {
                3 => levers[0],
                7 => levers[1],
                _ => 1.0,
            };
            lever / standing.scale.steps_per_unit[i]
        });
        // Each side has joints that slide and one that turns, and their errors meet in the wall.
        let contour = left_for_corners(standing.tolerance, CHORDS, 4);
        Ok(Begun {
            path: PointPath::new(shop, rows, near),
            weight,
            contour,
        })
    }

    fn point(numbers: &[f32; MOST], count: usize, begins: bool) -> Result<FacePoint<f32>, Error> {
        if count != 6 {
            return Err(Error::BadNumber);
        }
        Ok(FacePoint {
            p: vector(numbers, 0),
            n: vector(numbers, 3),
            begins,
        })
    }

    fn pair(&self, scale: &Scale<8>, out: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        self.pair_in(scale, out)
    }
}

impl Told for FaceError {
    fn name(&self) -> &'static str {
        match self {
            Self::NonFinite => "NonFinite",
            Self::BadNormal => "BadNormal",
        }
    }

    fn remedy(&self) -> &'static str {
        match self {
            Self::NonFinite => "every number must be finite",
            Self::BadNormal => "a normal must be longer than 1e-6",
        }
    }
}

impl Told for PairError<4, 4, f32> {
    fn name(&self) -> &'static str {
        self.name()
    }

    fn remedy(&self) -> &'static str {
        self.remedy()
    }

    /// Counted over both sides.
    fn joint(&self) -> Option<usize> {
        match self {
            Self::Mill(SideError::OutOfTravel { joint }) => Some(*joint),
            Self::Support(SideError::OutOfTravel { joint }) => Some(4 + joint),
            _ => None,
        }
    }
}
