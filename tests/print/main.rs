//! Printed sheets as other programs read them: libtiff, ImageMagick, poppler, qpdf and Little CMS.
//!
//! They need the `vitrine` command beside this test, where `cargo build -p vitrine` puts it.

mod manual;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

const FILMS: usize = 8;
const WIDTH_PX: usize = 64;
const HEIGHT_PX: usize = 48;

/// A build of 8 films, 20 x 15 mm, 64 x 48 pixels of 16 bits, printed.
struct Printed {
    folder: tempfile::TempDir,
    sheets: Value,
}

/// The dots of a picture: width, height, interleaved RGB.
struct Dots {
    width: usize,
    height: usize,
    samples: Vec<u16>,
}

impl Printed {
    /// Film values as they are.
    fn new(more: &[&str]) -> Self {
        Self::with(&[&["--as-designed"], more].concat())
    }

    fn with(more: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let vitrine = |arguments: &[&str]| {
            let mut command = Command::new(command());
            command.current_dir(folder.path()).args(arguments);
            let output = command.output().unwrap();
            assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
            output.stdout
        };
        vitrine(&["new", "exhibit"]);
        let toml = folder.path().join("exhibit/exhibit.toml");
        let text = std::fs::read_to_string(&toml).unwrap();
        let text = text
            .replace("\"Three photographs\"", "\"Kleine Größe\"")
            .replace("films = 20", "films = 8")
            .replace("pixels = 512", "pixels = [64, 48]")
            .replace("width_mm = 35.0", "width_mm = 20.0")
            .replace("\"least-squares\"", "\"product\"");
        std::fs::write(&toml, text).unwrap();
        vitrine(&["design", "exhibit/exhibit.toml", "-o", "build", "--bits", "16"]);
        let told = vitrine(&[&["print", "build", "-o", "sheets", "--json"], more].concat());
        Self { sheets: serde_json::from_slice(&told).unwrap(), folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The path as other programs take it.
    fn name(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    fn number(&self, pointer: &str) -> f64 {
        self.sheets.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {pointer}"))
    }

    fn size(&self, pointer: &str) -> (usize, usize) {
        (self.number(&format!("{pointer}/0")) as usize, self.number(&format!("{pointer}/1")) as usize)
    }

    /// Film `film`, 1 on top, as the design wrote it.
    fn film(&self, film: usize) -> Vec<u16> {
        let path = self.path(&format!("build/films/film-{film:02}.png"));
        image::open(path).unwrap().to_rgb16().into_raw()
    }

    /// Where each film is on a sheet: number, dots from the left, dots from above.
    fn places(&self, sheet: usize) -> Vec<(usize, usize, usize)> {
        let films = self.sheets["sheets"][sheet]["films"].as_array().unwrap();
        let number = |value: &Value| value.as_u64().unwrap() as usize;
        films.iter().map(|f| (number(&f["film"]), number(&f["x_dots"]), number(&f["y_dots"]))).collect()
    }
}

/// The command, which stands beside the folder of the tests.
fn command() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let profile = test.parent().and_then(Path::parent).unwrap();
    let command = profile.join("vitrine");
    assert!(command.exists(), "{}: build it with `cargo build -p vitrine`", command.display());
    command
}

fn run(program: &str, arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(program).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("{program}: {error}; tests/run.sh installs it"));
    assert!(output.status.success(), "{program} {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn text(program: &str, arguments: &[&str]) -> String {
    String::from_utf8_lossy(&run(program, arguments)).into_owned()
}

/// The ink of a film's dots: each shows the pixel in which its centre lies.
fn expected(film: &[u16], (width, height): (usize, usize), mirrored: bool) -> Vec<u16> {
    let mut dots = Vec::with_capacity(width * height * 3);
    for row in 0..height {
        let pixel_row = ((row as f64 + 0.5) * HEIGHT_PX as f64 / height as f64) as usize;
        for column in 0..width {
            let column = if mirrored { width - 1 - column } else { column };
            let pixel_column = ((column as f64 + 0.5) * WIDTH_PX as f64 / width as f64) as usize;
            let at = (pixel_row * WIDTH_PX + pixel_column) * 3;
            dots.extend_from_slice(&film[at..at + 3]);
        }
    }
    dots
}

impl Dots {
    fn crop(&self, (left, top): (usize, usize), (width, height): (usize, usize)) -> Vec<u16> {
        let rows = (top..top + height).flat_map(|row| {
            let start = (row * self.width + left) * 3;
            self.samples[start..start + width * 3].iter().copied()
        });
        rows.collect()
    }
}

/// A TIFF as ImageMagick decodes it.
fn by_imagemagick(path: &str) -> Dots {
    let size = text("identify", &["-format", "%w %h", path]);
    let mut sides = size.split(' ').map(|side| side.trim().parse().unwrap());
    let (width, height) = (sides.next().unwrap(), sides.next().unwrap());
    let raw = run("convert", &[path, "-depth", "16", "-endian", "LSB", "rgb:-"]);
    let samples = raw.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
    Dots { width, height, samples: samples.collect() }
}

/// A TIFF as libtiff decodes it: written anew without compression or differencing.
fn by_libtiff(path: &str, plain: &str) -> Dots {
    run("tiffcp", &["-c", "none", path, plain]);
    let picture = image::open(plain).unwrap().to_rgb16();
    Dots { width: picture.width() as usize, height: picture.height() as usize, samples: picture.into_raw() }
}

/// The film pictures of a PDF by their object's number, with what pdfimages tells of each.
fn pictures(pdf: &str) -> Vec<(String, Vec<String>)> {
    let list = text("pdfimages", &["-list", pdf]);
    let rows = list.lines().skip(2).map(|line| line.split_whitespace().map(str::to_owned).collect());
    rows.map(|columns: Vec<String>| (columns[10].clone(), columns)).collect()
}

#[test]
fn every_dot_of_a_tiff_is_what_was_designed_and_films_come_back_exactly() {
    for more in [
        &["--dpi", "720x360", "--format", "tiff"][..],
        &["--dpi", "600x300", "--format", "big-tiff", "--mirrored", "--paper", "roll 120"],
    ] {
        let printed = Printed::new(more);
        let mirrored = more.contains(&"--mirrored");
        let (width, height) = printed.size("/film_dots");
        let mut films = 0;
        for sheet in 0..printed.sheets["sheets"].as_array().unwrap().len() {
            let path = printed.name(&format!("sheets/sheet-{:02}.tif", sheet + 1));
            let path = path.as_str();
            // Little-endian, and the version of plain or of big files.
            let version = if more.contains(&"big-tiff") { 43 } else { 42 };
            assert_eq!(std::fs::read(path).unwrap()[..4], [b'I', b'I', version, 0]);
            let decoded = by_libtiff(path, &printed.name("plain.tif"));
            assert_eq!((decoded.width, decoded.height), printed.size(&format!("/sheets/{sheet}/dots")));
            assert!(decoded.samples == by_imagemagick(path).samples, "the two decoders differ");
            for (number, x, y) in printed.places(sheet) {
                let film = printed.film(number);
                let ink: Vec<u16> =
                    decoded.crop((x, y), (width, height)).iter().map(|sample| u16::MAX - sample).collect();
                assert!(ink == expected(&film, (width, height), mirrored), "film {number}");
                // Back: the dot nearest to each pixel's centre.
                let mut back = Vec::new();
                for row in 0..HEIGHT_PX {
                    for column in 0..WIDTH_PX {
                        let dot =
                            |pixel: usize, dots: usize, pixels: usize| (2 * pixel + 1) * dots / (2 * pixels);
                        let column = dot(column, width, WIDTH_PX);
                        let column = if mirrored { width - 1 - column } else { column };
                        let at = (dot(row, height, HEIGHT_PX) * width + column) * 3;
                        back.extend_from_slice(&ink[at..at + 3]);
                    }
                }
                assert!(back == film, "film {number} does not come back");
                films += 1;
            }
        }
        assert_eq!(films, FILMS);
    }
}

#[test]
fn a_tiff_says_its_size_resolution_and_origin() {
    let printed = Printed::new(&["--dpi", "720x360", "--format", "tiff"]);
    let path = printed.name("sheets/sheet-01.tif");
    // -D decodes every strip and says what is wrong with it.
    let output = Command::new("tiffinfo").args(["-D", path.as_str()]).output().unwrap();
    let (told, complaints) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && complaints.is_empty(), "{complaints}");
    for wanted in [
        "Image Width: 5953 Image Length: 4209",
        "Resolution: 720, 360 pixels/inch",
        "Bits/Sample: 16",
        "Photometric Interpretation: RGB color",
        "Kleine Gr??e, sheet 1 of 1, volume ",
    ] {
        assert!(told.contains(wanted), "{wanted}: {told}");
    }
    let size = text(
        "identify",
        &["-units", "PixelsPerInch", "-format", "%[fx:w/resolution.x*25.4] %[fx:h/resolution.y*25.4]", &path],
    );
    let sides: Vec<f64> = size.split(' ').map(|side| side.parse().unwrap()).collect();
    assert!((sides[0] - 210.0).abs() < 0.02 && (sides[1] - 297.0).abs() < 0.04, "{size}");
}

#[test]
fn a_pdf_holds_the_same_dots_at_the_same_places_and_sizes() {
    let printed = Printed::new(&["--dpi", "720x360", "--format", "pdf"]);
    let path = printed.name("sheets/sheet-01.pdf");
    let path = path.as_str();
    run("qpdf", &["--check", path]);
    let information = text("pdfinfo", &[path]);
    let size = information.lines().find_map(|line| line.strip_prefix("Page size:")).unwrap();
    let sides: Vec<f64> = size.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    assert!((sides[0] / 72.0 * 25.4 - 210.0).abs() < 0.02, "{size}");
    assert!((sides[1] / 72.0 * 25.4 - 297.0).abs() < 0.04, "{size}");
    assert!(information.contains("Kleine Größe, sheet 1 of 1"), "{information}");
    let (width, height) = printed.size("/film_dots");
    let places = printed.places(0);
    let pictures = pictures(path);
    assert_eq!(pictures.len(), FILMS);
    for ((object, columns), &(number, ..)) in pictures.iter().zip(&places) {
        let told: Vec<&str> = [3, 4, 6, 7, 12, 13].iter().map(|&column| columns[column].as_str()).collect();
        let (across, down) = (width.to_string(), height.to_string());
        assert_eq!(told, [across.as_str(), down.as_str(), "3", "16", "720", "360"], "{columns:?}");
        let raw = run("qpdf", &[&format!("--show-object={object}"), "--filtered-stream-data", path]);
        let ink: Vec<u16> = raw.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
        assert!(ink == expected(&printed.film(number), (width, height), false), "film {number}");
    }
    // As poppler draws the page at the printer's resolution: the inks look like paint on paper.
    let page = printed.name("page");
    let page = page.as_str();
    run(
        "pdftoppm",
        &["-rx", "720", "-ry", "360", "-singlefile", "-png", "-aa", "no", "-aaVector", "no", path, page],
    );
    let drawn = image::open(format!("{page}.png")).unwrap().to_rgb16();
    let drawn =
        Dots { width: drawn.width() as usize, height: drawn.height() as usize, samples: drawn.into_raw() };
    for (number, x, y) in places {
        let ink = expected(&printed.film(number), (width, height), false);
        let seen = drawn.crop((x, y), (width, height));
        let paint: Vec<[f64; 3]> = ink
            .chunks_exact(3)
            .map(|ink| {
                let left = [0, 1, 2].map(|channel| 1.0 - f64::from(ink[channel]) / 65_535.0);
                [left[1] * left[2], left[0] * left[2], left[0] * left[1]].map(|part| 255.0 * part)
            })
            .collect();
        // Poppler widens a picture to all dots that it touches, and interpolates for that: what it draws lies between
        // a dot and its neighbours.
        let mut worst: f64 = 0.0;
        for dot in 0..width * height {
            let (row, column) = (dot / width, dot % width);
            let rows = row.saturating_sub(1)..(row + 2).min(height);
            let columns = column.saturating_sub(1)..(column + 2).min(width);
            let near = rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
            for channel in 0..3 {
                let drawn = f64::from(seen[3 * dot + channel]) / 257.0;
                let wanted = near.clone().map(|at| paint[at][channel]);
                let least = wanted.clone().fold(f64::INFINITY, f64::min);
                let most = wanted.fold(0.0, f64::max);
                worst = worst.max(least - drawn).max(drawn - most);
            }
        }
        assert!(worst <= 3.0, "film {number}: {worst}");
    }
}

#[test]
fn the_marks_of_both_formats_are_the_same_and_the_ruler_is_100_mm_long() {
    let printed = Printed::new(&["--dpi", "720x360"]);
    let tiff = by_imagemagick(&printed.name("sheets/sheet-01.tif"));
    let (path, page) = (printed.name("sheets/sheet-01.pdf"), printed.name("page"));
    let page = page.as_str();
    run(
        "pdftoppm",
        &["-rx", "720", "-ry", "360", "-singlefile", "-png", "-aa", "no", "-aaVector", "no", &path, page],
    );
    let pdf = image::open(format!("{page}.png")).unwrap().to_rgb8();
    assert_eq!((pdf.width() as usize, pdf.height() as usize), (tiff.width, tiff.height));
    let dark = |at: usize| tiff.samples[at * 3..at * 3 + 3].iter().all(|&sample| sample == 0);
    let drawn = |at: usize| pdf.as_raw()[at * 3..at * 3 + 3].iter().all(|&sample| sample < 8);
    let (mut both, mut one) = (0, 0);
    for at in 0..tiff.width * tiff.height {
        both += usize::from(dark(at) && drawn(at));
        one += usize::from(dark(at) != drawn(at));
    }
    // They may differ along edges: poppler inks every dot that a shape touches.
    assert!(both > 20_000 && one < both, "{both} {one}");
    // The ruler's line is the longest dark one below the films.
    let top = printed.places(0).iter().map(|place| place.2).max().unwrap() + printed.size("/film_dots").1;
    let longest = (top..tiff.height).map(|row| {
        let (mut best, mut run) = (0usize, 0);
        for column in 0..tiff.width {
            run = if dark(row * tiff.width + column) { run + 1 } else { 0 };
            best = best.max(run);
        }
        best
    });
    let length_mm = longest.max().unwrap() as f64 / 720.0 * 25.4;
    assert!((length_mm - 100.0).abs() < 0.15, "{length_mm}");
}

#[test]
fn the_assembly_sheet_shows_every_film() {
    let printed = Printed::new(&["--dpi", "360x180", "--format", "pdf"]);
    let path = printed.name("sheets/assembly.pdf");
    let path = path.as_str();
    run("qpdf", &["--check", path]);
    let information = text("pdfinfo", &[path]);
    assert!(information.contains("Kleine Größe: assembly") && information.contains("(A4)"), "{information}");
    assert_eq!(pictures(path).len(), FILMS);
}

/// What Little CMS makes of one colour by a profile: Lab of numbers from 0 to 255.
fn lab(profile: &str, numbers: [f64; 3]) -> [f64; 3] {
    const RELATIVE_COLORIMETRIC: &str = "1";
    let mut command = Command::new("transicc");
    command.args(["-n", "-t", RELATIVE_COLORIMETRIC, "-i", profile, "-o", "*Lab"]);
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let [first, second, third] = numbers;
    writeln!(child.stdin.take().unwrap(), "{first} {second} {third}").unwrap();
    let told = String::from_utf8(child.wait_with_output().unwrap().stdout).unwrap();
    let values: Vec<f64> = told.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    values.try_into().unwrap_or_else(|_| panic!("{profile}: {told}"))
}

#[test]
fn the_inks_profile_tells_what_light_their_coverages_give() {
    let printed = Printed::with(&["--dpi", "360x180", "--icc"]);
    let inks = printed.name("sheets/inks.icc");
    // The TIFF's profile as ImageMagick finds it, the PDF's as qpdf does.
    let samples = printed.name("samples.icc");
    run("convert", &[&printed.name("sheets/sheet-01.tif"), &format!("icc:{samples}")]);
    let pdf = std::fs::read(printed.path("sheets/sheet-01.pdf")).unwrap();
    let pdf = String::from_utf8_lossy(&pdf);
    let object = pdf.split("/DestOutputProfile ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    let path = printed.name("sheets/sheet-01.pdf");
    run("qpdf", &["--check", &path]);
    let found = run("qpdf", &[&format!("--show-object={object}"), "--filtered-stream-data", &path]);
    assert!(found == std::fs::read(&inks).unwrap(), "the PDF has another profile");
    // Coverages of equal light are the white of the paper's inks; Lab of the primaries as Lindbloom's sRGB (D50) has it.
    let white = [1.0, 0.43 / 0.85, 0.43 / 0.89];
    for (coverages, wanted) in [
        ([0.0; 3], [0.0; 3]),
        (white, [100.0, 0.0, 0.0]),
        (white.map(|coverage| 0.18 * coverage), [49.5, 0.0, 0.0]),
        ([1.0, 0.0, 0.0], [54.29, 80.81, 69.89]),
        ([0.0, white[1], 0.0], [87.82, -79.27, 80.99]),
        ([0.0, 0.0, white[2]], [29.57, 68.30, -112.03]),
    ] {
        let colours = [
            lab(&inks, coverages.map(|coverage| 255.0 * coverage)),
            lab(&samples, coverages.map(|coverage| 255.0 * (1.0 - coverage))),
        ];
        for colour in colours {
            let off = (0..3).map(|axis| (colour[axis] - wanted[axis]).abs()).fold(0.0, f64::max);
            assert!(off < 0.3, "{coverages:?}: {colour:?}, not {wanted:?}");
        }
    }
}

#[test]
fn a_halftone_is_the_same_in_both_formats_and_no_dot_has_two_inks() {
    for way in ["blue-noise", "error-diffusion"] {
        let printed = Printed::with(&["--dpi", "720x360", "--halftone", way]);
        let (width, height) = printed.size("/film_dots");
        let tiff = by_libtiff(&printed.name("sheets/sheet-01.tif"), &printed.name("plain.tif"));
        let pdf = printed.name("sheets/sheet-01.pdf");
        let pictures = pictures(&pdf);
        assert_eq!(pictures.len(), FILMS);
        for ((object, columns), (number, x, y)) in pictures.iter().zip(printed.places(0)) {
            assert_eq!(columns[7], "1", "bits of a sample: {columns:?}");
            let raw = run("qpdf", &[&format!("--show-object={object}"), "--filtered-stream-data", &pdf]);
            // Rows begin at whole bytes.
            let rows = raw.chunks_exact((3 * width).div_ceil(8));
            let bit = |row: &[u8], at: usize| u16::from(row[at / 8] >> (7 - at % 8) & 1) * u16::MAX;
            let ink: Vec<u16> = rows.flat_map(|row| (0..3 * width).map(move |at| bit(row, at))).collect();
            let samples = tiff.crop((x, y), (width, height));
            let dots = samples.iter().map(|sample| u16::MAX - sample);
            assert!(dots.eq(ink.iter().copied()), "{way}: film {number}");
            assert!(ink.chunks_exact(3).all(|dot| dot.iter().filter(|ink| **ink > 0).count() <= 1));
            assert!(ink.contains(&u16::MAX), "{way}: film {number} is empty");
        }
    }
}
