//! The motion duel as a table: time, limits, distances and ripple of every contest beside its goal, its bound and what
//! other controllers did on the same path.

use super::run::{Outcome, workspace};
use hexstep_host::duel::{
    self, ACCELERATION, Contest, Figures, JERKS, Peer, REVISIONS, Run, STEPS, VELOCITY,
};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;

/// What is run: contests whose names hold `only`, with these steps per mm and this jerk, or all.
#[derive(clap::Args)]
pub struct Request {
    /// Only contests whose name holds this; may be given several times.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Steps per mm; 80 and 1000 when none are given.
    #[arg(long)]
    steps: Vec<f64>,
    /// Jerk [mm/s3]; 20000 and 1e7 when none is given.
    #[arg(long)]
    jerk: Vec<f64>,
}

/// Time that a goal leaves to rounding [s].
const HAIR: f64 = 5e-4;

pub fn task(request: &Request) -> Outcome<()> {
    let wanted = |contest: &Contest| {
        let named = |part: &String| contest.name.contains(part.as_str());
        request.only.is_empty() || request.only.iter().any(named)
    };
    let contests: Vec<Contest> = duel::contests().into_iter().filter(wanted).collect();
    if contests.is_empty() {
        let names: Vec<&str> = duel::contests()
            .iter()
            .map(|contest| contest.name)
            .collect();
        return Err(format!(
            "no contest has such a name; there are {}",
            names.join(", ")
        ));
    }
    let or_all = |given: &[f64], all: [f64; 2]| match given {
        [] => all.to_vec(),
        given => given.to_vec(),
    };
    let (steps, jerks) = (or_all(&request.steps, STEPS), or_all(&request.jerk, JERKS));
    let peers = duel::peers();
    let bar = progress_bar(contests.len() * steps.len() * jerks.len());
    let mut file: BTreeMap<String, f64> = BTreeMap::new();
    let mut missed = Vec::new();
    for jerk in &jerks {
        for steps in &steps {
            let say = |text: String| bar.suspend(|| println!("{text}"));
            say(head(*steps, *jerk));
            for contest in &contests {
                let title = format!("{} {steps} steps/mm, jerk {jerk}", contest.name);
                bar.set_message(title.clone());
                let run = duel::run(contest, *steps, *jerk, &mut |done, all| {
                    bar.set_message(format!("{title}: block {done} of {all}"));
                });
                let run = run.map_err(|error| error.to_string())?;
                let goal = goal(contest, *jerk);
                let is_missed = goal.is_some_and(|goal| run.figures.time > goal + HAIR);
                if is_missed {
                    missed.push(format!("{} {steps} {jerk}", contest.name));
                }
                say(line(
                    contest,
                    &run,
                    (goal, is_missed),
                    *jerk,
                    *steps,
                    &peers,
                ));
                note(&mut file, contest, &run, *steps, *jerk);
                bar.inc(1);
            }
            say(String::new());
        }
    }
    bar.finish_and_clear();
    println!(
        "Limits {VELOCITY} mm/s and {ACCELERATION} mm/s2; v, a, j: the largest of all joints as a share of its limit, through the\n\
         same filter for all (at 80 steps/mm a flawless motion shows up to 1.1 of its jerk). Bounds of contests with six\n\
         joints are their feed and ramps. Others: {REVISIONS}; they have no limit of jerk but for the\n\
         S-curve and grblHAL's jerk, and at 10^7 ours is next to none."
    );
    let folder = workspace().join("target/hexstep");
    let path = folder.join("duel.json");
    let text = serde_json::to_string_pretty(&file).map_err(|error| error.to_string())?;
    std::fs::create_dir_all(&folder)
        .and_then(|()| std::fs::write(&path, text + "\n"))
        .map_err(|error| format!("{}: {error}", path.display()))?;
    println!("written to {}", path.display());
    match missed.is_empty() {
        true => Ok(()),
        false => Err(format!("goals not reached: {}", missed.join(", "))),
    }
}

