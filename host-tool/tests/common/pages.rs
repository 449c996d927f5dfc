//! Two pictures in each of three directions, one under each lamp.

use vitrine::design::ViewRequest;
use vitrine::optics::Direction;
use vitrine::volume::CHANNELS;
use vitrine_exhibit::units::Lamp;

use super::common::photo;

/// A photograph, and whether it is turned upside down.
pub(crate) type Page = (&'static str, bool);

/// The four photographs and two of them turned.
pub(crate) const PAGES: [Page; 6] = [
    ("astronaut", false),
    ("coffee", false),
    ("cat", false),
    ("rocket", false),
    ("cat", true),
    ("rocket", true),
];

/// Pages of `pixels` x `pixels` to the right, ahead and to the left; in each direction first the top lamp's.
pub(crate) fn pages(pages: &[Page; 6], pixels: usize) -> Vec<ViewRequest> {
    let places = [30.0, 0.0, -30.0]
        .into_iter()
        .flat_map(|degrees| [Lamp::Top, Lamp::Bottom].map(|lamp| (Direction::new(degrees, 0.0), lamp)));
    let views = pages.iter().zip(places).map(|(&(name, turned), (direction, lamp))| {
        let mut pattern = photo(name, pixels);
        if turned {
            (0..CHANNELS).for_each(|channel| pattern.channel_mut(channel).reverse());
        }
        let id = format!("{name}{}", if turned { "-turned" } else { "" });
        ViewRequest { lamp: Some(lamp), ..ViewRequest::new(id, pattern, direction) }
    });
    views.collect()
}
