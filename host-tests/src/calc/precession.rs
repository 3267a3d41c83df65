//! `precession.*`: the axis at one point, a whole path, the space it sweeps, the polishing spot.
//!
//! Source: specification of continuous precession; the formulas are those of `hexstep::cycles::precession`.

use super::answer::number;
use super::request::read_vector;
use super::schema::VECTOR;
use super::{Answer, Fault, Field, Function, Kind, Length, Request};
use hexstep::cycles::precession::{
    self as library, Contact, Cycle, Drive, FarEnd, FeedAt, Flags, Parameters, PrecessionError,
    Reference, Stance, Surface, Turn,
};
use hexstep::geometry::{Rotation, Vector};
use hexstep::math::Real;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

const VECTORS: Kind = Kind::List(&VECTOR, Length::Any);

const BONNET: &[Field] = &[
    Field::number("theta", "deg", "0..85").or("20"),
    Field::number("bonnet_radius", "mm", "> 0").or("40"),
    Field::number("inward", "mm", ">= 0, < bonnet_radius").or("0.5"),
];

const PATH: &[Field] = &[
    Field::new("points", VECTORS, "mm", "at least one"),
    Field::new("normals", VECTORS, "", "one for each point"),
    Field::number("feed", "mm/s", "> 0").or("5"),
    Field::number(
        "rate",
        "deg/s",
        "w2, negative: clockwise seen from the spindle",
    )
    .or("30"),
    Field::number(
        "pitch",
        "mm",
        "not 0; phase driven by distance, rate unused",
    )
    .optional(),
    Field::number("alpha0", "deg", "").or("0"),
    Field::new(
        "reference",
        Kind::Word(&["transport", "feed_locked"]),
        "",
        "",
    )
    .or("\"transport\""),
    Field::new("ref", VECTOR, "", "first reference direction").optional(),
    Field::new("feed_at", Kind::Word(&["contact", "centre"]), "", "").or("\"contact\""),
    Field::number("ell", "mm", ">= 0").or("127"),
    Field::new("ell_sign", Kind::Integer, "", "1 or -1").or("1"),
    Field::number("eps", "mm", "> 0").or("0.01"),
    Field::number("dpsi", "deg", "> 0").or("5"),
    Field::number("dt_max", "s", "> 0").or("0.5"),
    Field::number("w_rot", "deg/s", "> 0").or("20"),
    Field::number("dwell", "s", "> 0 for a single point").or("0"),
    Field::new(
        "tool",
        Kind::Flag,
        "",
        "true adds the tool frame to each pose",
    )
    .or("false"),
];

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "precession.axis",
        summary: "The bonnet's axis at one point, with frame, angles and turn-free tool frame.",
        fields: &[&[
            Field::new("normal", VECTOR, "", "outward, longer than 1e-6"),
            Field::new("direction", VECTOR, "", "feed; this or heading").optional(),
            Field::number("heading", "deg", "gamma; this or direction").optional(),
            Field::number("theta", "deg", "0..85"),
            Field::number("alpha", "deg", "").or("0"),
        ]],
        f64: axis::<f64>,
        f32: Some(axis::<f32>),
    },
    Function {
        name: "precession.path",
        summary: "Timed poses along a surface path under continuous precession.",
        fields: &[BONNET, PATH],
        f64: path::<f64>,
        f32: Some(path::<f32>),
    },
    Function {
        name: "precession.spot",
        summary: "Radius of the contact circle and rubbing speed in its middle.",
        fields: &[
            BONNET,
            &[
                Field::number(
                    "surface_radius",
                    "mm",
                    "> 0 convex, < 0 concave; left out: plane",
                )
                .optional(),
                Field::number("spindle", "r/min", "").or("0"),
            ],
        ],
        f64: spot::<f64>,
        f32: Some(spot::<f32>),
    },
    Function {
        name: "precession.swept",
        summary: "The space swept: curve of the ball's centre, curve of the far point, its box and length.",
        fields: &[BONNET, PATH],
        f64: swept::<f64>,
        f32: Some(swept::<f32>),
    },
];

/// More poses than this are refused: their answer would fill the memory.
const LONGEST: u64 = 500_000;

fn refused(error: PrecessionError) -> Fault {
    let mut fault = Fault::new(error.name(), error.remedy());
    if let Some(field) = error.field() {
        fault = fault.field(field.name());
    }
    match error.index() {
        Some(index) => fault.with("index", index),
        None => fault,
    }
}

fn non_finite(field: library::Field) -> Fault {
    refused(PrecessionError::NonFinite { field, index: None })
}

