//! Writes a build folder, whole or not at all.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use miette::Diagnostic;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use super::films;
use super::manifest::{FORMAT, Manifest, portable_name};
use super::page::{PageParts, ViewPictures, page};
use super::read::OpenError;
use super::report::{InSmall, Report};
use super::strips::{GrowingFilms, JOURNAL};
use super::whole::{WholeFolder, put_in_place, try_beside};
use crate::config::{Exhibit, PlanPairs, ZoneError};
use crate::design::{AsBuilt, Design, DesignRequest};
use crate::emission::Emission;
use crate::measure::structural_similarity;
use crate::object::ObjectReport;
use crate::picture::Picture;
use crate::volume::{InkDepth, Volume};
use vitrine_exhibit::plan::{Plan, PlanError, ValidPlan};

/// Why a build cannot be written.
#[derive(Debug, Error, Diagnostic)]
pub enum BuildError {
    /// Something else stands in the build's place.
    #[error("{} is there already and is no build of vitrine", .0.display())]
    #[diagnostic(
        code("vitrine::build::not_a_build"),
        help("name another folder, or remove this one: only builds and empty folders are replaced")
    )]
    NotABuild(PathBuf),
    /// A file cannot be written.
    #[error("cannot write {}", path.display())]
    #[diagnostic(
        code("vitrine::build::write"),
        help("look at the disk's free space and the folder's permissions; nothing was left behind")
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// An input cannot be read again.
    #[error("cannot read {}", path.display())]
    #[diagnostic(code("vitrine::build::input"), help("leave the inputs in their place while they are read"))]
    Input {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A film that has grown strip by strip cannot be ended.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Grown(#[from] OpenError),
    /// A picture cannot be encoded.
    #[error("cannot encode a picture: {0}")]
    #[diagnostic(
        code("vitrine::build::encode"),
        help("this is a fault of vitrine: please report it with the exhibit.toml")
    )]
    Encode(#[from] png::EncodingError),
    /// A file cannot be put into JSON.
    #[error("cannot write JSON: {0}")]
    #[diagnostic(
        code("vitrine::build::encode"),
        help("this is a fault of vitrine: please report it with the exhibit.toml")
    )]
    Json(#[from] serde_json::Error),
    /// The plan is longer than a controller takes.
    #[error("the plan does not fit into a controller")]
    #[diagnostic(code("vitrine::build::plan_size"), help("use fewer views, schedule rules or closed days"))]
    PlanSize,
    /// The controller would refuse the plan.
    #[error("the controller would refuse this plan: {0}")]
    #[diagnostic(code("vitrine::build::plan"), help("mend what it names in exhibit.toml"))]
    Plan(#[from] PlanError),
    /// The time zone is unknown.
    #[error(transparent)]
    #[diagnostic(code("vitrine::build::zone"), help("give a name of the IANA database in [calendar]"))]
    Zone(#[from] ZoneError),
}

/// Looks whether a build may be put at `place`: where nothing is, an empty folder, or another build.
///
/// # Errors
/// Fails when anything else is there, or nothing can be written there.
pub fn check_place(place: &Path) -> Result<(), BuildError> {
    try_beside(place).map_err(|source| BuildError::Write { path: place.to_owned(), source })?;
    if place.symlink_metadata().is_err() {
        return Ok(());
    }
    let empty = std::fs::read_dir(place).is_ok_and(|mut entries| entries.next().is_none());
    if empty || is_build(place) { Ok(()) } else { Err(BuildError::NotABuild(place.to_owned())) }
}

fn is_build(place: &Path) -> bool {
    let Ok(text) = std::fs::read_to_string(place.join("manifest.json")) else { return false };
    let manifest: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    manifest.is_some_and(|manifest| manifest.get("format").is_some_and(|format| format == FORMAT))
}

/// What a build may have beside its design.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beside<'a> {
    /// The request before its pictures were adapted, where they were.
    pub given: Option<&'a DesignRequest>,
    /// What becomes of the design in human hands, where that was asked for.
    pub as_built: Option<&'a AsBuilt>,
    /// What became of the object's model, where there is one.
    pub object: Option<&'a ObjectReport>,
}

/// The files from which a build is made.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// Their names in the manifest, and where they are.
    files: Vec<(String, PathBuf)>,
    exhibit_toml: Option<PathBuf>,
}

