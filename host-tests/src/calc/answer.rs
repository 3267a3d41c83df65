//! What a function of `hexstep calc` answers: one JSON object, of figures or of a fault.

use hexstep::geometry::{Rotation, Vector};
use hexstep::math::Real;
use serde::Serialize;
use serde_json::Value;

/// An answer under construction; members stand in the order in which they are put.
#[derive(Default)]
pub struct Answer {
    text: String,
    /// A member that should be a number and is none: a result beyond what the scalar can hold.
    overflow: Option<String>,
}

impl Answer {
    pub fn new() -> Self {
        Self::default()
    }

    /// A member that serialises to JSON and holds no floating-point number.
    pub fn put(mut self, name: &str, value: &(impl Serialize + ?Sized)) -> Self {
        self.text.push(if self.text.is_empty() { '{' } else { ',' });
        self.text.push_str(&plain(name));
        self.text.push(':');
        self.text.push_str(&plain(value));
        self
    }

    /// A member of any shape; its numbers are put in order (see [`number`]).
    pub fn value(self, name: &str, value: Value) -> Self {
        self.put(name, &tidy(value))
    }

    pub fn number<R: Real>(mut self, name: &str, x: R) -> Self {
        self.watch(name, x);
        self.put(name, &number(x))
    }

    /// An angle in radians, answered in degrees.
    pub fn degrees<R: Real>(self, name: &str, x: R) -> Self {
        self.number(name, x.to_degrees())
    }

    /// An angle in radians, or nothing, answered in degrees or as `null`.
    pub fn maybe_degrees<R: Real>(self, name: &str, x: Option<R>) -> Self {
        self.put(name, &x.map(|x| number(x.to_degrees())))
    }

    pub fn maybe_number<R: Real>(self, name: &str, x: Option<R>) -> Self {
        self.put(name, &x.map(number))
    }

    pub fn numbers<R: Real>(mut self, name: &str, xs: impl IntoIterator<Item = R>) -> Self {
        let watched = xs.into_iter().inspect(|x| self.watch(name, *x));
        let values: Vec<Value> = watched.map(number).collect();
        self.put(name, &values)
    }

    pub fn vector<R: Real>(self, name: &str, v: Vector<R>) -> Self {
        self.numbers(name, v.to_array())
    }

    /// A rotation as an array of rows.
    pub fn rotation<R: Real>(mut self, name: &str, r: Rotation<R>) -> Self {
        let t = r.transposed();
        for column in [r.n, r.s, r.a] {
            for x in column.to_array() {
                self.watch(name, x);
            }
        }
        let rows = [t.n, t.s, t.a].map(|row| row.to_array().map(number));
        self.put(name, &rows)
    }

    fn watch<R: Real>(&mut self, name: &str, x: R) {
        if !x.is_finite() && self.overflow.is_none() {
            self.overflow = Some(name.into());
        }
    }

    /// The finished object; refused if a figure is beyond what the scalar can hold.
    pub(super) fn finish(self) -> Result<String, Fault> {
        match self.overflow {
            None if self.text.is_empty() => Ok("{}".into()),
            None => Ok(self.text + "}"),
            Some(name) => {
                let detail =
                    format!("the figures are too large: {name} overflowed; scale the request down");
                Err(Fault::new("OutOfRange", detail))
            }
        }
    }
}

/// A number as an answer prints it: -0 as 0, whole numbers without a point, `null` for what is no number.
pub fn number<R: Real>(x: R) -> Value {
    // Every whole number up to 2^53 is an f64 of its own.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let x = x.to_f64();
    if x == x.trunc() && x.abs() <= EXACT {
        Value::from(x as i64)
    } else {
        Value::from(x)
    }
}

fn tidy(value: Value) -> Value {
    match value {
        Value::Number(n) if n.is_f64() => n.as_f64().map_or(Value::Null, number),
        Value::Array(entries) => entries.into_iter().map(tidy).collect(),
        Value::Object(object) => object.into_iter().map(|(k, v)| (k, tidy(v))).collect(),
        other => other,
    }
}

fn plain(value: &(impl Serialize + ?Sized)) -> String {
    serde_json::to_string(value).expect("plain data serialises")
}

/// Why a case was refused: the specification's name, what was expected and what to do, and further figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub error: String,
    pub detail: String,
    more: Vec<(&'static str, Value)>,
}

impl Fault {
    pub fn new(error: impl Into<String>, detail: impl Into<String>) -> Self {
        Self {
            error: error.into(),
            detail: detail.into(),
            more: Vec::new(),
        }
    }

    /// The field of the request that is at fault.
    pub fn field(self, name: &str) -> Self {
        self.with("field", name)
    }

    /// A further member: `index`, `axis`, `least`, ...
    pub fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.more.push((name, tidy(value.into())));
        self
    }

    pub(super) fn into_text(self) -> String {
        let start = Answer::new()
            .put("error", &self.error)
            .put("detail", &self.detail);
        let more = self.more.into_iter();
        more.fold(start, |answer, (name, value)| answer.put(name, &value))
            .text
            + "}"
    }
}
