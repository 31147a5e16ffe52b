//! Preflight checks of data beside a job: the machine's saved settings, its mesh, files of subroutines.

use std::string::ToString;

use motion::{GridShape, Motion};
use preflight::{Preflight, dialect_of, read};
use scenarios::{CARTESIAN, DELTA, Plan};

use super::{Found, Subs, machine_config, preflight_beside, told, with};

/// Returns the preflight report for a job on a machine with these settings and this mesh.
fn as_saved(config: &str, saved: &str, mesh: Option<(&GridShape, &[f32])>, text: &str) -> String {
    let machine = machine_config(config);
    let (mut motion, mut program, mut found) = (Box::new(Motion::new()), None, Found::default());
    let texts = base::failure::Texts::new();
    let mut preflight =
        Preflight::new(&texts, &machine, dialect_of(text.as_bytes()), &mut program, &mut motion).unwrap();
    let loads_mesh = preflight.load_settings(saved.as_bytes(), &mut motion, &mut found);
    assert!(found.0.is_empty() && loads_mesh.is_some() == saved.contains("M375"), "{:?}", found.0);
    if let Some((shape, heights)) = mesh {
        preflight.load_mesh(shape, heights, true, &mut motion).expect("it fits");
    }
    read(&mut preflight, text.as_bytes(), &|_| None, &mut motion, &mut found).unwrap();
    let found: String = found.0.iter().map(|finding| format!("{finding}\n")).collect();
    found + &told(config, preflight.totals()) + "ok\n"
}

#[test]
fn saved_settings_and_mesh_count_on_the_desk_as_on_the_board() {
    let job = "G28\nM104 S240\nG1 X215 Y10 Z1 F12000\nG1 X-4 Z30\nG1 Y200 Z1\nG54 G1 X210\n";
    let shape = GridShape { origin: [0.0; 2], step: [100.0; 2], count: [3, 3] };
    let heights = [0.0, 0.9, -0.4, 0.3, -0.7, 0.8, -0.2, 0.5, 0.1_f32];
    let words: Vec<_> = heights.iter().map(f32::to_string).collect();
    let mesh = format!("mesh 1\npoints 3 3\norigin 0 0\nstep 100 100\nheights\n{}\n", words.join(" "));
    let on = |config: &str| {
        let level = "[zprobe] leveling = cartesian grid";
        let saves = with(&with(config, "[general] config-override = true"), level);
        let size = with(&saves, "[cartesian grid leveling strategy] x_size = 200");
        let size = with(&size, "[cartesian grid leveling strategy] y_size = 200");
        with(&size, "[cartesian grid leveling strategy] save = true")
    };
    let codes = ["M204 S900 X700", "M203 X90 Z3", "M206 X-5", "M143 S0 P230", "G10 L2 P1 X12", "M92 X90", "M205 X0.1"];
    let skew = ["M852 I0.02", "M376 H8", "M375 P\"bed\""];
    for (name, config, codes, has_mesh) in [
        ("cartesian", on(CARTESIAN), codes.to_vec(), false),
        ("with a mesh", on(CARTESIAN), [&codes[..], &skew].concat(), true),
        ("delta", with(DELTA, "[general] config-override = true"), vec!["M665 L260 Z240", "M666 X-1"], false),
    ] {
        let plan = || Plan::new(&config).file("bed.mesh", &mesh).file("job.g", job);
        let mut bench = plan().start();
        for code in codes.iter().chain(&["M500"]) {
            assert!(bench.say(code).ends_with("ok\n"), "{code}");
        }
        let saved = bench.read_card("config-override").expect("it was saved");
        let plain = plan().start().say("check /sd/job.g");
        let mut again = plan().file("config-override", &saved).start();
        let _ = again.hear(1.0);
        let board = again.say("check /sd/job.g");
        let mesh = has_mesh.then_some((&shape, &heights[..]));
        assert_eq!(as_saved(&config, &saved, mesh, job), board, "{name}:\n{saved}");
        assert_ne!(plain, board, "{name}: it makes a difference");
    }
}

// --- subroutines beside the job ---

const CALLS: &str = "G28\nG1 X10 Y10 Z1 F6000\nO<side> call [40]\nM98 P77\nO<twice> call\n";
const SUBS: &Subs = &[
    ("side", "o<side> sub\nG1 X[#1] F6000\nG1 X10\nM7777\no<side> endsub\n"),
    ("77", "O77\nG1 Y20 F3000\nG1 Y999\nG1 Y10\nM99\n"),
    ("twice", "o<twice> sub\nO<side> call [50]\nG1 X777\no<twice> endsub\n"),
];

#[test]
fn subroutines_in_files_beside_the_job_are_followed() {
    let (found, totals) = preflight_beside(CARTESIAN, CALLS, SUBS);
    let lines: Vec<_> = found.iter().map(|finding| (finding.sub.as_deref(), finding.line)).collect();
    assert_eq!(lines, [(Some("side"), 4), (Some("77"), 3), (Some("side"), 4), (Some("twice"), 3)], "{found:?}");
    assert_eq!(found[1].to_string().split_once(" machine").unwrap().0, "77.ngc, line 3: stops:");
    let mut plan = Plan::new(CARTESIAN).file("job.g", CALLS);
    for (name, text) in SUBS {
        plan = plan.file(&format!("{name}.ngc"), text);
    }
    let heard = plan.start().say("check /sd/job.g");
    let desk: String = found.iter().map(|finding| format!("{finding}\n")).collect();
    assert_eq!(heard, desk + &told(CARTESIAN, &totals) + "ok\n");
}

#[test]
fn the_time_in_subroutines_is_that_of_the_job() {
    let job = "G90\nG1 X10 Y10 Z1 F6000\nO<side> call [40]\nM98 P78 L30\nO<side> call [60]\n";
    let subs: &Subs = &[SUBS[0], ("78", "O78\nG1 Y20 F3000\nG1 Y10\nM99\n")];
    let (_, totals) = preflight_beside(CARTESIAN, &format!("G28\n{job}"), subs);
    let mut plan = Plan::new(CARTESIAN).file("job.g", job);
    for (name, text) in subs {
        plan = plan.file(&format!("{name}.ngc"), text);
    }
    let mut bench = plan.start();
    bench.run(&["G28"]);
    bench.type_in("play /sd/job.g -t\n");
    let begun = bench.now_s();
    bench.hear_until("Done printing file", 100.0);
    let (made, foreseen) = (bench.now_s() - begun, totals.seconds() - totals.homing_seconds);
    assert!(made > 3.0 && (made - foreseen).abs() < 0.01 * made, "{made} {foreseen}");
}
