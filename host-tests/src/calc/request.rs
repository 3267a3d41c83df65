//! One case of a function: typed access to its fields, after the schema has been checked.

use super::schema::{self, Field};
use super::{Fault, Scalar};
use hexstep::geometry::Vector;
use hexstep::math::Real;
use serde_json::{Map, Value};

/// A request whose fields are all known, present and of the right form.
///
/// The accessors are generic over [`Real`], so that with `f32` every number is rounded to `f32` where it is read.
/// To ask for a field that the function's table does not declare, or in another form, is a fault of the program.
pub struct Request {
    fields: &'static [&'static [Field]],
    object: Map<String, Value>,
    scalar: Scalar,
}

impl Request {
    pub(super) fn new(
        fields: &'static [&'static [Field]],
        mut object: Map<String, Value>,
        scalar: Scalar,
    ) -> Result<Self, Fault> {
        schema::check(fields, &object)?;
        for field in fields.iter().copied().flatten() {
            if let Some(text) = field.default() {
                let absent = match object.get(field.name) {
                    None => true,
                    Some(value) => {
                        value.is_null() && !matches!(field.kind, schema::Kind::OrNull(_))
                    }
                };
                if absent {
                    let value = serde_json::from_str(text).expect("a default is valid JSON");
                    object.insert(field.name.into(), value);
                }
            }
        }
        Ok(Self {
            fields,
            object,
            scalar,
        })
    }

    /// The field's value; `None` if it was left out and has no default, or is `null`.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.object.get(name).filter(|v| !v.is_null())
    }

    pub fn is_given(&self, name: &str) -> bool {
        self.value(name).is_some()
    }

    /// The first field, in the order of the table, that holds a number which `R` cannot hold as a finite one.
    pub fn not_finite<R: Real>(&self) -> Option<&'static str> {
        let fields = self.fields.iter().copied().flatten();
        fields
            .filter(|f| {
                self.value(f.name)
                    .is_some_and(|v| !schema::all_finite::<R>(&f.kind, v))
            })
            .map(|f| f.name)
            .next()
    }

    pub fn number<R: Real>(&self, name: &str) -> R {
        self.maybe_number(name)
            .unwrap_or_else(|| panic!("{name} is not declared as a number"))
    }

    pub fn maybe_number<R: Real>(&self, name: &str) -> Option<R> {
        self.value(name).and_then(read)
    }

    /// An angle, given in degrees, in radians.
    pub fn degrees<R: Real>(&self, name: &str) -> R {
        self.number::<R>(name).to_radians()
    }

    /// A whole number; with `f32` rounded like every other.
    pub fn integer(&self, name: &str) -> i128 {
        let value = self.value(name).and_then(schema::integer_of);
        let i = value.unwrap_or_else(|| panic!("{name} is not declared as an integer"));
        match self.scalar {
            Scalar::F64 => i,
            Scalar::F32 => i as f32 as i128,
        }
    }

    /// Whole numbers as they stand, never rounded.
    pub fn integers(&self, name: &str) -> Vec<i128> {
        self.list(name)
            .iter()
            .filter_map(schema::integer_of)
            .collect()
    }

    pub fn flag(&self, name: &str) -> bool {
        self.value(name).and_then(Value::as_bool).unwrap_or(false)
    }

    pub fn word(&self, name: &str) -> &str {
        self.value(name).and_then(Value::as_str).unwrap_or("")
    }

    /// The entries of an array; empty if it was left out.
    pub fn list(&self, name: &str) -> &[Value] {
        match self.value(name) {
            Some(Value::Array(entries)) => entries,
            _ => &[],
        }
    }

    pub fn numbers<R: Real>(&self, name: &str) -> Vec<R> {
        self.list(name).iter().filter_map(read).collect()
    }

    pub fn vector<R: Real>(&self, name: &str) -> Vector<R> {
        self.maybe_vector(name)
            .unwrap_or_else(|| panic!("{name} is not declared as a vector"))
    }

    pub fn maybe_vector<R: Real>(&self, name: &str) -> Option<Vector<R>> {
        self.value(name).and_then(read_vector)
    }
}

/// The number that a value stands for.
pub fn read<R: Real>(value: &Value) -> Option<R> {
    schema::number_of(value).map(R::of)
}

/// The three numbers that a value stands for.
pub fn read_vector<R: Real>(value: &Value) -> Option<Vector<R>> {
    match value.as_array()?.as_slice() {
        [x, y, z] => Some(Vector::new(read(x)?, read(y)?, read(z)?)),
        _ => None,
    }
}
