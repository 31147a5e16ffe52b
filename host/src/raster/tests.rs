//! Pictures there and back: what is written is read again by [`burnt`], which knows the text alone.

use super::*;
use burnt::Pass;
use clap::Parser;
use proptest::prelude::*;

const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/samples/laser.ini");
/// Half of the last digit of a place, mm, and what its halves may add up to in a sum.
const ROUNDING: f64 = 1e-4;

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn options(arguments: &str) -> Options {
    let all = ["velvet", "picture.png"].into_iter().chain(arguments.split_whitespace());
    Cli::try_parse_from(all).expect("options").options
}

/// A grey ramp with a white margin.
fn ramp() -> Picture {
    let light = (0..40 * 30).map(|index| {
        let (x, y) = (index % 40, index / 40);
        let is_margin = !(5..35).contains(&x) || !(5..25).contains(&y);
        if is_margin { 1.0 } else { (x - 5) as f32 / 30.0 }
    });
    Picture { columns: 40, rows: 30, light: light.collect() }
}

fn made(arguments: &str) -> Result<Raster> {
    Raster::new(&options(arguments), ramp(), "picture.png")
}

fn why(arguments: &str) -> String {
    made(arguments).map_or_else(|error| format!("{error:#}"), |_| "it was made".to_owned())
}

/// Any levels, in runs as pictures have them: from single pixels, of which a row has lines of its own, to
/// whole rows.
fn any_levels() -> impl Strategy<Value = Levels> {
    let count = prop_oneof![Just(2_u16), Just(3), 2..=256_u16];
    let sizes = (1..150_usize, 1..10_usize, count, prop_oneof![Just(1_usize), Just(3), Just(300)]);
    sizes.prop_flat_map(|(columns, rows, count, longest)| {
        let run = (prop_oneof![Just(0), Just(1), 0..count], 1..=longest);
        proptest::collection::vec(run, columns * rows).prop_map(move |runs| {
            let all = runs.into_iter().flat_map(|(level, length)| std::iter::repeat_n(level as u8, length));
            Levels { columns, rows, count, of: all.take(columns * rows).collect() }
        })
    })
}

fn any_layout() -> impl Strategy<Value = Layout> {
    let numbers = (0.01..2.0_f64, -50.0..300.0_f64, -50.0..300.0_f64, -1.0..1.0_f64, 1.0..60.0_f64);
    (numbers, any::<[bool; 2]>()).prop_map(|((pixel, x, y, reverse_offset, lead), [is_x, both_directions])| Layout {
        pixel,
        at: [x, y],
        axis: if is_x { Axis::X } else { Axis::Y },
        both_directions,
        reverse_offset: if both_directions { reverse_offset } else { 0.0 },
        lead,
    })
}

fn frame() -> Frame {
    Frame { comments: vec!["x".to_owned()], feed: 6_000.0, is_constant: false, has_air: false }
}

/// S of each pixel by the ways that were read, rows from the top. Each way must end at edges of pixels and
/// lie in the middle of its row.
fn powers_of(passes: &[Pass], layout: &Layout, levels: &Levels) -> Result<Vec<f64>, TestCaseError> {
    let along = layout.axis as usize;
    let mut powers = vec![0.0; levels.of.len()];
    for pass in passes.iter().filter(|pass| pass.power > 0.0) {
        let backward = pass.to[along] < pass.from[along];
        let offset = if backward { layout.reverse_offset } else { 0.0 };
        let mut ends = [pass.from, pass.to].map(|place| (place[along] - offset - layout.at[along]) / layout.pixel);
        ends.sort_by(f64::total_cmp);
        let row = (pass.from[1 - along] - layout.at[1 - along]) / layout.pixel - 0.5;
        for place in [ends[0], ends[1], row] {
            let off = (place - place.round()).abs() * layout.pixel;
            prop_assert!(off <= ROUNDING, "{pass:?} is {off} mm off a pixel");
        }
        for pixel in ends[0].round() as usize..ends[1].round() as usize {
            let line = row.round() as usize;
            let [column, row] = if along == 0 { [pixel, line] } else { [line, pixel] };
            powers[(levels.rows - 1 - row) * levels.columns + column] = pass.power;
        }
    }
    Ok(powers)
}

