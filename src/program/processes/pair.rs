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
use super::given::{Given, Numbers, Parameter, PointLine, Running, Told, parameter, vector};
use super::{Order, Processes, Progress, Standing, say};
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
use crate::planner::PathSetting;
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
type Path = Running<PanelRows<f32>, PairGuide<f32>, 8>;

/// A pair with its wall.
pub struct PairProcesses {
    numbers: Numbers<17>,
    words: Given<{ MIRROR.len() }>,
    correction: Correction,
    sim: bool,
    begins: bool,
    /// A point that came while the blocks of the one before were still on their way.
    queued: Option<PointLine>,
    path: Option<Path>,
}

impl Default for PairProcesses {
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
            sim: false,
            begins: false,
            queued: None,
            path: None,
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

impl PairProcesses {
    fn mirror(
        &mut self,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        match value {
            Some("OFF") => return self.point("END", out),
            Some("BIAS") => {
                self.correction.show(out);
                return Ok(Order::Done);
            }
            _ => {}
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

    fn point(&mut self, text: &str, out: &mut dyn Write) -> Result<Order, Error> {
        let line = PointLine::read(text)?;
        match &self.path {
            None => Err(Error::NotIdle),
            Some(path) if path.path.is_drained() || line == PointLine::Row => self.put(line, out),
            Some(_) => {
                self.queued = Some(line);
                Ok(Order::Point)
            }
        }
    }

    fn put(&mut self, line: PointLine, out: &mut dyn Write) -> Result<Order, Error> {
        let path = self.path.as_mut().ok_or(Error::NotIdle)?;
        match line {
            PointLine::Row => {
                self.begins = true;
                Ok(Order::Done)
            }
            PointLine::End => path.take(None, out),
            PointLine::Numbers(numbers, 6) => {
                let point = FacePoint {
                    p: vector(&numbers, 0),
                    n: vector(&numbers, 3),
                    begins: core::mem::take(&mut self.begins),
                };
                path.take(Some(&point), out)
            }
            PointLine::Numbers(..) => Err(Error::BadNumber),
        }
    }

    /// The pair as it is set, with this travel.
    fn pair_in(&self, scale: &Scale<8>, out: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        let (lower, upper) = (scale.joints(&scale.lower), scale.joints(&scale.upper));
        let travel = core::array::from_fn(|i| [lower[i], upper[i]]);
        pair_of(&self.numbers.values, travel, out)
    }

    fn start_on(
        &mut self,
        standing: &Standing<8>,
        out: &mut dyn Write,
    ) -> Result<([f32; 8], f32), Error> {
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
        if !self.sim {
            self.correction.begin();
        }
        self.begins = false;
        self.queued = None;
        self.path = Some(Path::new(PointPath::new(shop, rows, near), self.sim));
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
        Ok((weight, left_for_corners(standing.tolerance, CHORDS, 4)))
    }
}

impl<const N: usize> Processes<N> for PairProcesses {
    fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        let order = match name {
            "MIRROR" => self.mirror(value, is_idle, out)?,
            "POINT" => return self.point(value.ok_or(Error::UnknownCommand)?, out),
            "PRECESS" | "SURF" => return Err(Error::Unavailable),
            _ => return self.kin(name, value, is_idle, out),
        };
        if let Order::Run { sim } = order {
            self.sim = sim;
        }
        Ok(order)
    }

    fn start(
        &mut self,
        standing: &Standing<N>,
        out: &mut dyn Write,
    ) -> Result<PathSetting<N>, Error> {
        let (Some(scale), Some(at), Some(speeds)) = (
            standing.scale.first(),
            standing.at.first_chunk::<8>().copied(),
            standing.speeds.first_chunk::<8>().copied(),
        ) else {
            return Err(Error::Unavailable);
        };
        let eight = Standing {
            scale,
            at,
            speeds,
            tolerance: standing.tolerance,
        };
        let (weight, contour) = self.start_on(&eight, out)?;
        let all = core::array::from_fn(|i| weight.get(i).copied().unwrap_or(1.0));
        PathSetting::new(all, contour).map_err(|_| {
            self.path = None;
            say(
                out,
                format_args!("BadLimit: expected a tolerance above 0 mm, see $1003"),
            );
            Error::ValueRange
        })
    }

    fn next(&mut self, out: &mut dyn Write) -> Progress<N> {
        let Some(path) = &mut self.path else {
            return Progress::Over;
        };
        match (path.next(out), self.queued) {
            (Progress::Waits, Some(line)) => {
                self.queued = None;
                match self.put(line, out) {
                    Ok(_) => Progress::Busy,
                    Err(error) => Progress::Refused(error),
                }
            }
            (progress, _) => progress.on_all(),
        }
    }

    fn owes_answer(&self) -> bool {
        self.queued.is_some() || self.path.as_ref().is_some_and(|path| path.path.is_trying())
    }

    fn stop(&mut self) {
        self.path = None;
        self.queued = None;
    }

    fn pair(&self, scale: &Scale<N>, out: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        let eight = scale.first().ok_or(Error::Unavailable)?;
        self.pair_in(&eight, out)
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