fn vector<R: Real>(v: Vector<R>) -> Value {
    v.to_array().map(number).into_iter().collect()
}

fn rows<R: Real>(rotation: Rotation<R>) -> Value {
    let t = rotation.transposed();
    [t.n, t.s, t.a].map(vector).into_iter().collect()
}

fn axis<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (direction, heading) = (
        request.maybe_vector::<R>("direction"),
        request.maybe_number::<R>("heading"),
    );
    match (direction, heading) {
        (Some(_), Some(_)) => {
            let detail = "give direction or heading, not both";
            return Err(Fault::new("UnknownField", detail).field("heading"));
        }
        (None, None) => {
            let detail = "direction, the feed, or heading, an angle [deg], is required";
            return Err(Fault::new("MissingField", detail).field("direction"));
        }
        _ => {}
    }
    let theta = request.degrees::<R>("theta");
    let tilted = theta >= R::ZERO && theta <= R::of(85.0).to_radians();
    if !tilted {
        return Err(refused(PrecessionError::BadTilt));
    }
    let normal = request.vector::<R>("normal");
    let Some(c) = normal.unit(R::of(1e-6)) else {
        let detail = PrecessionError::BadNormal { index: 0 }.remedy();
        return Err(Fault::new("BadNormal", detail).field("normal"));
    };
    let alpha = request.degrees::<R>("alpha");
    if !alpha.is_finite() {
        return Err(non_finite(library::Field::Alpha));
    }
    if direction.is_some_and(|d| !d.is_finite()) {
        return Err(non_finite(library::Field::Direction));
    }
    if heading.is_some_and(|h| !h.is_finite()) {
        return Err(non_finite(library::Field::Heading));
    }
    let frame = match (direction, heading) {
        (Some(feed), _) => library::along_feed(feed, c),
        (_, heading) => library::along_heading(heading.unwrap_or(R::ZERO).to_radians(), c),
    }
    .map_err(refused)?;
    let (tilt, phase) = (theta.sin_cos(), Turn::of_radians(alpha).sin_cos());
    Ok(Answer::new()
        .vector("axis", library::axis(&frame, tilt, phase))
        .rotation("frame", frame)
        .numbers("angles", library::angles(&frame).map(R::to_degrees))
        .rotation("tool", library::tool_frame(&frame, tilt, phase)))
}

/// The process and the path of a request, not yet checked.
struct Asked<R> {
    parameters: Parameters<R>,
    contacts: Vec<Contact<R>>,
}

impl<R: Real> Asked<R> {
    fn read(request: &Request) -> Result<Self, Fault> {
        let parameters = Parameters {
            theta: request.degrees("theta"),
            bonnet_radius: request.number("bonnet_radius"),
            inward: request.number("inward"),
            feed: request.number("feed"),
            feed_at: match request.word("feed_at") {
                "centre" => FeedAt::Centre,
                _ => FeedAt::Contact,
            },
            drive: match request.maybe_number("pitch") {
                Some(pitch) => Drive::Distance { pitch },
                None => Drive::Time {
                    rate: request.degrees("rate"),
                },
            },
            alpha0: request.degrees("alpha0"),
            reference: match request.word("reference") {
                "feed_locked" => Reference::FeedLocked,
                _ => Reference::Transport,
            },
            first_reference: request.maybe_vector("ref"),
            ell: request.number("ell"),
            far_end: match request.integer("ell_sign") {
                -1 => FarEnd::Surface,
                _ => FarEnd::Spindle,
            },
            eps: request.number("eps"),
            dpsi: request.degrees("dpsi"),
            dt_max: request.number("dt_max"),
            w_rot: request.degrees("w_rot"),
            dwell: request.number("dwell"),
        };
        let read = |name| request.list(name).iter().filter_map(read_vector::<R>);
        let mut contacts: Vec<_> = read("points")
            .zip(read("normals"))
            .map(|(p, n)| Contact { p, n })
            .collect();
        if request.list("points").len() != request.list("normals").len() {
            // Refused as a path without points: the checks before it still come first.
            contacts.clear();
        }
        Ok(Self {
            parameters,
            contacts,
        })
    }

