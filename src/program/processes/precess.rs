//! Words of `$PRECESS` -> a checked precession. Angles in degrees here and nowhere below.

use super::given::{Given, bad_choice, check_clear};
use super::say;
use crate::cycles::precession::{
    Drive, FarEnd, FeedAt, Parameters, Precession, PrecessionError, Reference,
};
use crate::error::Error;
use crate::geometry::Vector;
use crate::program::list::{Word, whole, word};
use core::fmt::Write;

/// Words of `$PRECESS`: angles in degrees, lengths in mm, times in s.
pub const PRECESS: [Word; 21] = [
    word('T', "theta", 20.0),
    word('R', "bonnet_radius", 40.0),
    word('H', "inward", 0.5),
    word('V', "feed", 5.0),
    // 0 at the contact, 1 at the ball's centre
    word('C', "feed_at", 0.0),
    // 0 time, 1 distance
    word('M', "drive", 0.0),
    word('W', "rate", 30.0),
    word('P', "pitch", 60.0),
    word('A', "alpha0", 0.0),
    // 0 carried along, 1 locked to the feed
    word('F', "reference", 0.0),
    // First reference direction; 0, 0, 0: that of the first move
    word('I', "ref_x", 0.0),
    word('J', "ref_y", 0.0),
    word('K', "ref_z", 0.0),
    word('L', "ell", 127.0),
    // 0 towards the spindle, 1 towards the surface
    word('N', "far_end", 0.0),
    word('E', "eps", 0.01),
    word('D', "dpsi", 5.0),
    word('X', "dt_max", 0.5),
    word('Q', "w_rot", 20.0),
    word('B', "dwell", 0.0),
    // How far the tool is drawn back before and behind the path
    word('O', "clear", 10.0),
];

fn precession(values: &[f32; PRECESS.len()]) -> Result<Parameters<f32>, &'static str> {
    let get = |name| Given::get(values, &PRECESS, name);
    let choice = |name: &'static str| whole(get(name), name, 1).map_err(|_| name);
    let reference = Vector::new(get("ref_x"), get("ref_y"), get("ref_z"));
    Ok(Parameters {
        theta: get("theta").to_radians(),
        bonnet_radius: get("bonnet_radius"),
        inward: get("inward"),
        feed: get("feed"),
        feed_at: match choice("feed_at")? {
            0 => FeedAt::Contact,
            _ => FeedAt::Centre,
        },
        drive: match choice("drive")? {
            0 => Drive::Time {
                rate: get("rate").to_radians(),
            },
            _ => Drive::Distance {
                pitch: get("pitch"),
            },
        },
        alpha0: get("alpha0").to_radians(),
        reference: match choice("reference")? {
            0 => Reference::Transport,
            _ => Reference::FeedLocked,
        },
        first_reference: (reference != Vector::ZERO).then_some(reference),
        ell: get("ell"),
        far_end: match choice("far_end")? {
            0 => FarEnd::Spindle,
            _ => FarEnd::Surface,
        },
        eps: get("eps"),
        dpsi: get("dpsi").to_radians(),
        dt_max: get("dt_max"),
        w_rot: get("w_rot").to_radians(),
        dwell: get("dwell"),
    })
}

/// The process, how far its tool is drawn back [mm], and how fast it comes [mm/s].
pub(super) fn built(
    values: &[f32; PRECESS.len()],
    out: &mut dyn Write,
) -> Result<(Precession<f32>, [f32; 2]), Error> {
    let parameters = precession(values).map_err(|name| bad_choice(name, out))?;
    let made = Precession::new(&parameters).map_err(|error: PrecessionError| {
        let field = error.field().map_or("", |field| field.name());
        say(
            out,
            format_args!("{} {field}: {}", error.name(), error.remedy()),
        );
        Error::ValueRange
    })?;
    let clear = Given::get(values, &PRECESS, "clear");
    check_clear(clear, parameters.feed, out)?;
    Ok((made, [clear, parameters.feed]))
}
