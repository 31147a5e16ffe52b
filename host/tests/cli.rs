//! The velvet command as a person uses it: a configuration checked, a job run, its report read.

mod common;

use common::{folder, said, text, velvet};

const CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/samples/cartesian.ini");

#[test]
fn a_good_configuration_passes_and_a_bad_line_is_named() {
    let good = velvet(&["check", CONFIG]);
    assert!(good.status.success(), "{}", said(&good));
    let bad = folder("check").join("bad.ini");
    let mut lines =
        std::fs::read_to_string(CONFIG).expect("the sample").replace("steps_per_mm = 400", "steps_per_mm = many");
    lines.push('\n');
    let line = 1 + lines.lines().position(|line| line.contains("many")).expect("the sample has this setting");
    std::fs::write(&bad, lines).expect("written");
    let checked = velvet(&["check", text(&bad)]);
    assert_eq!(checked.status.code(), Some(1));
    assert!(said(&checked).contains(&format!("bad.ini:{line}:")), "{}", said(&checked));
    let json = velvet(&["check", "--json", text(&bad)]);
    let findings: serde_json::Value = serde_json::from_slice(&json.stdout).expect("one JSON object");
    assert_eq!((json.status.code(), findings["usable"].as_bool()), (Some(1), Some(false)));
}

#[test]
fn the_exit_code_tells_unusable_from_unreadable() {
    let file = folder("codes").join("warned.ini");
    let warned = std::fs::read_to_string(CONFIG).expect("the sample").replace("must_be_homed", "colour");
    std::fs::write(&file, warned).expect("written");
    let code = |arguments: &[&str]| velvet(arguments).status.code();
    assert_eq!(code(&["check", text(&file)]), Some(0), "a warning is no reason not to start");
    assert_eq!(code(&["check", "--deny-warnings", text(&file)]), Some(1));
    assert_eq!(code(&["check", "/no/such/file"]), Some(2));
    assert!(!said(&velvet(&["check", text(&file)])).contains('\x1b'), "colours are for terminals");
}

#[test]
fn the_json_schema_knows_every_setting_and_its_bounds() {
    let printed = velvet(&["schema"]);
    let schema: serde_json::Value = serde_json::from_slice(&printed.stdout).expect("one JSON object");
    let sections = schema["properties"].as_object().expect("sections");
    assert_eq!(sections.len(), config::schema::SECTIONS.len());
    for section in config::schema::SECTIONS {
        let object = &sections[section.name];
        let of_instances = object["patternProperties"].as_object().and_then(|patterns| patterns.values().next());
        for row in section.settings {
            let home = match (section.form, row.is_common) {
                (config::schema::Form::Plain, _) => &object["properties"][row.key],
                (config::schema::Form::Keyed(_), _) => of_instances.expect("a pattern"),
                (config::schema::Form::Named(_), true) => &object["properties"]["common"]["properties"][row.key],
                (config::schema::Form::Named(_), false) => &of_instances.expect("a pattern")["properties"][row.key],
            };
            assert_eq!(home["description"].as_str(), Some(row.docs.summary), "[{}] {}", section.name, row.key);
        }
    }
    let queue = &sections["planner"]["properties"]["planner_queue_size"];
    assert_eq!(
        (queue["minimum"].as_i64(), queue["maximum"].as_i64(), queue["default"].as_i64()),
        (Some(1), Some(65_535), Some(32))
    );
}

#[test]
fn a_v1_config_is_migrated_into_one_that_the_check_passes() {
    let new = folder("migrate").join("config.ini");
    let old = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/v1/printer.config");
    let migrated = velvet(&["migrate", old, "--out", text(&new)]);
    assert!(migrated.status.success() && said(&migrated).contains("to do: "), "{}", said(&migrated));
    assert_eq!(velvet(&["check", "--deny-warnings", text(&new)]).status.code(), Some(0));
    assert_eq!(velvet(&["migrate", "/no/such/file"]).status.code(), Some(2));
}

#[test]
fn a_job_runs_natively_and_its_report_finds_nothing_wrong() {
    let out = folder("run");
    let job = out.join("square.gcode");
    std::fs::write(&job, "; Square\nG28\nG1 X20 Y20 Z1 F6000\nM83\nG1 X40 E1\nG1 Y40 E1\nG1 X20 E1\nG1 Y20 E1\nM84\n")
        .expect("written");
    let ran = velvet(&["run", "--config", CONFIG, "--gcode", text(&job), "--out", text(&out), "--until", "120"]);
    assert!(ran.status.success(), "{}", said(&ran));
    let summary = velvet(&["summary", text(&out)]);
    assert!(summary.status.success(), "{}", said(&summary));
    let text_of_summary = said(&summary);
    for begins in [
        "Square: ",
        "  pass  X, Y and Z end",
        "  pass  Filament moved",
        "  pass  The executed path",
        "  time  print moves ",
        "  layers  1, ",
        "  planner  starved: none seen; the planner counted 0",
    ] {
        assert!(text_of_summary.lines().any(|line| line.starts_with(begins)), "{begins}: {text_of_summary}");
    }
    let report = velvet(&["report", text(&out)]);
    assert!(report.status.success() && out.join("report.html").is_file(), "{}", said(&report));
    assert!(said(&velvet(&["plot", text(&out), "--of", "speed"])).contains("tool mm/s"));
}

