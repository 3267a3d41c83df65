//! The validation table by name, through the calculators: a refused call answers its error and nothing else.

use hexstep_host::calc;
use serde_json::{Map, Value, json};

fn ask(call: &str, request: &Value) -> (u8, Value) {
    let mut output = Vec::new();
    let status = calc::main(call, "f64", request.to_string().as_bytes(), &mut output).unwrap();
    (status, serde_json::from_slice(&output).unwrap())
}

fn with(changes: &Value) -> Value {
    let mut request = json!({"points": [[0, 0, 0], [10, 0, 0]], "normals": [[0, 0, 1], [0, 0, 1]]});
    let members: &Map<String, Value> = changes.as_object().unwrap();
    for (name, value) in members {
        request[name] = value.clone();
    }
    request
}

#[track_caller]
fn refused(call: &str, request: &Value, error: &str, field: &str) {
    let (status, answer) = ask(call, request);

    assert_eq!(status, 2, "{request}");
    assert_eq!(answer["error"], error, "{request}: {answer}");
    assert_eq!(answer["field"], field, "{request}: {answer}");
    assert!(answer["detail"].as_str().unwrap().len() > 20, "{answer}");
    assert!(answer.get("poses").is_none());
}

#[test]
fn every_row_of_the_validation_table_is_refused_by_name() {
    let rows = [
        (json!({"theta": -1}), "BadTilt", "theta"),
        (json!({"theta": 85.001}), "BadTilt", "theta"),
        (json!({"theta": "nan"}), "BadTilt", "theta"),
        (json!({"bonnet_radius": 0}), "BadBonnet", "bonnet_radius"),
        (json!({"inward": 40}), "BadBonnet", "bonnet_radius"),
        (json!({"inward": -0.1}), "BadBonnet", "bonnet_radius"),
        (json!({"feed": 0}), "BadFeedRate", "feed"),
        (json!({"feed": "inf"}), "BadFeedRate", "feed"),
        (json!({"rate": "nan"}), "BadRate", "rate"),
        (json!({"pitch": 0}), "BadPitch", "pitch"),
        (json!({"pitch": "inf"}), "BadPitch", "pitch"),
        (json!({"eps": 0}), "BadLimit", "eps"),
        (json!({"dpsi": -1}), "BadLimit", "dpsi"),
        (json!({"dt_max": 0}), "BadLimit", "dt_max"),
        (json!({"w_rot": 0}), "BadLimit", "w_rot"),
        (json!({"ell": -1}), "BadLimit", "ell"),
        (json!({"ell_sign": 2}), "BadLimit", "ell_sign"),
        (json!({"points": [], "normals": []}), "BadPath", "points"),
        (json!({"points": [[0, 0, 0]]}), "BadPath", "points"),
        (
            json!({"normals": [[0, 0, 1], [0, 0, 0]]}),
            "BadNormal",
            "normals",
        ),
        (
            json!({"normals": [[0, 0, 1], [0, 0, "nan"]]}),
            "BadNormal",
            "normals",
        ),
        (
            json!({"normals": [[0, 0, 1], [0, 0, -1]]}),
            "AntiParallel",
            "normals",
        ),
        (
            json!({"normals": [[0, 0, 1], [0.0005, 0, -1]]}),
            "AntiParallel",
            "normals",
        ),
        (
            json!({"points": [[0, 0, 0]], "normals": [[0, 0, 1]]}),
            "BadDwell",
            "dwell",
        ),
        (
            json!({"points": [[0, 0, 0]], "normals": [[0, 0, 1]], "dwell": "nan"}),
            "BadDwell",
            "dwell",
        ),
        (
            json!({"points": [[0, 0, 0], ["nan", 0, 0]]}),
            "NonFinite",
            "points",
        ),
        (
            json!({"points": [[0, 0, 0], ["inf", 0, 0]]}),
            "NonFinite",
            "points",
        ),
        (json!({"alpha0": "nan"}), "NonFinite", "alpha0"),
        (json!({"ref": [0, "nan", 0]}), "NonFinite", "ref"),
        (json!({"eps": "inf"}), "NonFinite", "eps"),
        (
            json!({"bonnet_radius": "inf"}),
            "NonFinite",
            "bonnet_radius",
        ),
        (json!({"dwell": "inf"}), "NonFinite", "dwell"),
        (json!({"pitch": 8, "rate": "nan"}), "NonFinite", "rate"),
    ];
    for (changes, error, field) in &rows {
        refused("precession.path", &with(changes), error, field);
        refused("precession.swept", &with(changes), error, field);
    }
}

#[test]
fn of_two_faults_the_upper_row_of_the_table_wins() {
    let order = [
        (json!({"theta": 90}), "BadTilt"),
        (json!({"inward": 50}), "BadBonnet"),
        (json!({"feed": -1}), "BadFeedRate"),
        (json!({"rate": "inf"}), "BadRate"),
        (json!({"dpsi": 0}), "BadLimit"),
        (json!({"normals": [[0, 0, 1], [0, 0, 0]]}), "BadNormal"),
        (json!({"alpha0": "inf"}), "NonFinite"),
    ];
    for (i, (upper, error)) in order.iter().enumerate() {
        for (lower, _) in &order[i + 1..] {
            let mut request = with(upper);
            for (name, value) in lower.as_object().unwrap() {
                request[name] = value.clone();
            }
            assert_eq!(
                ask("precession.path", &request).1["error"],
                *error,
                "{request}"
            );
        }
    }
}

