//! `plot`, which writes the figures of a fit as SVG files.

use quick_xml::events::Event;

use crate::program::{run, succeed};
use crate::workshop::{ALL_FILES, Workshop};

/// Texts of an SVG file, and the number of its figures and lines.
#[derive(Default)]
struct Drawing {
    texts: Vec<String>,
    n_figures: usize,
    n_lines: usize,
}

/// Parses the file, and fails if it is not well-formed.
fn drawing(workshop: &Workshop, name: &str) -> Drawing {
    let text = workshop.read(name);
    let mut reader = quick_xml::Reader::from_str(&text);
    let mut found = Drawing::default();
    loop {
        match reader.read_event().unwrap() {
            Event::Start(tag) | Event::Empty(tag) => {
                let has = |key: &str| tag.try_get_attribute(key).unwrap().is_some();
                match tag.name().as_ref() {
                    b"svg" => found.n_figures += usize::from(has("role")),
                    b"path" => found.n_lines += usize::from(has("stroke-opacity")),
                    _ => {}
                }
            }
            Event::Text(text) => found.texts.push(text.decode().unwrap().into_owned()),
            Event::Eof => return found,
            _ => {}
        }
    }
}

#[test]
fn every_figure_is_written_with_its_axes() {
    let workshop = Workshop::with_recordings();
    let names = ["loops.svg", "traces.svg", "thresholds.svg"];
    let options = ["--loops", names[0], "--traces", names[1], "--thresholds", names[2]];
    succeed(workshop.path(), &[&["plot"], &ALL_FILES[..], &options].concat());
    let labels = [
        ["Fz error [N]", "Fz Reference [N]"],
        ["Fz error [N]", "time [s]"],
        ["RMSE [N]", "F_th [N]"],
    ];
    // The two lines of the traces, and both again in the legend. The curves are those of both thresholds.
    let counted = [(1, 10), (1, 4), (2, 12)];
    for ((name, labels), counted) in names.into_iter().zip(labels).zip(counted) {
        let drawing = drawing(&workshop, name);
        assert_eq!((drawing.n_figures, drawing.n_lines), counted, "{name}");
        for label in labels {
            assert!(drawing.texts.iter().any(|text| text == label), "{name}: no {label}");
        }
    }
    let again = run(workshop.path(), &["plot", "a.csv", "--loops", "loops.svg"]);
    assert_eq!(again.status.code(), Some(1), "an existing file is kept");
}

#[test]
fn a_figure_needs_a_name_that_ends_in_svg() {
    let workshop = Workshop::with_recordings();
    for arguments in [&["plot", "a.csv"][..], &["plot", "a.csv", "--loops", "loops.png"]] {
        assert_eq!(run(workshop.path(), arguments).status.code(), Some(2));
        assert!(!workshop.file("loops.png").exists());
    }
}
