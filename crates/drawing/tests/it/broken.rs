//! Files that are broken, on purpose or not: an answer in words, soon.

use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

use lafet_drawing::placing::{Known, place};
use lafet_drawing::{Height, Limits, Problem, Stated, read};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/drawings");
/// Far more than any of these takes, far less than a hang.
const SOON: Duration = Duration::from_secs(60);

fn refused(bytes: &[u8], words: &str) -> Problem {
    let start = Instant::now();
    let problem = read(bytes, &Limits::default()).expect_err(words);
    assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    let text = problem.to_string();
    assert!(text.contains(words), "{words}: {text}");
    assert!(text.len() < 600, "{text}");
    problem
}

fn dxf(sections: &str) -> Vec<u8> {
    format!("{sections}0\nEOF\n").into_bytes()
}

fn entities(body: &str) -> Vec<u8> {
    dxf(&format!("0\nSECTION\n2\nENTITIES\n{body}0\nENDSEC\n"))
}

/// A part of a drawing must never pass for the whole.
#[test]
fn a_file_that_is_cut_anywhere_is_refused() {
    let text = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n\
                0\nCIRCLE\n8\n0\n10\n1\n20\n2\n40\n3\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n\
                2\nB\n66\n1\n0\nATTRIB\n2\nID\n1\nT-1\n0\nSEQEND\n0\nPOLYLINE\n8\nW\n0\nVERTEX\n10\n1\n0\nVERTEX\n\
                20\n5\n0\nSEQEND\n0\nLWPOLYLINE\n10\n1\n20\n1\n42\n1\n10\n2\n20\n1\n0\nENDSEC\n0\nEOF\n";
    assert_eq!(read(text.as_bytes(), &Limits::default()).unwrap().shapes.len(), 4);
    let binary = std::fs::read(Path::new(FOLDER).join("05-feet-binary.dxf")).unwrap();
    let json = std::fs::read(Path::new(FOLDER).join("17-utm.geojson")).unwrap();
    let svg = std::fs::read(Path::new(FOLDER).join("18-paper-1-500.svg")).unwrap();
    let limits = Limits::default();
    for whole in [text.as_bytes(), &json, &svg] {
        for cut in 0..whole.trim_ascii_end().len() {
            assert!(read(&whole[..cut], &limits).is_err(), "{cut} of {}", whole.len());
        }
    }
    for cut in (0..binary.len() - 10).step_by(7) {
        assert!(read(&binary[..cut], &limits).is_err(), "{cut} of {}", binary.len());
    }
}

#[test]
fn blocks_in_blocks_end() {
    let body = "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nB0\n0\nENDSEC\n";
    // Each block has ten of the next: too deep, or too many.
    for (count, words) in [(20, "nested deeper than 16"), (12, "200000 shapes")] {
        let mut blocks = String::from("0\nSECTION\n2\nBLOCKS\n");
        for n in 0..count {
            _ = write!(blocks, "0\nBLOCK\n2\nB{n}\n");
            for _ in 0..10 {
                _ = write!(blocks, "0\nINSERT\n2\nB{}\n", n + 1);
            }
            blocks.push_str("0\nENDBLK\n");
        }
        refused(&dxf(&format!("{blocks}{body}")), words);
    }
    // One has itself.
    let own = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n0\nINSERT\n2\nB\n0\nENDBLK\n";
    refused(&dxf(&format!("{own}{}", body.replace("B0", "B"))), "nested deeper than 16");
    // Rows and columns without end, of nothing.
    let rows = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n\
                0\nINSERT\n2\nB\n70\n2000000000\n71\n2000000000\n0\nENDSEC\n";
    refused(&dxf(rows), "200000 shapes");
}

