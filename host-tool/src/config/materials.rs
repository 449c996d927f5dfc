//! The materials of `[stack]`, from the library.

use super::reader::TableReader;
use crate::material::{FILMS, Film, SPACERS, Spacer};

/// `film = "polyester"` and `spacer = "air"`: what the other keys of `[stack]` are where they are left out.
pub(super) fn materials(reader: &mut TableReader<'_>) -> (&'static Film, &'static Spacer) {
    let films: Vec<(&str, &Film)> = FILMS.iter().map(|film| (film.name, film)).collect();
    let spacers: Vec<(&str, &Spacer)> = SPACERS.iter().map(|spacer| (spacer.name, spacer)).collect();
    let film = reader.choice("film", &films).unwrap_or(&FILMS[0]);
    (film, reader.choice("spacer", &spacers).unwrap_or(&SPACERS[0]))
}
