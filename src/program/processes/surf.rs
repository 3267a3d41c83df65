//! Words of `$SURF` -> checked rows of grinding.

use super::given::{Given, bad_choice, check_clear};
use super::say;
use crate::cycles::surface_grinding::{
    Depth, Field, Grinding, GrindingError, Job, Material, Model, Rows, Sense, Wheel,
};
use crate::error::Error;
use crate::program::list::{Word, whole, word};
use core::fmt::Write;

/// Words of `$SURF`: lengths in mm, feed in mm/s, force in N.
pub const SURF: [Word; 19] = [
    // Radii of the wheel; 0: flat
    word('R', "r_rim", 10.0),
    word('C', "r_crown", 50.0),
    // Half of its width; 0: not looked at
    word('W', "half_width", 0.0),
    word('E', "e1", 1_050_000.0),
    word('N', "nu1", 0.2),
    word('G', "e2", 206_000.0),
    word('M', "nu2", 0.3),
    word('F', "force", 30.0),
    // Preston's coefficient in 1e-12 / Pa
    word('K', "k", 5.0),
    word('S', "rpm", 2800.0),
    word('V', "feed", 20.0),
    // 0 neglects the feed beside the rim, 1 against it, 2 with it
    word('D', "sense", 0.0),
    word('H', "scallop", 0.04),
    word('Y', "margin", 0.02),
    // 0 envelope, 1 additive
    word('A', "model", 0.0),
    // Depth of every row; 0: the feed is constant
    word('P', "depth", 0.0),
    // Rows may go to and fro without the wheel being swung round
    word('Z', "zigzag", 0.0),
    // How far the wheel is lifted between rows, and how fast it comes down
    word('O', "clear", 10.0),
    word('Q', "plunge", 5.0),
];

fn grinding(
    values: &[f32; SURF.len()],
) -> Result<Rows<f32>, Result<GrindingError<f32>, &'static str>> {
    let get = |name| Given::get(values, &SURF, name);
    let choice = |name: &'static str, most| whole(get(name), name, most).map_err(|_| Err(name));
    let radius = |name| Some(get(name)).filter(|r| *r != 0.0);
    let job = Job {
        wheel: Wheel {
            rim: radius("r_rim"),
            crown: radius("r_crown"),
        },
        wheel_material: Material {
            modulus: get("e1"),
            poisson: get("nu1"),
        },
        part_material: Material {
            modulus: get("e2"),
            poisson: get("nu2"),
        },
        force: get("force"),
        k: get("k") * 1e-12,
        rpm: get("rpm"),
        feed: get("feed"),
        sense: match choice("sense", 2)? {
            0 => Sense::Neglected,
            1 => Sense::Against,
            _ => Sense::With,
        },
        scallop: get("scallop"),
        margin: get("margin"),
        model: match choice("model", 1)? {
            0 => Model::Envelope,
            _ => Model::Additive,
        },
        depth: match get("depth") {
            0.0 => Depth::ConstantFeed,
            depth => Depth::Constant(depth),
        },
    };
    let grinding = Grinding::new(&job).map_err(Ok)?;
    let half_width = get("half_width");
    if !(half_width >= 0.0 && half_width.is_finite()) {
        return Err(Ok(GrindingError::BadParameter(Field::HalfWidth)));
    }
    let zigzag = choice("zigzag", 1)? == 1;
    Ok(Rows::new(grinding, half_width, job.feed, zigzag))
}

/// The process, how far its wheel is lifted [mm], and how fast it comes down [mm/s].
pub(super) fn built(
    values: &[f32; SURF.len()],
    out: &mut dyn Write,
) -> Result<(Rows<f32>, [f32; 2]), Error> {
    let rows = grinding(values).map_err(|bad| match bad {
        Ok(error) => {
            let field = error.field().map_or("", |field| field.name());
            say(
                out,
                format_args!("{} {field}: {}", error.name(), error.remedy()),
            );
            Error::ValueRange
        }
        Err(name) => bad_choice(name, out),
    })?;
    let [clear, plunge] = ["clear", "plunge"].map(|name| Given::get(values, &SURF, name));
    check_clear(clear, plunge, out)?;
    Ok((rows, [clear, plunge]))
}