proptest! {
    #[test]
    fn a_picture_comes_back_from_its_lines(
        levels in any_levels(),
        layout in any_layout(),
        scale in prop_oneof![Just(1.0), Just(255.0), Just(1_000.0)],
        shares in (0.0..0.5_f64, 0.5..=1.0_f64),
    ) {
        let powers = Powers { scale, least: shares.0 * scale, most: shares.1 * scale };
        let strokes = layout.strokes(&levels);
        let text = writer::write(&frame(), &layout, &strokes, &powers, |level| levels.share(level));
        for line in text.lines() {
            prop_assert!(line.len() <= 240 && line.matches(':').count() < 32, "{line}");
        }
        prop_assert!(text.ends_with("M5 S0\n"));
        let passes = burnt::read(&text).expect("its own words");
        let read = powers_of(&passes, &layout, &levels)?;
        for (level, s) in levels.of.iter().zip(&read) {
            let wanted = powers.of(levels.share(*level));
            prop_assert!((wanted - s).abs() <= 0.5e-4 * scale + 1e-9, "S{s} for S{wanted}");
            prop_assert_eq!(*level == 0, *s == 0.0);
        }
        let drawn = page::burnt(&passes, &layout, [levels.columns, levels.rows], powers.most);
        for (light, s) in drawn.iter().zip(&read) {
            prop_assert!((f64::from(*light) - 255.0 * (1.0 - s / powers.most)).abs() <= 0.501);
        }
    }

    #[test]
    fn every_stroke_has_dark_leads_of_full_length_and_nothing_burns_outside(
        levels in any_levels(),
        layout in any_layout(),
    ) {
        let powers = Powers { scale: 1.0, least: 0.0, most: 1.0 };
        let strokes = layout.strokes(&levels);
        let text = writer::write(&frame(), &layout, &strokes, &powers, |level| levels.share(level));
        let passes = burnt::read(&text).expect("its own words");
        let length = |pass: &Pass| (pass.to[0] - pass.from[0]).hypot(pass.to[1] - pass.from[1]);
        for stroke in passes.split(|pass| !pass.is_feed).filter(|stroke| !stroke.is_empty()) {
            let [first, .., last] = stroke else { return Err(TestCaseError::fail("a stroke without leads")) };
            for lead in [first, last] {
                prop_assert_eq!(lead.power, 0.0);
                prop_assert!((length(lead) - layout.lead).abs() <= ROUNDING, "{:?}", lead);
            }
            let burns = |index: usize| stroke.get(index).is_some_and(|pass| pass.power > 0.0);
            prop_assert!(burns(1) && burns(stroke.len() - 2), "white margins are left out");
        }
        let dark = passes.iter().filter(|pass| !pass.is_feed).all(|pass| pass.power == 0.0);
        prop_assert!(dark);
        let Some([least, most]) = layout.bounds(&strokes) else { return Ok(()) };
        for place in passes.iter().skip(1).flat_map(|pass| [pass.from, pass.to]) {
            for axis in 0..2 {
                prop_assert!((least[axis] - ROUNDING..=most[axis] + ROUNDING).contains(&place[axis]));
            }
        }
    }
}

#[test]
fn sizes_follow_each_other_and_the_pixel() {
    let pixels = |arguments: &str| {
        let raster = made(&format!("--feed 6000 --acceleration 1000 {arguments}")).expect("a picture");
        [raster.levels.columns, raster.levels.rows]
    };
    assert_eq!(pixels(""), [40, 30]);
    assert_eq!(pixels("--width 20"), [200, 150]);
    assert_eq!(pixels("--height 3 --pixel 0.2"), [20, 15]);
    assert_eq!(pixels("--at -20,-10 --reverse-offset -0.1"), [40, 30]);
    assert_eq!(pixels("--width 2.54 --height 2.54 --dpi 254"), [25, 25]);
}

#[test]
fn the_file_says_what_it_is_and_begins_and_ends_dark() {
    let raster =
        made(&format!("--feed 6000 --config {SAMPLE} --at 50,20 --air --power 60 --power-min S50")).expect("one");
    let text = &raster.text;
    for line in [
        "; Picture: picture.png, by velvet raster",
        "; Size: 4 x 3 mm, 40 x 30 pixels of 0.1 mm",
        "; Speed: 6000 mm/min (100 mm/s), there and back along X",
        "; Leads: 4.33 mm at each end, for 1500 mm/s^2",
        "; Power: S50 to S600, 1000 is full, M4",
        "G21 ; mm",
        "G90 ; absolute",
        "M4 S0",
        "M8",
        "M9",
        "M5 S0",
    ] {
        assert!(text.lines().any(|own| own == line), "{line}: {text}");
    }
    assert!(text.lines().all(|line| line.len() <= 240), "comments are lines too");
    assert!(text.find("M8") < text.find("G0 X") && text.contains("S600") && !text.contains("S1000"));
    let constant =
        made("--feed 6000 --acceleration 1000 --m3 --one-way --vertical --dither bayer --levels 4").expect("one");
    assert!(constant.text.contains("\nM3 S0\nG0 X") && constant.text.contains("one way along Y"));
    assert!(constant.strokes.iter().all(|stroke| !stroke.backward));
}