    fn cycle(&self, request: &Request) -> Result<Cycle<'_, R>, Fault> {
        let cycle = Cycle::new(&self.parameters, &self.contacts).map_err(refused)?;
        // Unused beside a pitch, but no number of a request may be none.
        if !request.number::<R>("rate").is_finite() {
            return Err(non_finite(library::Field::Rate));
        }
        if !matches!(request.integer("ell_sign"), 1 | -1) {
            let detail = "ell_sign must be 1, towards the spindle, or -1, towards the surface";
            return Err(Fault::new("BadLimit", detail).field("ell_sign"));
        }
        let poses: u64 = cycle.segments().map(|s| u64::from(s.steps())).sum();
        if poses > LONGEST {
            let detail = format!(
                "the path needs {poses} poses, more than {LONGEST} are too long to list; divide the path, or raise eps, dpsi or dt_max"
            );
            return Err(Fault::new("BadLimit", detail));
        }
        let fits = |s: Stance<R>| s.centre.is_finite() && s.far.is_finite() && s.time.is_finite();
        if !cycle.stances().all(fits) {
            return Err(non_finite(library::Field::Points));
        }
        Ok(cycle)
    }
}

/// Poses, written one by one: as values in memory they would take ten times the room of their text.
struct Poses<'a, R> {
    cycle: &'a Cycle<'a, R>,
    tool: bool,
}

impl<R: Real> Serialize for Poses<'_, R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let stances = self.cycle.stances();
        serializer.collect_seq(stances.map(|stance| pose(&stance, self.tool)))
    }
}

/// Vectors, in the same way.
struct Curve<'a, R>(&'a [Vector<R>]);

impl<R: Real> Serialize for Curve<'_, R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(|v| vector(*v)))
    }
}

fn path<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let asked = Asked::<R>::read(request)?;
    let cycle = asked.cycle(request)?;
    let counts: Vec<u32> = cycle.segments().map(|s| s.steps()).collect();
    let total_time = cycle.stances().last().map(|stance| stance.time);
    let flags = cycle
        .segments()
        .fold(Flags::default(), |flags, s| flags.or(s.flags()));
    let tool = request.flag("tool");
    let poses = cycle.stances().count();
    Ok(Answer::new()
        .put("count", &poses)
        .put("per_segment", &counts)
        .maybe_number("total_time", total_time)
        .put("flags", &flags.names().collect::<Vec<_>>())
        .put(
            "poses",
            &Poses {
                cycle: &cycle,
                tool,
            },
        ))
}

fn pose<R: Real>(stance: &Stance<R>, tool: bool) -> Value {
    let mut members = Map::new();
    let mut put = |name: &str, value| {
        members.insert(name.into(), value);
    };
    put("segment", Value::from(stance.segment));
    put("u", number(stance.u));
    put("dt", number(stance.dt));
    put("t", number(stance.time));
    put("inverse_time", number(stance.inverse_time()));
    put("phase", number(stance.phase.to_degrees::<R>()));
    put("centre", vector(stance.centre));
    put("axis", vector(stance.axis));
    put("far", vector(stance.far));
    if tool {
        put("tool", rows(stance.tool()));
    }
    Value::Object(members)
}

fn swept<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let asked = Asked::<R>::read(request)?;
    let cycle = asked.cycle(request)?;
    let (centres, far): (Vec<_>, Vec<_>) = cycle.stances().map(|s| (s.centre, s.far)).unzip();
    let corner = |pick: fn(R, R) -> R| {
        let first = far.first().copied().unwrap_or(Vector::ZERO);
        far.iter().fold(first, |m, v| {
            Vector::new(pick(m.x, v.x), pick(m.y, v.y), pick(m.z, v.z))
        })
    };
    let length = far
        .windows(2)
        .fold(R::ZERO, |sum, pair| sum + (pair[1] - pair[0]).norm());
    Ok(Answer::new()
        .put("c", &Curve(&centres))
        .put("a", &Curve(&far))
        .put("bbox", &[vector(corner(R::min)), vector(corner(R::max))])
        .number("length", length))
}

fn spot<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let theta = request.degrees::<R>("theta");
    let tilted = theta >= R::ZERO && theta <= R::of(85.0).to_radians();
    if !tilted {
        return Err(refused(PrecessionError::BadTilt));
    }
    let radius = request.number::<R>("bonnet_radius");
    let inward = request.number::<R>("inward");
    let surface = match request.maybe_number::<R>("surface_radius") {
        None => Surface::Plane,
        Some(s) if s > R::ZERO => Surface::Convex(s),
        Some(s) => Surface::Concave(-s),
    };
    let contact = library::contact_radius(radius, inward, surface).map_err(refused)?;
    let spindle = request.number::<R>("spindle");
    for (field, x) in [
        (library::Field::BonnetRadius, radius),
        (library::Field::Spindle, spindle),
    ] {
        if !x.is_finite() {
            return Err(non_finite(field));
        }
    }
    let w1 = spindle * R::TAU / R::of(60.0);
    let speed = library::rubbing_speed(w1, radius - inward, theta);
    Ok(Answer::new()
        .number("radius", contact)
        .number("rubbing_speed", speed))
}