#[test]
fn the_index_is_that_of_the_point_at_fault() {
    let request = with(&json!({
        "points": [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        "normals": [[0, 0, 1], [0, 0, 1], [0, 0, -1]],
    }));

    assert_eq!(ask("precession.path", &request).1["index"], 2);
}

#[test]
fn flags_are_raised_once_and_in_alphabetical_order() {
    let request = json!({
        "points": [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 5], [5, 0, 5], [5, 0, 5]],
        "normals": [[0, 0, 1], [0, 0, 1], [0, 1, 1], [0, 1, 1], [0, 0, 1], [0, 0, 1]],
        "reference": "feed_locked",
    });
    let (status, answer) = ask("precession.path", &request);

    assert_eq!(status, 0);
    assert_eq!(
        answer["flags"],
        json!(["CoarseNormals", "Pivot", "Skipped"])
    );
    let along = with(&json!({"points": [[0, 0, 0], [0, 0, 9]], "reference": "feed_locked"}));
    let flags = &ask("precession.path", &along).1["flags"];
    assert_eq!(*flags, json!(["FeedAlongNormal"]));
}

#[test]
fn a_path_of_too_many_poses_is_refused_and_not_listed() {
    let request = with(&json!({"eps": 1e-12}));
    let (status, answer) = ask("precession.path", &request);
    assert_eq!((status, &answer["error"]), (2, &json!("BadLimit")));

    let request = with(&json!({"eps": 1e-30}));
    let (status, answer) = ask("precession.path", &request);
    assert_eq!((status, &answer["error"]), (2, &json!("BadLimit")));
}

#[test]
fn a_single_pose_is_refused_by_name() {
    let axis = |changes: Value| {
        let mut request = json!({"normal": [0, 0, 1], "theta": 20});
        for (name, value) in changes.as_object().unwrap() {
            request[name] = value.clone();
        }
        request
    };
    let rows = [
        (json!({"theta": 86, "heading": 0}), "BadTilt", "theta"),
        (
            json!({"normal": [0, 0, 0], "heading": 0}),
            "BadNormal",
            "normal",
        ),
        (
            json!({"normal": ["inf", 0, 0], "heading": 0}),
            "BadNormal",
            "normal",
        ),
        (
            json!({"direction": [0, 0, 3]}),
            "FeedAlongNormal",
            "direction",
        ),
        (
            json!({"direction": [0, 0, 0]}),
            "FeedAlongNormal",
            "direction",
        ),
        (
            json!({"normal": [0, 1, -0.001], "heading": 0}),
            "NormalDown",
            "heading",
        ),
        (json!({"heading": "nan"}), "NonFinite", "heading"),
        (json!({"heading": 0, "alpha": "inf"}), "NonFinite", "alpha"),
        (
            json!({"direction": [0, "nan", 3]}),
            "NonFinite",
            "direction",
        ),
        (json!({}), "MissingField", "direction"),
        (
            json!({"direction": [1, 0, 0], "heading": 0}),
            "UnknownField",
            "heading",
        ),
    ];
    for (changes, error, field) in rows {
        refused("precession.axis", &axis(changes), error, field);
    }
}

#[test]
fn a_spot_is_refused_by_name() {
    let rows = [
        (
            json!({"surface_radius": -40}),
            "BonnetTooLarge",
            "surface_radius",
        ),
        (
            json!({"surface_radius": 0}),
            "BonnetTooLarge",
            "surface_radius",
        ),
        (
            json!({"surface_radius": 0.25}),
            "BonnetTooLarge",
            "surface_radius",
        ),
        (
            json!({"surface_radius": "nan"}),
            "NonFinite",
            "surface_radius",
        ),
        (json!({"inward": 41}), "BadBonnet", "bonnet_radius"),
        (json!({"theta": 86}), "BadTilt", "theta"),
        (json!({"spindle": "inf"}), "NonFinite", "spindle"),
    ];
    for (request, error, field) in rows {
        refused("precession.spot", &request, error, field);
    }
}

/// On a vertical wall the printed formula divides by zero; the heading along it is the reference itself.
#[test]
fn a_vertical_wall_has_a_frame_for_every_heading() {
    for (heading, a) in [
        (0.0, [0.0, 0.0, -1.0]),
        (90.0, [0.0, 1.0, 0.0]),
        (270.0, [0.0, -1.0, 0.0]),
    ] {
        let request = json!({"normal": [1, 0, 0], "heading": heading, "theta": 0});
        let (_, answer) = ask("precession.axis", &request);
        for (row, a) in answer["frame"].as_array().unwrap().iter().zip(a) {
            assert!(
                (row[0].as_f64().unwrap() - a).abs() < 1e-12,
                "{heading}: {answer}"
            );
        }
    }
}