#[test]
fn numbers_that_are_none_or_too_large_are_refused_with_their_line() {
    for (value, words) in [
        ("nan", "line 8: The code 20 needs a number"),
        ("inf", "line 8"),
        ("1e999", "line 8"),
        ("12,5", "not `12,5`"),
        ("", "not ``"),
        ("1e300", "too large"),
        ("-1e13", "too large"),
    ] {
        let body = format!("0\nCIRCLE\n20\n{value}\n10\n0\n40\n1\n");
        refused(&entities(&body), words);
    }
    for scale in ["1e300", "1e308"] {
        let blocks = "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n0\nCIRCLE\n10\n1e9\n40\n1e9\n0\nENDBLK\n0\nENDSEC\n";
        let body = format!(
            "0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nB\n41\n{scale}\n42\n{scale}\n0\nENDSEC\n"
        );
        refused(&dxf(&format!("{blocks}{body}")), "too large");
    }
    let bulge = "0\nLWPOLYLINE\n10\n0\n20\n0\n42\n1e300\n10\n1\n20\n0\n";
    _ = read(&entities(bulge), &Limits::default());
    let ellipse = "0\nELLIPSE\n10\n0\n11\n1\n40\n1\n41\n-1e300\n42\n1e300\n";
    _ = read(&entities(ellipse), &Limits::default());
    refused(b"{\"type\":\"Point\",\"coordinates\":[1e999,2]}", "line 1");
    refused(b"{\"type\":\"Point\",\"coordinates\":[1e300,2]}", "too large");
    refused(b"{\"type\":\"Polygon\",\"coordinates\":[1,2]}", "Polygon");
    refused(b"{\"type\":\"LineString\",\"coordinates\":[[1,2],[3]]}", "GeoJSON");
    let svg = |body: &str| format!("<svg xmlns=\"http://www.w3.org/2000/svg\">\n{body}</svg>");
    refused(svg("<circle r=\"1e300\"/>").as_bytes(), "too large");
    refused(svg("<circle r=\"5%\"/>").as_bytes(), "line 2: r = `5%` is no length");
    refused(svg("<g transform=\"spin(3)\"/>").as_bytes(), "no transform");
    refused(svg("<path d=\"M0 0 L banana\"/>").as_bytes(), "path");
    refused(svg("<path d=\"M0 0 A1e308 1e308 0 1 1 1e308 1e308\"/>").as_bytes(), "too large");
}

#[test]
fn xml_that_grows_ends() {
    let mut laughs = String::from("<!DOCTYPE svg [<!ENTITY a0 \"ha\">");
    for n in 1..12 {
        let ten = format!("&a{};", n - 1).repeat(10);
        _ = write!(laughs, "<!ENTITY a{n} \"{ten}\">");
    }
    laughs.push_str("]><svg xmlns=\"http://www.w3.org/2000/svg\"><text x=\"1\">&a11;</text></svg>");
    refused(laughs.as_bytes(), "");
    // One long entity, used often.
    let long = "x".repeat(100_000);
    let uses = "&a;".repeat(100_000);
    let wide =
        format!("<!DOCTYPE svg [<!ENTITY a \"{long}\">]><svg><text x=\"1\">{uses}</text></svg>");
    refused(wide.as_bytes(), "too long a text");
    // As Illustrator writes it, that is fine.
    let fine = "<!DOCTYPE svg [<!ENTITY ns \"http://www.w3.org/2000/svg\">]>\
                <svg xmlns=\"&ns;\"><g id=\"A\"><circle r=\"3\"/></g></svg>";
    assert_eq!(read(fine.as_bytes(), &Limits::default()).unwrap().shapes.len(), 1);
    let svg = |body: &str| format!("<svg xmlns=\"http://www.w3.org/2000/svg\">{body}</svg>");
    refused(svg(&"<g>".repeat(300_000)).as_bytes(), "");
    let deep = format!("{}{}", "<g>".repeat(1000), "</g>".repeat(1000));
    refused(svg(&deep).as_bytes(), "nested deeper than 200");
    // References to each other.
    let mut uses = String::from("<circle id=\"u0\" r=\"1\"/>");
    for n in 1..20 {
        let ten = format!("<use href=\"#u{}\"/>", n - 1).repeat(10);
        _ = write!(uses, "<g id=\"u{n}\">{ten}</g>");
    }
    refused(svg(&uses).as_bytes(), "");
    refused(svg("<g id=\"a\"><use href=\"#a\"/></g>").as_bytes(), "nested deeper");
    refused(
        format!("{{\"type\":\"Point\",\"coordinates\":{}", "[".repeat(1_000_000)).as_bytes(),
        "",
    );
    let mut nested = String::new();
    for _ in 0..40 {
        nested.push_str("{\"type\":\"GeometryCollection\",\"geometries\":[");
    }
    nested.push_str(&"]}".repeat(40));
    refused(nested.as_bytes(), "nested deeper");
}