impl Inputs {
    /// The files of an exhibit whose paths are relative to `folder`, with its exhibit.toml, where there is one, and
    /// those of its object's model.
    pub fn new(exhibit: &Exhibit, folder: &Path, exhibit_toml: Option<&Path>, model: &[PathBuf]) -> Self {
        let pictures = exhibit.views.iter().flat_map(|view| view.pattern.iter().chain(&view.mask));
        let named = |path: &PathBuf| (portable_name(path), folder.join(path));
        let mut files: Vec<(String, PathBuf)> = pictures.map(named).collect();
        files.extend(exhibit_toml.map(|path| ("exhibit.toml".to_owned(), path.to_owned())));
        files.extend(model.iter().map(|path| {
            let name = path.strip_prefix(folder).unwrap_or(path);
            (portable_name(name), path.clone())
        }));
        Self { files, exhibit_toml: exhibit_toml.map(Path::to_owned) }
    }

    /// Where the pictures and models are: all files but exhibit.toml.
    pub fn shown(&self) -> impl Iterator<Item = &Path> {
        let shown = self.files.iter().filter(|(_, path)| self.exhibit_toml.as_ref() != Some(path));
        shown.map(|(_, path)| path.as_path())
    }

    /// BLAKE3 of all files, however long, by their names.
    fn hashes(&self) -> Result<BTreeMap<String, String>, BuildError> {
        let hash = |(name, path): &(String, PathBuf)| {
            let mut hasher = blake3::Hasher::new();
            let read = std::fs::File::open(path).and_then(|file| hasher.update_reader(file).map(|_| ()));
            read.map_err(|source| BuildError::Input { path: path.clone(), source })?;
            Ok((name.clone(), hasher.finalize().to_hex().to_string()))
        };
        self.files.par_iter().map(hash).collect()
    }
}

/// Writes the build of `design`, made from `inputs`, to `place`, whole or not at all. The design's volume is given back
/// as soon as its films are encoded.
///
/// # Errors
/// Fails when `place` is taken by something else and when anything cannot be written; then `place` is as it was.
pub fn write(
    place: &Path,
    inputs: &Inputs,
    exhibit: &Exhibit,
    request: &DesignRequest,
    beside: Beside<'_>,
    mut design: Design,
) -> Result<Report, BuildError> {
    check_place(place)?;
    let depth = request.settings.ink_depth;
    let named = films::encode(&design.volume, depth)?.into_iter().enumerate();
    let named: Vec<(String, Vec<u8>)> = named.map(|(index, film)| (films::film_name(index), film)).collect();
    // The page adds up light.
    let light = Emission::of(&request.stack).light(&design.volume);
    let encoded_light = match (depth, &light) {
        (InkDepth::Eight, Cow::Borrowed(_)) => None,
        _ => Some(films::encode(&light, InkDepth::Eight)?),
    };
    drop(light);
    let volume = std::mem::replace(&mut design.volume, Volume::new(0, 0, 0));
    let films = Films {
        volume: volume.blake3(depth),
        pixels: [volume.width(), volume.height()],
        of_the_page: match &encoded_light {
            Some(films) => films.iter().map(Vec::as_slice).collect(),
            None => named.iter().map(|(_, film)| film.as_slice()).collect(),
        },
        hashes: named.iter().map(|(name, bytes)| (name.clone(), hash(bytes))).collect(),
    };
    drop(volume);
    let (report, mut files) = described(inputs, exhibit, request, beside, &design, films)?;
    drop(encoded_light);
    files.extend(named);
    write_files(place, &files)?;
    Ok(report)
}

