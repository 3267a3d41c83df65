//! The calculators on their data files, and how they refuse.
//!
//! Every line of `cases/calc/*.jsonl` is a case: `call`, `request`, the `answer` (what it lists must be there), and
//! `within`, the tolerance of its numbers (0.6 of the sixth decimal unless given). Figures come from the specification.

use hexstep_host::calc;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn ask(call: &str, scalar: &str, input: impl AsRef<[u8]>) -> (u8, String) {
    let mut output = Vec::new();
    let status = calc::main(call, scalar, input.as_ref(), &mut output).unwrap();
    (status, String::from_utf8(output).unwrap())
}

fn answer(call: &str, request: &Value) -> Value {
    let (_, text) = ask(call, "f64", request.to_string());
    serde_json::from_str(&text).unwrap()
}

fn cases() -> Vec<(String, Value)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/calc");
    let mut cases = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        for (i, line) in text.lines().enumerate() {
            let name = format!("{}:{}", path.file_name().unwrap().display(), i + 1);
            cases.push((name, serde_json::from_str(line).unwrap()));
        }
    }
    cases
}

/// What `wanted` lists and `got` does not hold, as a path to the place.
fn difference(wanted: &Value, got: &Value, close: &dyn Fn(f64, f64) -> bool) -> Option<String> {
    match (wanted, got) {
        (Value::Object(w), Value::Object(g)) => w.iter().find_map(|(k, w)| {
            difference(w, g.get(k).unwrap_or(&json!("absent")), close).map(|d| format!(".{k}{d}"))
        }),
        (Value::Array(w), Value::Array(g)) if w.len() == g.len() => {
            let mut entries = w.iter().zip(g).enumerate();
            entries.find_map(|(i, (w, g))| difference(w, g, close).map(|d| format!("[{i}]{d}")))
        }
        // Entries of a list that the example leaves out.
        (Value::String(w), _) if w == "…" => None,
        (Value::Number(w), Value::Number(g)) => {
            let (w, g) = (w.as_f64().unwrap(), g.as_f64().unwrap());
            (!close(w, g)).then(|| format!(": {g} instead of {w}"))
        }
        (w, g) => (w != g).then(|| format!(": {g} instead of {w}")),
    }
}

