//! The calculators of `hexstep calc TOPIC.FUNCTION`: a JSON request to a JSON answer.
//!
//! ```text
//! bytes -> BadJson?   -> one object or an array of them
//! each  -> schema     -> UnknownField, MissingField, WrongType, UnknownName
//!       -> the function in f64 or f32 -> figures, or a fault by its specification's name
//! ```
//!
//! Lengths in mm, angles in degrees, times in s. A topic is one file with a table of [`Function`]s; it joins by one
//! line in `TOPICS`. A bad case is answered in its place and makes the exit status 2; the others are answered all
//! the same. Memory is bounded by the input, not by the answers: each case is read, computed and written in turn.

pub mod answer;
mod arm;
mod chain;
mod drill;
mod five_axis;
mod interp;
mod machine;
mod mirror;
mod precession;
pub mod request;
pub mod schema;
mod shaper;
mod surface;

pub use answer::{Answer, Fault};
pub use request::Request;
pub use schema::{Field, Kind, Length};

use serde_json::Value;
use serde_json::value::RawValue;
use std::io::{self, BufWriter, Read, Write};

/// Every topic: one line each.
const TOPICS: &[&[Function]] = &[
    interp::FUNCTIONS,
    drill::FUNCTIONS,
    five_axis::FUNCTIONS,
    arm::FUNCTIONS,
    chain::FUNCTIONS,
    mirror::FUNCTIONS,
    mirror::trim::FUNCTIONS,
    precession::FUNCTIONS,
    shaper::FUNCTIONS,
    surface::FUNCTIONS,
];

/// One calculator.
pub struct Function {
    /// `topic.function`
    pub name: &'static str,
    pub summary: &'static str,
    /// Groups of fields, so that functions can share them.
    pub fields: &'static [&'static [Field]],
    pub f64: Handler,
    /// `None` where the function runs on the host in f64 only.
    pub f32: Option<Handler>,
}

pub type Handler = fn(&Request) -> Result<Answer, Fault>;

/// The type in which geometry and kinematics are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    F64,
    F32,
}

/// Exit status: every case was answered.
pub const ANSWERED: u8 = 0;
/// Exit status: bad input.
pub const BAD_INPUT: u8 = 2;

pub fn functions() -> impl Iterator<Item = &'static Function> {
    TOPICS.iter().copied().flatten()
}

/// Answers the cases on `input` on `output`; returns the exit status. `scalar` is `"f64"` or `"f32"`.
pub fn main(
    function: &str,
    scalar: &str,
    mut input: impl Read,
    output: impl Write,
) -> io::Result<u8> {
    let mut output = BufWriter::new(output);
    let status = match prepare(function, scalar) {
        Ok((function, scalar)) => {
            let mut bytes = Vec::new();
            input.read_to_end(&mut bytes)?;
            answer_all(function, scalar, &bytes, &mut output)?
        }
        Err(fault) => refuse(fault, &mut output)?,
    };
    output.flush()?;
    Ok(status)
}

fn prepare(name: &str, scalar: &str) -> Result<(&'static Function, Scalar), Fault> {
    let function = functions().find(|f| f.name == name).ok_or_else(|| {
        let detail = format!("there is no function {name}; `hexstep calc --list` shows them all");
        Fault::new("UnknownFunction", detail)
    })?;
    let scalar = match (scalar, function.f32) {
        ("f64", _) => Scalar::F64,
        ("f32", Some(_)) => Scalar::F32,
        ("f32", None) => {
            let detail = format!("{name} runs in f64 only; leave --scalar out");
            return Err(Fault::new("ScalarNotOffered", detail));
        }
        _ => {
            let detail = format!("--scalar must be f64 or f32, not {scalar}");
            return Err(Fault::new("ScalarNotOffered", detail));
        }
    };
    Ok((function, scalar))
}

fn answer_all(
    function: &Function,
    scalar: Scalar,
    bytes: &[u8],
    output: &mut impl Write,
) -> io::Result<u8> {
    let Ok(text) = str::from_utf8(bytes) else {
        return refuse(bad_json("it is not UTF-8"), output);
    };
    if !text.trim_ascii_start().starts_with('[') {
        return match answer_one(function, scalar, text) {
            Ok(answer) => writeln!(output, "{answer}").map(|()| ANSWERED),
            Err(fault) => refuse(fault, output),
        };
    }
    // The whole text is checked before the first answer is written, so that unreadable input has one answer.
    let cases: Vec<&RawValue> = match serde_json::from_str(text) {
        Ok(cases) => cases,
        Err(error) => return refuse(bad_json(&error.to_string()), output),
    };
    let mut status = ANSWERED;
    for (i, case) in cases.iter().enumerate() {
        let answer = answer_one(function, scalar, case.get()).unwrap_or_else(|fault| {
            status = BAD_INPUT;
            fault.into_text()
        });
        let before = if i == 0 { "[" } else { ",\n " };
        write!(output, "{before}{answer}")?;
    }
    writeln!(output, "{}", if cases.is_empty() { "[]" } else { "]" })?;
    Ok(status)
}

fn answer_one(function: &Function, scalar: Scalar, text: &str) -> Result<String, Fault> {
    let object = match serde_json::from_str(text) {
        Ok(Value::Object(object)) => object,
        Ok(_) => return Err(bad_json("a case is an object, as in {\"name\": 1}")),
        Err(error) => return Err(bad_json(&error.to_string())),
    };
    let request = Request::new(function.fields, object, scalar)?;
    match (scalar, function.f32) {
        (Scalar::F32, Some(handler)) => handler(&request)?,
        _ => (function.f64)(&request)?,
    }
    .finish()
}

fn bad_json(why: &str) -> Fault {
    let detail = format!("standard input must hold one JSON object or an array of objects: {why}");
    Fault::new("BadJson", detail)
}

fn refuse(fault: Fault, output: &mut impl Write) -> io::Result<u8> {
    writeln!(output, "{}", fault.into_text())?;
    Ok(BAD_INPUT)
}

/// Writes every function with its fields, units, ranges and defaults.
pub fn list(mut output: impl Write) -> io::Result<()> {
    for function in functions() {
        let scalars = if function.f32.is_some() {
            "f64, f32"
        } else {
            "f64"
        };
        writeln!(output, "{}  ({scalars})", function.name)?;
        writeln!(output, "    {}", function.summary)?;
        for field in function.fields.iter().copied().flatten() {
            let need = match field.default() {
                Some(default) => format!("default {default}"),
                None if field.is_required() => "required".into(),
                None => "optional".into(),
            };
            let range = match field.range {
                "" => String::new(),
                range => format!(", {range}"),
            };
            writeln!(
                output,
                "      {:<18} {}{}{range}; {need}",
                field.name,
                schema::form(&field.kind),
                schema::bracketed(field.unit),
            )?;
        }
        writeln!(output)?;
    }
    Ok(())
}