/// What is short as text and long as work: for the parsers, or each time it is referred to.
#[test]
fn what_would_take_long_is_refused_before() {
    let list = |part: &str, count: usize| vec![part; count].join(",");
    let features = list("{}", 900_000);
    refused(
        format!("{{\"type\":\"FeatureCollection\",\"features\":[{features}]}}").as_bytes(),
        "200000 shapes",
    );
    let lists = list("[]", 2_000_000);
    refused(
        format!("{{\"type\":\"MultiPoint\",\"coordinates\":[{lists}]}}").as_bytes(),
        "1000000 points",
    );
    let svg = |body: &str| format!("<svg xmlns=\"http://www.w3.org/2000/svg\">{body}</svg>");
    let attributes = |count: usize, name: &str| -> String {
        (0..count).map(|n| format!(" {name}{n} = 'u{n}'")).collect()
    };
    for (count, name) in [(300, "a"), (70, "xmlns:p")] {
        refused(svg(&format!("<g{}/>", attributes(count, name))).as_bytes(), "200000 shapes");
    }
    assert!(
        read(svg(&format!("<g{}/>", attributes(30, "xmlns:p"))).as_bytes(), &Limits::default())
            .is_ok()
    );
    refused("<g>".repeat(4_100_000).as_bytes(), "200000 shapes");
    refused(svg(&"<g a=''/>".repeat(4_100_000)).as_bytes(), "200000 shapes");
    // A long path without a line, a group of comments and a text, each used often.
    let uses = "<use href=\"#a\"/>".repeat(100_000);
    let path = format!("<path id=\"a\" d=\"{}\"/>", "M0 0".repeat(2500));
    let comments = format!("<g id=\"a\">{}</g>", "<!---->".repeat(1000));
    for often in [path, comments] {
        refused(svg(&format!("{often}{uses}")).as_bytes(), "200000 shapes");
    }
    let words = format!("<text id=\"a\" x=\"1\">{}</text>", "word<tspan/>".repeat(100_000));
    let start = Instant::now();
    assert!(read(svg(&format!("{words}{uses}")).as_bytes(), &Limits::default()).is_ok());
    assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
}

#[test]
fn properties_may_be_of_any_kind() {
    let read = |properties: &str| {
        let file = format!(
            "{{\"type\":\"Feature\",\"properties\":{properties},\
             \"geometry\":{{\"type\":\"Point\",\"coordinates\":[1,2]}}}}"
        );
        read(file.as_bytes(), &Limits::default()).unwrap()
    };
    let all = read("{\"LAYER\":7,\"Name\":\"T-1\",\"height\":\"12.5 m\",\"other\":[{\"a\":[]}]}");
    let shape = &all.shapes[0];
    assert_eq!((all.layers[0].name.as_str(), shape.name.as_deref()), ("7", Some("T-1")));
    assert_eq!(shape.height, Some(Height::Metres(12.5)));
    for properties in ["null", "{}", "{\"layer\":[1,{\"a\":2}],\"name\":null,\"height\":true}"] {
        let none = read(properties);
        assert_eq!((none.layers[0].name.as_str(), &none.shapes[0].name), ("0", &None));
        assert_eq!(none.shapes[0].height, None);
    }
}

#[test]
fn what_is_too_much_is_refused() {
    let limits = Limits { bytes: 1000, shapes: 10, points: 100, layers: 3, labels: 2 };
    let said = |bytes: &[u8]| read(bytes, &limits).unwrap_err().to_string();
    assert!(said(&[b' '; 1001]).contains("1001 bytes"));
    let points = "0\nPOINT\n8\nA\n".repeat(11);
    assert!(said(&entities(&points)).contains("10 shapes"));
    let layers: String = (0..4).map(|n| format!("0\nPOINT\n8\nL{n}\n")).collect();
    assert!(said(&entities(&layers)).contains("3 layers"));
    let arcs = format!("0\nLWPOLYLINE\n{}", "10\n0\n20\n0\n42\n1\n10\n5\n20\n0\n".repeat(2));
    assert!(said(&entities(&arcs)).contains("100 points"));
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"><path d=\"M0 0c1 1 2 2 3 3 1 1 2 2 3 3 1 1 2 2 3 3 \
               1 1 2 2 3 3 1 1 2 2 3 3\"/></svg>";
    assert!(said(svg.as_bytes()).contains("100 points"));
    let labels = "0\nTEXT\n1\nname\n".repeat(9);
    assert_eq!(read(&entities(&labels), &limits).unwrap().labels.len(), 2);
}

/// Whatever is read of arbitrary changes can also be placed or is refused.
#[test]
fn changed_bytes_never_panic() {
    let limits = Limits { shapes: 2000, points: 20_000, ..Limits::default() };
    let mut seed: u64 = 1;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize
    };
    for file in
        ["05-feet-binary.dxf", "18-paper-1-500.svg", "16-wgs84.geojson", "21-photograph.jpg"]
    {
        let whole = std::fs::read(Path::new(FOLDER).join(file)).unwrap();
        for _ in 0..300 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random() % 4 {
                let at = random() % bytes.len();
                bytes[at] = random() as u8;
            }
            if let Ok(drawing) = read(&bytes, &limits) {
                _ = place(drawing, &Known::of(Stated::by_name("m").unwrap()));
            }
        }
    }
}