#[test]
fn every_case_of_the_data_files_is_answered_as_listed() {
    let mut wrong = Vec::new();
    for (name, case) in cases() {
        let within = case["within"].as_f64().unwrap_or(6e-7);
        let call = case["call"].as_str().unwrap();

        let (status, text) = ask(call, "f64", case["request"].to_string());

        let got: Value = serde_json::from_str(&text).unwrap();
        if let Some(d) = difference(&case["answer"], &got, &|w, g| (w - g).abs() <= within) {
            wrong.push(format!("{name} {call}{d}"));
        }
        let expected = if case["answer"].get("error").is_some() {
            2
        } else {
            0
        };
        if status != expected {
            wrong.push(format!("{name} {call}: exit status {status}\n{text}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A part in 5000 holds for every topic so far; each topic's own tests know its f32 errors better.
#[test]
fn in_f32_every_case_is_answered_alike() {
    let mut wrong = Vec::new();
    for (name, case) in cases() {
        let call = case["call"].as_str().unwrap();
        let request = case["request"].to_string();

        let (status, text) = ask(call, "f32", &request);

        let (status_f64, text_f64) = ask(call, "f64", &request);
        let got: Value = serde_json::from_str(&text).unwrap();
        let mut wanted: Value = serde_json::from_str(&text_f64).unwrap();
        if let Some(wanted) = wanted.as_object_mut() {
            // A coarser tolerance is met sooner.
            wanted.remove("iterations");
        }
        if got["error"] == "ScalarNotOffered" {
            continue;
        }
        if got.get("error").is_some() {
            // The sentence may hold a figure.
            if got["error"] != wanted["error"] || got["field"] != wanted["field"] {
                wrong.push(format!("{name} {call}: {text}"));
            }
            continue;
        }
        let close = |w: f64, g: f64| (w - g).abs() <= 2e-4 * (1.0 + w.abs());
        if let Some(d) = difference(&wanted, &got, &close) {
            wrong.push(format!("{name} {call}{d}"));
        }
        assert_eq!(status, status_f64, "{name} {call}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn an_array_is_answered_case_by_case_whatever_is_wrong_with_one() {
    let drill = json!({"diameter": 9.9, "web": 1.63, "point_angle": 118, "chisel_angle": 50, "clearance": 10, "phi": 30});
    let mut small = drill.clone();
    small["clearance"] = json!(4);

    let (status, text) = ask(
        "drill.solve",
        "f64",
        json!([drill, small, 7, {}, drill]).to_string(),
    );

    let answers: Vec<Value> = serde_json::from_str(&text).unwrap();
    let errors: Vec<_> = answers
        .iter()
        .map(|a| a["error"].as_str().unwrap_or(""))
        .collect();
    assert_eq!(
        errors,
        ["", "ClearanceTooSmall", "BadJson", "MissingField", ""]
    );
    assert_eq!(answers[0], answers[4]);
    assert_eq!(status, 2);
}

#[test]
fn an_empty_array_is_answered_by_an_empty_array() {
    assert_eq!(ask("drill.fk", "f64", " [ ] "), (0, "[]\n".into()));
}

#[test]
fn unreadable_input_has_one_answer_and_status_2() {
    let inputs: [&[u8]; 8] = [
        b"",
        b"{",
        b"[{\"counts\": [1]}, ",
        b"[{\"counts\": [1]}] x",
        b"17",
        b"\xff\xfe\x00",
        b"{\"counts\": [1e999]}",
        b"null",
    ];
    for input in inputs {
        let (status, text) = ask("interp.pulses", "f64", input);

        let answer: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            (status, &answer["error"]),
            (2, &json!("BadJson")),
            "{input:?}"
        );
    }
}

#[test]
fn nesting_beyond_the_parser_is_refused_not_a_crash() {
    let deep = "[".repeat(200_000);
    let inside = format!("[{{\"counts\": {}{}}}]", "[".repeat(500), "]".repeat(500));

    assert!(ask("interp.pulses", "f64", deep).1.contains("BadJson"));
    assert!(ask("interp.pulses", "f64", inside).1.contains("BadJson"));
}

#[test]
fn the_common_errors_come_in_their_order() {
    // Each request has the fault named and every one that comes after it.
    let steps = [
        (json!({"bogus": 1, "preset": 7}), "UnknownField", "bogus"),
        (
            json!({"counts": null, "preset": 7}),
            "MissingField",
            "counts",
        ),
        (json!({"counts": [1], "preset": 7}), "WrongType", "preset"),
        (json!({"counts": [], "preset": "no"}), "WrongType", "counts"),
        (
            json!({"counts": [1.5], "preset": "no"}),
            "WrongType",
            "counts",
        ),
        (
            json!({"counts": ["nan"], "preset": "no"}),
            "WrongType",
            "counts",
        ),
        (
            json!({"counts": [1e30], "preset": "no"}),
            "UnknownName",
            "preset",
        ),
        (json!({"counts": [1e30]}), "OutOfRange", "counts"),
    ];
    for (request, error, field) in steps {
        let answer = answer("interp.pulses", &request);

        assert_eq!(
            (&answer["error"], &answer["field"]),
            (&json!(error), &json!(field)),
            "{request}"
        );
        assert!(answer["detail"].as_str().is_some_and(|d| d.len() > 10));
    }
}

#[test]
fn unknown_functions_and_scalars_are_refused_before_the_input_is_read() {
    assert!(
        ask("drill.sovle", "f32", "{")
            .1
            .contains("\"UnknownFunction\"")
    );
    assert!(
        ask("drill.solve", "f16", "{")
            .1
            .contains("\"ScalarNotOffered\"")
    );
    assert_eq!(ask("drill.sovle", "f64", "[]").0, 2);
}

#[test]
fn counts_are_exact_up_to_two_to_the_62() {
    let limit = 1i64 << 62;

    let at_limit = answer("interp.pulses", &json!({"counts": [1, limit]}));
    let beyond = answer("interp.pulses", &json!({"counts": [1, -limit - 1]}));

    // At the limit the list alone is too long; one more is beyond the range itself.
    for (answer, phrase) in [(at_limit, "too long to list"), (beyond, "beyond 2^62")] {
        assert_eq!(answer["error"], "OutOfRange");
        assert_eq!(answer["index"], 1);
        assert!(answer["detail"].as_str().unwrap().contains(phrase));
    }
}

#[test]
fn a_million_iterations_of_eight_motors_are_listed() {
    let counts: Vec<i64> = (0..8).map(|i| 1_000_000 - 99_999 * i).collect();

    let answer = answer("interp.pulses", &json!({"counts": counts}));

    for (count, pulses) in counts.iter().zip(answer["pulses"].as_array().unwrap()) {
        assert_eq!(pulses.as_array().unwrap().len() as i64, *count);
    }
}

#[test]
fn a_hundred_thousand_cases_are_answered_in_order() {
    let cases: Vec<String> = (0..100_000)
        .map(|i| format!("{{\"counts\":[{}]}}", i % 5))
        .collect();

    let (status, text) = ask("interp.pulses", "f64", format!("[{}]", cases.join(",")));

    let answers: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!((status, answers.len()), (0, 100_000));
    assert!(answers.iter().enumerate().all(|(i, a)| a["max"] == i % 5));
}

#[test]
fn answers_hold_no_minus_zero_and_nothing_that_is_not_finite() {
    let home = json!({"theta1": 0, "theta2": 0, "theta3": "-0", "d1": 0, "d2": 0, "d3": 0, "point_angle": 118, "l1": 0, "l2": 0});
    assert_eq!(answer("drill.fk", &home)["error"], "WrongType");

    let mut home = home;
    home["theta3"] = json!(-0.0);
    let (status, text) = ask("drill.fk", "f64", home.to_string());
    assert_eq!(status, 0);
    assert!(
        !text.contains("-0") && text.contains("\"tip\":[0,0,0]"),
        "{text}"
    );

    home["d1"] = json!(1e308);
    home["l1"] = json!(1e308);
    home["theta2"] = json!(90);
    assert_eq!(answer("drill.fk", &home)["error"], "OutOfRange");
}

#[test]
fn a_number_too_large_for_f32_is_not_finite_there() {
    let plan = json!({"stock": 1e39, "point_angle": 118}).to_string();

    assert!(ask("drill.plan", "f32", &plan).1.contains("\"NotFinite\""));
    assert!(ask("drill.plan", "f64", &plan).1.contains("\"OutOfRange\""));
}

#[test]
fn the_list_names_every_function_and_every_field() {
    let mut output = Vec::new();
    calc::list(&mut output).unwrap();
    let text = String::from_utf8(output).unwrap();

    for function in calc::functions() {
        assert!(text.contains(function.name));
        for field in function.fields.iter().copied().flatten() {
            assert!(
                text.contains(field.name),
                "{} {}",
                function.name,
                field.name
            );
        }
    }
}
