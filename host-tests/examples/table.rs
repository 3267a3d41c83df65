use hexstep::cycles::surface_grinding::{Depth, Model};
use hexstep_host::surface::*;
use std::time::Instant;
fn main() {
    let stations: usize = std::env::args()
        .nth(1)
        .and_then(|s| s.parse().ok())
        .unwrap_or(60);
    let filter = std::env::args().nth(2).unwrap_or_default();
    let part = dune().unwrap();
    let a = Job::hard();
    let b = Job::soft();
    let mut list = vec![];
    for (n, j, iso1, iso2, cd) in [("A", a, 468, 540, 0.08), ("B", b, 103, 118, 0.10)] {
        list.push((format!("{n} adaptive"), j));
        list.push((
            format!("{n} adaptive 401"),
            Job {
                nodes: 401,
                e_gap: 0.0005,
                ..j
            },
        ));
        list.push((
            format!("{n} rowmin"),
            Job {
                strategy: Strategy::RowMin,
                ..j
            },
        ));
        list.push((
            format!("{n} iso"),
            Job {
                strategy: Strategy::Iso(iso1),
                ..j
            },
        ));
        list.push((
            format!("{n} iso2"),
            Job {
                strategy: Strategy::Iso(iso2),
                ..j
            },
        ));
        let mut c = j;
        c.process.depth = Depth::Constant(cd);
        list.push((format!("{n} depth"), c));
        let mut c = j;
        c.process.model = Model::Additive;
        list.push((format!("{n} additive"), c));
        list.push((
            format!("{n} rowmode"),
            Job {
                step_mode: StepMode::Row,
                ..j
            },
        ));
        if n == "B" {
            list.push((format!("{n} egap6"), Job { e_gap: 0.006, ..j }));
            for s in [0.3, 0.7, 0.0, 1.0] {
                list.push((format!("{n} seed{s}"), Job { seed: s, ..j }));
            }
        }
    }
    for (n, j) in list {
        if !n.starts_with(&filter) {
            continue;
        }
        let t0 = Instant::now();
        let g = j.check().unwrap();
        let rows = match Rows::plan(&part, &j, &g) {
            Ok(r) => r,
            Err(e) => {
                println!("{n}: {} {e}", e.name());
                continue;
            }
        };
        let t1 = Instant::now();
        let plan = Plan::of_rows(&part, &j, &rows).unwrap();
        let t2 = Instant::now();
        let path: Vec<PathRow> = plan
            .segments
            .iter()
            .map(|s| PathRow::Uv(s.points.iter().map(|p| p.uv).collect()))
            .collect();
        let r = residual(&part, &j, &path, stations).unwrap();
        let t3 = Instant::now();
        println!(
            "{n}: rows {} ({}) seg {} pts {} len {:.2} | {:.2} {:.2} mean {:.3} ratio {:.3} edge {:?} p01 {:.2} p99 {:.2} pv {:.2} {:.2} {:.3} depth {:.4} {:.4} n {} at {:?} {:?} | {:?} {:?} {:?}",
            plan.rows,
            plan.full_rows,
            plan.segments.len(),
            plan.points(),
            plan.path_length() / 1e3,
            r.min * 1e3,
            r.max * 1e3,
            r.mean * 1e3,
            r.ratio(),
            r.edge_max,
            r.p01 * 1e3,
            r.p99 * 1e3,
            r.peak_to_valley[0] * 1e3,
            r.peak_to_valley[1] * 1e3,
            r.peak_to_valley[1] / r.peak_to_valley[0],
            r.depth_min,
            r.depth_max,
            r.samples,
            r.at_min,
            r.at_max,
            t1 - t0,
            t2 - t1,
            t3 - t2
        );
        if n == "A adaptive" || n == "B adaptive" {
            let mx = |f: &dyn Fn(&hexstep_host::surface::Row, usize) -> f64| {
                rows.rows
                    .iter()
                    .flat_map(|r| {
                        (0..r.kept.len())
                            .filter(|i| r.kept[*i])
                            .map(|i| f(r, i))
                            .collect::<Vec<_>>()
                    })
                    .fold(0f64, f64::max)
            };
            println!(
                "  slope {} bend {}",
                mx(&|r, i| r.curve.at_node(i).slope.abs()),
                mx(&|r, i| r.curve.at_node(i).bend.abs())
            );
            for num in [1i64, 30, -30, 10] {
                if let Some(r) = rows.rows.iter().find(|r| r.number == num) {
                    println!(
                        "  n {num}: {:?}",
                        [0, 50, 100, 150, 200].map(|i| r.curve.values()[i])
                    );
                }
            }
        }
    }
}
