//! Foreign text made fit to be told: what a file, an exhibit or a board calls itself may hold what a terminal obeys.

use std::borrow::Cow;
use std::path::Path;

/// Whether a terminal acts on it or a line is torn by it (Unicode's category Cc and the two separators), or it turns the
/// direction of what stands beside it (Unicode Annex 9, explicit formatting).
fn misleads(letter: char) -> bool {
    letter.is_control()
        || matches!(letter, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Whether a text can be told as it is, on one line.
pub fn is_plain(text: &str) -> bool {
    !text.chars().any(misleads)
}

/// A name that can be told on one line: each letter of it that is none is written as JSON does, such as `\u001b`.
pub fn name(text: &str) -> Cow<'_, str> {
    written_out(text, misleads)
}

/// The name of a file or folder, as [`name`] tells it.
pub fn path(path: impl AsRef<Path>) -> String {
    name(&path.as_ref().to_string_lossy()).into_owned()
}

/// The name of a file or folder as a shell takes it back from a line that is copied.
pub fn word(path: impl AsRef<Path>) -> String {
    let told = self::path(path);
    let is_safe = |letter: char| letter.is_alphanumeric() || "/._-+,:@%=".contains(letter);
    if !told.is_empty() && told.chars().all(is_safe) {
        told
    } else {
        format!("'{}'", told.replace('\'', "'\\''"))
    }
}

/// As much of a name as has at most so many bytes, whole letters of it.
pub fn shortened(name: &str, bytes: usize) -> &str {
    let ends = name.char_indices().map(|(at, letter)| at + letter.len_utf8());
    &name[..ends.take_while(|end| *end <= bytes).last().unwrap_or(0)]
}

/// A text of several lines that can be told: as [`name`], but for its line ends and tabs. JSON stays the same JSON.
pub fn lines(text: &str) -> Cow<'_, str> {
    written_out(text, |letter| misleads(letter) && !matches!(letter, '\n' | '\t'))
}

/// The same number of bytes that can be told, for the text into which places point: line ends and tabs stay.
pub fn in_place(text: &str) -> String {
    let shown = |letter: char| match letter {
        '\n' | '\t' => letter,
        // As many bytes as what they stand for.
        _ if misleads(letter) => ['?', '\u{b7}', '\u{fffd}'][letter.len_utf8() - 1],
        _ => letter,
    };
    text.chars().map(shown).collect()
}

/// Makes a name plain that has room for no more bytes.
pub fn make_plain<const N: usize>(name: &mut heapless::String<N>) {
    if !is_plain(name) {
        let plain = name.chars().map(|letter| if misleads(letter) { '?' } else { letter });
        *name = plain.collect();
    }
}

fn written_out(text: &str, is_written_out: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_written_out) {
        return text.into();
    }
    let written = text.chars().map(|letter| match is_written_out(letter) {
        true => format!("\\u{:04x}", u32::from(letter)),
        false => letter.to_string(),
    });
    written.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        assert_eq!(name("a\u{1b}[2Jb\nc\u{9b}d"), "a\\u001b[2Jb\\u000ac\\u009bd");
        assert_eq!(lines("a\u{1b}\n\tb\u{202e}"), "a\\u001b\n\tb\\u202e");
        assert!(matches!(name("Zoë – 日本 🦋"), Cow::Borrowed("Zoë – 日本 🦋")));
        assert_eq!(word("photos/a-1.png"), "photos/a-1.png");
        assert_eq!(word("große Brücke"), "'große Brücke'");
        assert_eq!(word("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!((shortened("a🦋b", 4), shortened("a🦋b", 5), shortened("a🦋b", 9)), ("a", "a🦋", "a🦋b"));
        let mut short: heapless::String<4> = "a\u{9b}b".try_into().unwrap();
        make_plain(&mut short);
        assert_eq!(short, "a?b");
    }

    proptest! {
        #[test]
        fn nothing_that_misleads_is_left(text in any::<String>()) {
            prop_assert!(is_plain(&name(&text)));
            let told = lines(&text);
            prop_assert!(told.lines().all(|line| is_plain(&line.replace('\t', ""))));
            let shown = in_place(&text);
            prop_assert_eq!(shown.len(), text.len());
            prop_assert!(shown.replace(['\n', '\t'], "").chars().all(|letter| !letter.is_control()));
            let json = serde_json::to_string_pretty(&text).unwrap();
            prop_assert_eq!(serde_json::from_str::<String>(&lines(&json)).unwrap(), text);
        }
    }
}
