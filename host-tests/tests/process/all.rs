//! Several jobs one after the other, and the page that shows them.

use hexstep_host::cli::run::{BAD_INPUT, DELIVERED, Delivered, Request, SOUND, run_each};
use hexstep_host::job::Job;
use std::path::PathBuf;

/// A folder of its own for one test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("hexstep-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("made");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn delivered(name: &str) -> Delivered {
    let job = DELIVERED.iter().find(|job| job.name == name);
    let Delivered { name, file, text } = job.expect("delivered");
    Delivered { name, file, text }
}

#[test]
fn a_page_has_a_card_with_link_and_picture_for_every_job() {
    let folder = Folder::new("all");
    let request = Request {
        out: Some(folder.0.clone()),
        ..Request::default()
    };

    let status = run_each(&request, &[delivered("counts"), delivered("mirror-skin")]);

    assert_eq!(status, SOUND);
    let page = std::fs::read_to_string(folder.0.join("index.html")).expect("written");
    assert_eq!(page.matches("class=\"card\"").count(), 2);
    assert_eq!(page.matches("as it should be").count(), 2);
    assert_eq!(page.matches("<svg").count(), 2);
    for name in ["counts", "mirror-skin"] {
        assert!(page.contains(&format!("href=\"{name}/report.html\"")));
        assert!(folder.0.join(name).join("report.html").is_file());
        assert!(!folder.0.join(name).join("trace.vcd").exists());
    }
}

#[test]
fn a_job_that_is_refused_has_a_card_and_a_status_of_its_own_and_the_others_run() {
    let folder = Folder::new("refused");
    let request = Request {
        out: Some(folder.0.clone()),
        ..Request::default()
    };
    let broken = Delivered {
        name: "broken",
        file: "nowhere/broken.toml",
        text: "# A job with a fault.\nkind = \"mirror\"\n[simulation]\nd = -1\n",
    };

    let status = run_each(&request, &[broken, delivered("counts")]);

    assert_eq!(status, BAD_INPUT);
    let page = std::fs::read_to_string(folder.0.join("index.html")).expect("written");
    assert!(
        page.contains("nowhere/broken.toml:4:5: simulation.d: BadWall"),
        "{page}"
    );
    assert!(page.contains("href=\"counts/report.html\"") && page.contains("1 of 2"));
    assert!(!folder.0.join("broken").exists());
}

#[test]
fn every_delivered_job_is_right_and_says_what_it_stands_for() {
    for job in DELIVERED {
        let parsed = Job::parse(job.file, job.name, job.text.as_bytes());

        assert!(parsed.is_ok(), "{}: {:?}", job.name, parsed.err());
        assert!(job.about().len() > 40, "{}", job.about());
    }
    for (name, stands_for) in [
        ("dune-hard", "residual figure"),
        ("dune-soft", "residual figure"),
        ("precession-plane", "figure 5"),
        ("precession-curved", "figure 5"),
        ("mirror-panel", "tables"),
    ] {
        let head: String = delivered(name)
            .text
            .lines()
            .take(4)
            .collect::<Vec<_>>()
            .join(" ");
        assert!(head.replace("\n# ", " ").contains(stands_for), "{head}");
    }
}