#[test]
fn a_job_that_fails_says_why_and_exits_1() {
    let out = folder("fault");
    let job = out.join("heat.gcode");
    std::fs::write(&job, "M109 S200\nG4 S5\n").expect("written");
    let ran = velvet(&[
        "run",
        "--config",
        CONFIG,
        "--gcode",
        text(&job),
        "--out",
        text(&out),
        "--until",
        "60",
        "--fault",
        "thermistor-open:hotend@5",
    ]);
    assert_eq!(ran.status.code(), Some(1));
    let last = said(&ran).lines().last().unwrap_or_default().to_owned();
    assert!(last.starts_with("halted: "), "{}", said(&ran));
    assert_eq!(velvet(&["summary", text(&out)]).status.code(), Some(1));
}

#[test]
fn what_is_not_there_is_named() {
    let report = velvet(&["report", "/no/such/run"]);
    assert!(!report.status.success() && said(&report).contains("/no/such/run"), "{}", said(&report));
    let fault = velvet(&["run", "--config", CONFIG, "--gcode", "x", "--out", "y", "--fault", "gremlin"]);
    assert!(said(&fault).contains("gremlin"), "{}", said(&fault));
}

#[test]
fn a_delta_s_path_is_drawn_from_its_towers_and_its_edges_are_held_against_the_oracle() {
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/samples/delta.ini");
    let out = folder("delta");
    let job = out.join("job.gcode");
    let lines =
        "M302 S0\nG28\nG92 E0\nM83\nG1 Z10 F12000\nG1 X50 Y-30 E1 F6000\nG3 X-50 Y30 I-50 J30 E1\nG1 X0 Y85 Z12\n";
    std::fs::write(&job, lines).expect("written");
    let sources = ["--config", config, "--gcode", text(&job)];
    let with = |first: &[&str]| velvet(&[first, &sources[..]].concat());
    let ran = with(&["run", "--out", text(&out)]);
    assert!(ran.status.success(), "{}", said(&ran));
    let verified = with(&["verify", text(&out)]);
    assert!(verified.status.success(), "{}", said(&verified));
    let summary = with(&["summary", text(&out)]);
    let found = said(&summary);
    assert!(summary.status.success(), "{found}");
    for check in ["pass  X, Y and Z end", "pass  The executed path follows", "pass  No step edge is later"] {
        assert!(found.contains(check), "no `{check}` in {found}");
    }
    // An edge that a board left out is an error of the run from then on.
    let edges = std::fs::read_to_string(out.join("steps.csv")).expect("edges");
    let short: Vec<&str> = edges.lines().take(edges.lines().count() - 1).collect();
    std::fs::write(out.join("steps.csv"), short.join("\n")).expect("written");
    let refused = with(&["verify", text(&out)]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(said(&refused).trim_end().lines().last().is_some_and(|line| line.contains("end 1 steps before motion")));
    let json = std::fs::read_to_string(out.join("summary.json")).expect("a summary");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert!(json["errors"][0].as_str().is_some_and(|error| error.contains("end 1 steps")), "{json}");
}

#[test]
fn a_bed_is_told_about_and_drawn() {
    let folder = folder("bed");
    let (mesh, page) = (folder.join("pei.mesh"), folder.join("bed.html"));
    std::fs::write(&mesh, "mesh 1\npoints 3 3\norigin 0 0\nstep 80 60\nheights\n0 .1 0 .1 .3 .1 0 .1 0\n")
        .expect("written");
    let told = velvet(&["bed", text(&mesh), "--config", CONFIG, "--page", text(&page)]);
    assert!(told.status.success(), "{}", said(&told));
    assert!(said(&told).contains("the bed is domed by 0.267") && said(&told).contains('@'), "{}", said(&told));
    let page = std::fs::read_to_string(&page).expect("the page was written");
    assert!(page.contains("the bed is domed by 0.267") && page.contains("<canvas"));
    std::fs::write(&mesh, "mesh 1\npoints 3 3\nG28\n").expect("written");
    let wrong = velvet(&["bed", text(&mesh)]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(said(&wrong).contains("pei.mesh is no mesh: line 3: "), "{}", said(&wrong));
}

#[test]
fn a_job_is_looked_through_for_the_machine_as_it_has_saved_itself() {
    let folder = folder("preflight");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).expect("written");
        folder.join(name)
    };
    let job = write("job.gcode", "G28\nM104 S200\nO<wall> call [215]\nM109 S210\n");
    write("wall.ngc", "o<wall> sub\nG1 X[#1] Z4 F6000\no<wall> endsub\n");
    let plain = velvet(&["preflight", CONFIG, text(&job)]);
    assert!(plain.status.success() && said(&plain).contains("heating, whose time is not foreseen: 1 wait: hotend 1x"));
    let saved = write("saved", "M203 Z1\nG10 L2 P1 X20\n");
    let out = velvet(&["preflight", CONFIG, text(&job), "--saved", text(&saved), "--json"]);
    assert_eq!(out.status.code(), Some(1), "{}", said(&out));
    let json: serde_json::Value = serde_json::from_str(&said(&out)).expect("JSON");
    assert_eq!((&json["findings"][0]["file"], &json["findings"][0]["line"]), (&"wall.ngc".into(), &2.into()), "{json}");
    let saved = write("saved", "M203 Z1\n");
    let out = velvet(&["preflight", CONFIG, text(&job), "--saved", text(&saved), "--json"]);
    let json: serde_json::Value = serde_json::from_str(&said(&out)).expect("JSON");
    assert!(json["limits"]["z_axis_max_speed"].as_f64().is_some_and(|cost| cost > 0.5), "{json}");
    assert_eq!(json["heating"]["hotend"]["most_c"], 210.0);
    // A finding about saved settings names its place and its fix.
    let saved = write("saved", "M203 Z1\nM375\n");
    let out = velvet(&["preflight", CONFIG, text(&job), "--saved", text(&saved)]);
    assert_eq!(out.status.code(), Some(2), "{}", said(&out));
    assert!(said(&out).contains("saved, line 2: the machine loads a mesh: give it with --mesh"), "{}", said(&out));
    let saved = write("saved", "M203 Z1\n\u{1}\u{2}G1 X1.2.3\n");
    let out = velvet(&["preflight", CONFIG, text(&job), "--saved", text(&saved)]);
    assert!(said(&out).contains("saved, line 2: ") && said(&out).contains("give what M500 wrote"), "{}", said(&out));
    let mesh = write("bed.mesh", "mesh 1\npoints 3 x\n");
    let out = velvet(&["preflight", CONFIG, text(&job), "--mesh", text(&mesh)]);
    assert!(said(&out).contains("bed.mesh is no mesh: line 2: a number was expected"), "{}", said(&out));
}