#[test]
fn the_time_of_the_planner_is_near_that_of_the_strokes() {
    let arguments = "--feed 9000 --width 60 --at 60,20 --pixel 0.5 --one-way";
    let planned = made(&format!("{arguments} --config {SAMPLE}")).expect("one").seconds;
    let estimated = made(&format!("{arguments} --acceleration 1500")).expect("one").seconds;
    assert!((planned / estimated - 1.0).abs() < 0.1, "{planned} s planned, {estimated} s estimated");
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let base = "--feed 6000 --acceleration 1000";
    for (arguments, reason) in [
        ("--feed 6000", "give --config FILE, or --acceleration MM/S^2"),
        ("--feed 0 --acceleration 1000", "--feed must be above 0"),
        (&format!("{base} --width -5"), "--width must be above 0"),
        (&format!("{base} --pixel 0"), "a pixel of 0 mm is not 0.001 to 100 mm"),
        (
            &format!("{base} --width 90000 --pixel 0.01"),
            "give a larger --pixel or a smaller picture: 9000000 x 6750000",
        ),
        (&format!("{base} --levels 1"), "--levels is not 2 to 256"),
        (&format!("{base} --levels 300"), "--levels is not 2 to 256"),
        (&format!("{base} --dither threshold --levels 4"), "threshold has two levels"),
        (&format!("{base} --gamma 0"), "--gamma is not 0.05 to 20"),
        (&format!("{base} --brightness 1"), "the picture is blank"),
        (&format!("{base} --power 101"), "--power 101 is neither 0 to 100 percent nor S0 to S1"),
        (&format!("{base} --power S300 --scale 255"), "--power S300 is neither 0 to 100 percent nor S0 to S255"),
        (&format!("{base} --power 20 --power-min 30"), "--power-min 30 is more than --power 20"),
        (&format!("{base} --power 0"), "--power 0 burns nothing"),
        (&format!("--feed 20000 --config {SAMPLE}"), "--feed 20000 is more than X of the machine can do, 12000 mm/min"),
        (&format!("--feed 6000 --config {SAMPLE}"), "4.33 mm of each end are for getting to 100.0 mm/s at 1500 mm/s^2"),
        (&format!("--feed 6000 --config {SAMPLE} --at 50,318"), "Y goes from 318."),
        ("--feed 6000 --config /no/such.ini", "cannot read /no/such.ini"),
    ] {
        let said = why(arguments);
        assert!(said.contains(reason), "{arguments}: {said}");
    }
    let refused = Cli::try_parse_from(["velvet", "picture.png", "--feed", "1", "--at", "5"]);
    assert!(refused.is_err_and(|error| error.to_string().contains("X,Y in mm is needed")));
}

#[test]
fn the_page_stands_alone_and_has_the_picture_of_the_lines() {
    let raster = made("--feed 6000 --acceleration 1000 --dither none").expect("a picture");
    let page = raster.page("</script><b>.gcode".to_owned(), "x.png".to_owned(), Vec::new()).expect("a page");
    assert!(!page.contains("</script><b>") && !page.contains("{{"));
    for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let passes = burnt::read(&raster.text).expect("its own words");
    let light = page::burnt(&passes, &raster.layout, [40, 30], 1.0);
    let wanted = ramp().light;
    assert!(light.iter().zip(&wanted).all(|(light, wanted)| (f32::from(*light) - 255.0 * wanted).abs() <= 1.0));
    let file = page::png(&light, [40, 30]).expect("a PNG");
    let again = Picture::decode(std::io::Cursor::new(file)).expect("a PNG");
    assert_eq!((again.columns, again.rows), (40, 30));
    assert!(again.light.iter().zip(&light).all(|(again, light)| (again * 255.0 - f32::from(*light)).abs() < 1e-3));
}