/// Puts a build by strips into its place: the films that have grown, and beside them what the same exhibit in small,
/// `request` and `design`, says of it, and what there is `beside`.
///
/// # Errors
/// Fails when `place` is taken by something else and when anything cannot be written; then the films can be gone on with.
pub fn write_grown(
    place: &Path,
    inputs: &Inputs,
    exhibit: &Exhibit,
    (request, design): (&DesignRequest, &Design),
    beside: Beside<'_>,
    growing: GrowingFilms,
) -> Result<Report, BuildError> {
    check_place(place)?;
    let folder = growing.folder().to_owned();
    let grown = growing.finish()?;
    let light = Emission::of(&request.stack).light(&design.volume);
    let films_of_the_page = films::encode(&light, InkDepth::Eight)?;
    let films = Films {
        volume: grown.volume,
        pixels: [light.width(), light.height()],
        of_the_page: films_of_the_page.iter().map(Vec::as_slice).collect(),
        hashes: grown.files,
    };
    let (report, files) = described(inputs, exhibit, request, beside, design, films)?;
    for (name, bytes) in &files {
        let path = folder.join(name);
        let written = path.parent().map_or(Ok(()), std::fs::create_dir_all).and_then(|()| {
            let mut file = std::fs::File::create(&path)?;
            file.write_all(bytes)?;
            file.sync_all()
        });
        written.map_err(|source| BuildError::Write { path, source })?;
    }
    check_place(place)?;
    let at = |source| BuildError::Write { path: place.to_owned(), source };
    put_in_place(&folder, place).map_err(at)?;
    std::fs::remove_file(place.join(JOURNAL)).map_err(at)?;
    Ok(report)
}

/// What a build says of its films.
struct Films<'a> {
    /// BLAKE3 of the volume.
    volume: [u8; 32],
    /// Width and height of the films of the page.
    pixels: [usize; 2],
    /// 8-bit PNG files; in small, where the films are large.
    of_the_page: Vec<&'a [u8]>,
    /// BLAKE3 of the files by their names.
    hashes: Vec<(String, String)>,
}

/// The report, and all files of a build but the films.
fn described(
    inputs: &Inputs,
    exhibit: &Exhibit,
    request: &DesignRequest,
    beside: Beside<'_>,
    design: &Design,
    films: Films<'_>,
) -> Result<(Report, BTreeMap<String, Vec<u8>>), BuildError> {
    let given = beside.given;
    let mut report = Report::new(exhibit, design);
    report.as_built = beside.as_built.cloned();
    report.object = beside.object.cloned();
    let (pixels, film_pixels) = (films.pixels, exhibit.stack.pixels);
    let film_pixels = film_pixels.map(|pixels| pixels as usize);
    report.in_small = (pixels != film_pixels).then_some(InSmall { pixels, film_pixels });
    if let Some(given) = given {
        for ((view, adapted), given) in report.views.iter_mut().zip(&request.views).zip(&given.views) {
            view.similarity_to_given = Some(structural_similarity(&adapted.pattern, &given.pattern));
        }
    }
    let mut files = BTreeMap::new();
    let pictures = view_pictures(request, given, design)?;
    let plan = plan_of(exhibit, design, films.volume)?;
    files.insert("plan.json".to_owned(), json(&plan)?);
    files.insert("plan.bin".to_owned(), plan_file(&plan)?);
    files.insert("report.json".to_owned(), json(&report)?);
    for (view, pictures) in design.views.iter().zip(&pictures) {
        files.insert(format!("views/{}.png", view.id), pictures.shown.clone());
        files.insert(format!("views/{}.target.png", view.id), pictures.pattern.clone());
        if let Some(given) = &pictures.given {
            files.insert(format!("views/{}.given.png", view.id), given.clone());
        }
    }
    let depth = request.settings.ink_depth;
    let mut manifest = manifest(inputs, exhibit, depth, &files, films.hashes)?;
    // The page turns the films that it holds.
    let mut shown = exhibit.clone();
    shown.stack.pixels = films.pixels.map(|pixels| pixels as u32);
    let page = page(&PageParts {
        exhibit: &shown,
        report: &report,
        plan: &plan,
        pictures: &pictures,
        films: &films.of_the_page,
        manifest: &manifest,
    });
    manifest.outputs.insert("report.html".to_owned(), hash(page.as_bytes()));
    files.insert("report.html".to_owned(), page.into_bytes());
    files.insert("manifest.json".to_owned(), json(&manifest)?);
    Ok((report, files))
}

