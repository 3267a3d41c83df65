//! The `use` lines of the library hold the picture of its crate page true: data flows down, and so do dependencies.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Stages in the order in which data flows, and the base below them all.
const STAGES: [&str; 8] = [
    "controller",
    "protocol",
    "program",
    "path",
    "kinematics",
    "planner",
    "shaper",
    "stepper",
];
const BASE: [&str; 6] = ["board", "error", "geometry", "joints", "math", "settings"];
/// Extensions: what plugs in, and into what.
const EXTENSIONS: [(&str, &str); 2] = [("cycles", "path"), ("machines", "kinematics")];

fn sources(dir: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

/// Top-level modules of the library that each of them names, tests and comments left out.
fn dependencies() -> BTreeMap<String, Vec<String>> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src");
    let mut uses: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in sources(&src) {
        let inside = file.strip_prefix(&src).unwrap();
        let module = inside
            .components()
            .next()
            .unwrap()
            .as_os_str()
            .to_string_lossy()
            .replace(".rs", "");
        if ["lib", "main", "bench", "boards"].contains(&module.as_str()) {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap();
        for line in text.lines().map(str::trim).filter(|l| !l.starts_with("//")) {
            for part in line.split("crate::").skip(1) {
                let name: String = part
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .collect();
                if !name.is_empty() && name != module {
                    uses.entry(module.clone()).or_default().push(name);
                }
            }
        }
    }
    uses
}

fn rank(module: &str) -> Option<usize> {
    STAGES.iter().position(|s| *s == module)
}

#[test]
fn no_stage_uses_one_above_it() {
    let uses = dependencies();
    assert!(uses.len() > 5, "the sources were read");
    for (module, named) in uses {
        for other in named {
            if BASE.contains(&other.as_str()) {
                continue;
            }
            let allowed = match (rank(&module), rank(&other)) {
                (Some(own), Some(theirs)) => theirs > own,
                // Only what knows the machine may name an extension: the stage it plugs into, and those above.
                (Some(own), None) => EXTENSIONS
                    .iter()
                    .any(|(e, into)| *e == other && rank(into).unwrap() >= own),
                // An extension stands beside the stage that it plugs into: it may name that one and those below.
                (None, theirs) => match EXTENSIONS.iter().find(|(e, _)| *e == module) {
                    Some((_, into)) => theirs >= rank(into),
                    // The board and the settings speak of the stages that they serve.
                    None => {
                        ["board", "settings"].contains(&module.as_str())
                            && ["planner", "shaper", "stepper"].contains(&other.as_str())
                    }
                },
            };
            assert!(allowed, "{module} uses {other}");
        }
    }
}

#[test]
fn only_one_file_names_the_float_library() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src");
    for file in sources(&src) {
        let text = fs::read_to_string(&file).unwrap();
        let named = text.lines().any(|l| {
            !l.trim().starts_with("//") && (l.contains("libm::") || l.contains("micromath"))
        });
        assert_eq!(named, file.ends_with("math.rs"), "{}", file.display());
    }
}

#[test]
fn the_step_interrupt_names_no_float_and_divides_nothing() {
    let stepper = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src/stepper");
    for file in ["interpolator.rs", "port.rs"] {
        let text = fs::read_to_string(stepper.join(file)).unwrap();
        let code: String = text
            .lines()
            .filter(|l| !l.trim().starts_with("//"))
            .collect::<Vec<_>>()
            .join("\n");
        for word in ["f32", "f64", " / ", " % ", "unwrap", "expect(", "panic!"] {
            assert!(!code.contains(word), "{file} has {word:?}");
        }
        assert!(
            code.contains("clippy::float_arithmetic"),
            "{file}: the lint stands in its head"
        );
    }
}