/// The goal at this jerk, where there is one.
fn goal(contest: &Contest, jerk: f64) -> Option<f64> {
    let place = JERKS.iter().position(|known| *known == jerk)?;
    contest.goals.map(|goals| goals[place])
}

/// Other controllers, as the table heads them.
const PEERS: [(&str, &str); 5] = [
    ("grblHAL-trap", "grblHAL"),
    ("grblHAL-jerk", "its jerk"),
    ("klipper", "Klipper"),
    ("linuxcnc-trap", "LinuxCNC"),
    ("linuxcnc-scurve", "S-curve"),
];

fn head(steps: f64, jerk: f64) -> String {
    let peers = PEERS.map(|(_, head)| format!("{head:>9}")).concat();
    format!(
        "{steps} steps/mm, jerk {jerk} mm/s3; times in s, distances in um, ripple in %\n\
         {:<13}{:>9} {:>8}{:>8} |{peers} |{:>6}{:>6}{:>7} |{:>7}{:>7}{:>8}",
        "contest", "time", "goal", "bound", "v", "a", "j", "aside", "cut", "ripple"
    )
}

fn line(
    contest: &Contest,
    run: &Run,
    (goal, is_missed): (Option<f64>, bool),
    jerk: f64,
    steps: f64,
    peers: &[Peer],
) -> String {
    let f = &run.figures;
    let seconds = |time: Option<f64>| time.map_or("-".into(), |time| format!("{time:.3}"));
    let mark = if is_missed { '!' } else { ' ' };
    let first = jerk == JERKS[0];
    let own = contest.bound.filter(|_| first).map(|(bound, _)| bound);
    let bound = own.unwrap_or(run.bounds.feed);
    let theirs = PEERS.map(|(name, _)| {
        let same = |peer: &&Peer| {
            let there = peer.steps.is_none_or(|their| their == steps);
            peer.contest == contest.name && peer.name == name && there
        };
        format!(
            "{:>9}",
            seconds(peers.iter().find(same).map(|peer| peer.time))
        )
    });
    let share = |of: &[f64; 6], limit: f64| Figures::largest(of) / limit;
    format!(
        "{:<13}{:>9.4}{mark}{:>8}{bound:>8.2} |{} |{:>6.2}{:>6.2}{:>7.2} |{:>7.1}{:>7.1}{:>8}",
        contest.name,
        f.time,
        seconds(goal),
        theirs.concat(),
        share(&f.velocity, VELOCITY),
        share(&f.acceleration, ACCELERATION),
        share(&f.jerk, jerk),
        f.aside * 1e3,
        f.cut * 1e3,
        f.ripple
            .map_or("-".into(), |(ripple, _)| format!("{:.2}", ripple * 100.0)),
    )
}

/// All figures under keys such as `a-circle_80_20000_time`.
fn note(file: &mut BTreeMap<String, f64>, contest: &Contest, run: &Run, steps: f64, jerk: f64) {
    let f = &run.figures;
    let mut set = |figure: &str, value: f64| {
        file.insert(format!("{}_{steps}_{jerk}_{figure}", contest.name), value);
    };
    set("time", f.time);
    set("velocity", Figures::largest(&f.velocity));
    set("acceleration", Figures::largest(&f.acceleration));
    set("jerk", Figures::largest(&f.jerk));
    set("aside_um", f.aside * 1e3);
    set("cut_um", f.cut * 1e3);
    set("apart_um", f.apart * 1e3);
    set("feed_and_ramps", run.bounds.feed);
    set("rest_to_rest", run.bounds.rest);
    if let Some(goal) = goal(contest, jerk) {
        set("goal", goal);
    }
    if let Some((ripple, feed)) = f.ripple {
        set("ripple", ripple);
        set("steady_feed", feed);
    }
}

fn progress_bar(count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64);
    // The template is a constant: it is right or wrong for good.
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    bar
}