fn write_files(place: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<(), BuildError> {
    let at = |path: PathBuf| move |source| BuildError::Write { path, source };
    let folder = WholeFolder::beside(place).map_err(at(place.to_owned()))?;
    files.par_iter().try_for_each(|(name, bytes)| folder.write(name, bytes).map_err(at(place.join(name))))?;
    check_place(place)?;
    folder.commit().map_err(at(place.to_owned()))
}

fn view_pictures(
    request: &DesignRequest,
    given: Option<&DesignRequest>,
    design: &Design,
) -> Result<Vec<ViewPictures>, BuildError> {
    request
        .views
        .iter()
        .zip(&design.views)
        .enumerate()
        .map(|(index, (view, designed))| {
            let given = given.and_then(|given| given.views.get(index));
            Ok(ViewPictures {
                given: given.map(|given| encode_srgb(&given.pattern)).transpose()?,
                pattern: encode_srgb(&view.pattern)?,
                shown: encode_srgb(&designed.shown)?,
                error: encode_srgb(&designed.shown.difference(&view.pattern))?,
            })
        })
        .collect()
}

/// A picture of sRGB code values as a PNG that says so.
fn encode_srgb(picture: &Picture) -> Result<Vec<u8>, png::EncodingError> {
    encode_rgb8(picture, |info| info.set_source_srgb(png::SrgbRenderingIntent::Perceptual))
}

/// A picture as an 8-bit PNG whose header `describe` completes.
pub(super) fn encode_rgb8(
    picture: &Picture,
    describe: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>),
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width() as u32, picture.height() as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    describe(&mut encoder);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&picture.rgb8())?;
    writer.finish()?;
    Ok(bytes)
}

fn plan_of(exhibit: &Exhibit, design: &Design, volume: [u8; 32]) -> Result<Plan, BuildError> {
    let pairs = PlanPairs {
        views: design.views.iter().map(|view| view.emphasis).collect(),
        neutral: design.neutral,
        shared: design.shared.iter().map(|shared| shared.pair).collect(),
    };
    let plan = exhibit.plan(&pairs, volume)?;
    ValidPlan::new(plan.clone())?;
    Ok(plan)
}

/// The plan as it is uploaded.
fn plan_file(plan: &Plan) -> Result<Vec<u8>, BuildError> {
    let mut bytes = vec![0; vitrine_protocol::plan_file::MAX_PLAN_BYTES];
    let used = vitrine_protocol::plan_file::encode(plan, &mut bytes).ok_or(BuildError::PlanSize)?.len();
    bytes.truncate(used);
    Ok(bytes)
}

fn manifest(
    inputs: &Inputs,
    exhibit: &Exhibit,
    depth: InkDepth,
    files: &BTreeMap<String, Vec<u8>>,
    hashed: Vec<(String, String)>,
) -> Result<Manifest, BuildError> {
    let bits = match depth {
        InkDepth::Eight => 8,
        InkDepth::Sixteen => 16,
    };
    let mut manifest = Manifest::new(exhibit, bits);
    manifest.inputs = inputs.hashes()?;
    manifest.outputs = files.iter().map(|(name, bytes)| (name.clone(), hash(bytes))).collect();
    manifest.outputs.extend(hashed);
    Ok(manifest)
}

/// BLAKE3 in hexadecimal digits.
fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

fn json(value: &impl Serialize) -> Result<Vec<u8>, serde_json::Error> {
    let mut bytes = serde_json::to_vec_pretty(value)?;
    bytes.push(b'\n');
    Ok(bytes)
}