#[test]
fn actions_are_those_of_the_dialect_that_a_file_says() {
    let part = folder("actions").join("part.g");
    // Q is no word of G1: a mill's program is refused for it, a print goes on.
    let lines = "G1 X80 Q3 F6000\nM82\nG1 X90 E5\nM9999\nM106 S100 G1 X95\n";
    std::fs::write(&part, format!(";FLAVOR:Marlin\n{lines}")).expect("written");
    let marlins = velvet(&["actions", text(&part)]);
    assert!(marlins.status.success(), "{}", said(&marlins));
    let said_of_it = said(&marlins);
    assert!(said_of_it.contains("feed 80.00000") && said_of_it.contains("feed 95.00000"), "{said_of_it}");
    assert!(said_of_it.contains("left out M9999"), "{said_of_it}");
    // Where a job waits and preflight says that it will (`machine/tests/unknown_words.rs`),
    // the list ends here, by the same words.
    for (flavour, line, told) in [
        ("; gcode_flavor = reprapfirmware", "G1 R1 X0 Y0", "G1 takes no R here"),
        ("; gcode_flavor = reprapfirmware", "G1 X50 H1", "G1 takes no H here"),
        (";FLAVOR:Marlin", "G61 X Y F6000", "G61 is not carried out here"),
        (";FLAVOR:Marlin", "G90 X5", "G90 takes no X here"),
    ] {
        std::fs::write(&part, format!("{flavour}\nG1 X20 Y20 F6000\n{line}\nG1 X30\n")).expect("written");
        let ended = velvet(&["actions", text(&part)]);
        assert!(!ended.status.success() && said(&ended).contains(told), "{line}: {}", said(&ended));
        assert!(!said(&ended).contains("feed 30"), "{line}: what is behind it counts on it");
    }
    std::fs::write(&part, lines).expect("written");
    let mills = velvet(&["actions", text(&part)]);
    assert!(!mills.status.success() && said(&mills).contains("line 1"), "{}", said(&mills));
}
