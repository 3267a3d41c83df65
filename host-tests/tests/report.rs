//! Figures and tables -> a page: whole, safe, small, and true to the numbers it draws.

use hexstep_host::plot::{Chart, Drawing, PALETTE, Pen, Waves, number};
use hexstep_host::report::{Cell, Report};

/// Every tag that is opened is closed in order.
#[track_caller]
fn assert_balanced(markup: &str) {
    let mut open: Vec<&str> = Vec::new();
    for piece in markup.split('<').skip(1) {
        let tag = piece.split('>').next().expect("a tag ends");
        let name = tag
            .trim_start_matches('/')
            .split(' ')
            .next()
            .expect("a name");
        if tag.starts_with('!') || ["meta", "br"].contains(&name) || tag.ends_with('/') {
            continue;
        }
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "near {piece:.60}");
        } else {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

/// The points of the paths of an SVG in one colour.
fn points_of(svg: &str, colour: &str) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    for path in svg.split("<path d=\"").skip(1) {
        if !path.contains(colour) {
            continue;
        }
        let data = path.split('"').next().expect("data");
        for pair in data.split(['M', 'L']).filter(|pair| !pair.is_empty()) {
            let (x, y) = pair.trim_end_matches('Z').split_once(' ').expect("a pair");
            points.push((x.parse().expect("x"), y.parse().expect("y")));
        }
    }
    points
}

fn sample_page() -> String {
    let wave =
        |phase: f64| (0..2000).map(move |k| (k as f64 * 0.01, (k as f64 * 0.01 + phase).sin()));
    let chart = Chart::new("Two waves <&>", "time [s]", "height [mm]")
        .line("sine", PALETTE[0], wave(0.0))
        .line("shifted", PALETTE[1], wave(1.0))
        .limit("limit 1.2", 1.2)
        .svg();
    let waves = Waves::new("Pulses", "time [µs]", 0.0, 100.0)
        .lane(
            "step d1",
            PALETTE[0],
            false,
            (1..20).map(|k| (k as f64 * 5.0, k % 2 == 1)),
        )
        .lane("dir d1", PALETTE[0], true, [(40.0, false)])
        .svg();
    let drawing = Drawing::new("Corner", 400.0)
        .line(
            [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (0.0, 0.0)],
            Pen::EDGE,
        )
        .circle((5.0, 2.0), 1.0, Pen::THIN)
        .angle((0.0, 0.0), 6.0, 0.0, 0.4636, "26.57°")
        .dimension((0.0, -1.0), (10.0, -1.0), "10.00")
        .svg();
    let mut report = Report::new("A page", "About nothing < much.");
    report.summary(&[("Motors", "6".into()), ("Ticks", Cell::Number("12".into()))]);
    report.section("Figures");
    report.figure(&chart, "Two waves & a limit.");
    report.figures(&[(waves, "Pulses."), (drawing, "A corner.")]);
    report.section("Tables");
    report.table(
        "Counts",
        &["motor", "steps", "rate"],
        &[
            vec![
                "d1".into(),
                Cell::Number("7".into()),
                Cell::Judged("9".into(), true),
            ],
            vec![
                "d2".into(),
                Cell::Number("8".into()),
                Cell::Judged("11".into(), false),
            ],
        ],
    );
    report.html()
}

#[test]
fn the_page_is_whole_and_closes_every_tag() {
    let page = sample_page();

    assert!(page.starts_with("<!doctype html>"));
    assert!(page.trim_end().ends_with("</html>"));
    assert_balanced(&page);
    assert_eq!(page.matches("<svg").count(), 3);
    assert_eq!(page.matches("<figcaption>").count(), 3);
    if let Ok(path) = std::env::var("HEXSTEP_SAMPLE_PAGE") {
        std::fs::write(path, page).expect("written");
    }
}

#[test]
fn the_page_fetches_nothing_and_runs_nothing() {
    let page = sample_page();

    for foreign in [
        "<script", "<link", "<img", "src=", "href=", "@import", "url(",
    ] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    // The only address is the name of the SVG dialect, which is not fetched.
    let addresses = page.matches("http").count();
    assert_eq!(
        addresses,
        page.matches("http://www.w3.org/2000/svg").count()
    );
}

#[test]
fn text_cannot_break_out_of_the_page() {
    let mut report = Report::new("<b>", "\"&\"");
    report.section("</section>");
    report.text("<script>alert(1)</script>");
    report.table("<i>", &["<u>"], &[vec!["<s>".into()]]);

    let page = report.html();

    assert!(!page.contains("<script") && !page.contains("<b>") && !page.contains("<s>"));
    assert_balanced(&page);
}

#[test]
fn a_line_of_a_million_points_stays_small_and_keeps_its_peak() {
    let spike = 654_321;
    let chart = |spike_height: f64| {
        Chart::new("spike", "x", "y")
            .y_range(-1.0, 2.0)
            .line(
                "s",
                PALETTE[2],
                (0..1_000_000).map(|k| {
                    (
                        k as f64,
                        if k == spike {
                            spike_height
                        } else {
                            (k as f64 * 0.7).sin()
                        },
                    )
                }),
            )
            .svg()
    };

    let svg = chart(1.9);

    assert!(svg.len() < 60_000, "{} bytes", svg.len());
    let top = |svg: &str| {
        points_of(svg, PALETTE[2])
            .into_iter()
            .map(|p| p.1)
            .fold(f64::INFINITY, f64::min)
    };
    // 1.9 of -1 .. 2 over 190 px from y = 30: 6.3 px below the top.
    assert!((top(&svg) - 36.3).abs() < 0.2, "{}", top(&svg));
    assert!(top(&chart(0.0)) > 90.0);
}

#[test]
fn a_chart_of_nothing_or_of_one_value_is_still_a_chart() {
    for svg in [
        Chart::new("empty", "x", "y").svg(),
        Chart::new("one", "x", "y")
            .line("a", PALETTE[0], [(1.0, 5.0)])
            .svg(),
        Chart::new("level", "x", "y")
            .line("a", PALETTE[0], (0..9).map(|k| (k as f64, 0.0)))
            .svg(),
        Chart::new("holes", "x", "y")
            .line(
                "a",
                PALETTE[0],
                [
                    (0.0, f64::NAN),
                    (1.0, 1.0),
                    (f64::NAN, 2.0),
                    (3.0, f64::INFINITY),
                ],
            )
            .svg(),
        Drawing::new("empty", 300.0).svg(),
        Waves::new("empty", "t", 0.0, 1.0).svg(),
    ] {
        assert_balanced(&svg);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}

#[test]
fn a_drawing_has_one_scale() {
    let svg = Drawing::new("square", 300.0)
        .line(
            [(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (0.0, 1.0)],
            Pen {
                colour: "#123456",
                ..Pen::EDGE
            },
        )
        .svg();

    let points = points_of(&svg, "#123456");
    let wide = points[1].0 - points[0].0;
    let high = points[1].1 - points[2].1;

    assert!((wide - 4.0 * high).abs() < 0.5, "{wide} by {high}");
}

#[test]
fn numbers_read_as_people_write_them() {
    assert_eq!(number(1234567.0, 0), "1\u{202f}234\u{202f}567");
    assert_eq!(number(-0.5, 2), "\u{2212}0.50");
    assert_eq!(number(-0.0001, 2), "0.00");
    assert_eq!(number(1234.5, 1), "1234.5");
}
