//! Several jobs one after the other, and the page that shows them.

use crate::common::Folder;
use hexstep_host::cli::run::{BAD_INPUT, DELIVERED, Delivered, Request, SOUND, run_each};
use hexstep_host::job::Job;

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
fn every_delivered_job_is_right_and_its_first_sentence_names_the_figure_or_table_it_stands_for() {
    for job in DELIVERED {
        let parsed = Job::parse(job.file, job.name, job.text.as_bytes());
        let about = job.about();

        assert!(parsed.is_ok(), "{}: {:?}", job.name, parsed.err());
        assert!((40..=110).contains(&about.len()), "{}: {about}", job.name);
        assert!(about.contains("'s paper"), "{}: {about}", job.name);
    }
    // By the papers: drill grinding, gasbag polishing, surface grinding, five-axis rotary motion, mirror milling, input shaping.
    for (name, stands_for) in [
        ("drill-point", "figure 3 of Li and Chen's"),
        ("counts", "figure 1 of Li and Chen's"),
        ("stop-to-stop", "figure 1 of Li and Chen's"),
        ("circle", "figure 1 of Li and Chen's"),
        ("trochoid", "figure 5 (a) of Ji's"),
        ("flexible", "three impulses of Singer and Seering's"),
        ("precession-plane", "figures 5 (a) and (b) of Ji's"),
        ("precession-curved", "figures 5 (c) and (d) of Ji's"),
        ("arm-path", "figure 6 and table 2 of Zhan's"),
        ("dune-hard", "table 1, figures 8 and 9 of Zhan's"),
        ("dune-soft", "figure 9 of Zhan's"),
        ("shell-soft", "figure 9 of Zhan's"),
        (
            "frustum",
            "figure 4 and the part of figures 5 and 6 of Duan's",
        ),
        ("pole-crossing", "figure 1 of Duan's"),
        ("two-sided", "figure 4 of Liu's"),
        ("mirror-panel", "tables 2 and 3 of Liu's"),
        ("mirror-skin", "tables 2 and 3 of Liu's"),
        ("mirror-bias", "table 2 of Liu's"),
    ] {
        let about = delivered(name).about();
        assert!(about.contains(stands_for), "{name}: {about}");
    }
    assert_eq!(DELIVERED.len(), 18);
}

#[test]
fn a_full_stop_within_an_abbreviation_or_a_number_does_not_end_the_line_of_a_job() {
    let job = Delivered {
        name: "some",
        file: "some.toml",
        text: "# A wall of 1.5 mm, Fig. 5\n# of a paper. Lengths in mm.\nkind = \"mirror\"\n",
    };
    assert_eq!(job.about(), "A wall of 1.5 mm, Fig. 5 of a paper");
}
