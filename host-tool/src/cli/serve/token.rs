//! The access token: who has it may command.

use std::io;
use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

/// The fewest characters of a token: a random one of so many hexadecimal digits has 64 bits.
const FEWEST: usize = 16;
const RANDOM_BYTES: usize = 16;

/// Why there is no token.
#[derive(Debug, Error, Diagnostic)]
pub(super) enum TokenFailure {
    #[error("cannot read the access token in {}", path.display())]
    #[diagnostic(
        code(vitrine::serve::token),
        help(
            "write at least {FEWEST} characters into a file that only you can read, and name it with --token-file"
        )
    )]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("the access token in {} has {length} characters", path.display())]
    #[diagnostic(
        code(vitrine::serve::token),
        help("give one of at least {FEWEST} without spaces, so that nobody guesses it")
    )]
    Weak { path: PathBuf, length: usize },
    #[error("this computer gives no random numbers: {0}")]
    #[diagnostic(code(vitrine::serve::token), help("give a token of your own with --token-file"))]
    NoRandom(getrandom::Error),
}

/// An access token.
pub(super) struct Token {
    text: String,
}

impl Token {
    /// Takes the first line of a file.
    pub(super) fn read(path: &Path) -> Result<Self, TokenFailure> {
        let unreadable = |source| TokenFailure::Unreadable { path: path.to_owned(), source };
        let file = std::fs::read_to_string(path).map_err(unreadable)?;
        let text = file.lines().next().unwrap_or_default().trim().to_owned();
        if text.chars().count() < FEWEST || text.chars().any(|character| !character.is_ascii_graphic()) {
            return Err(TokenFailure::Weak { path: path.to_owned(), length: text.chars().count() });
        }
        Ok(Self { text })
    }

    /// Makes a new one.
    pub(super) fn random() -> Result<Self, TokenFailure> {
        let mut bytes = [0; RANDOM_BYTES];
        getrandom::fill(&mut bytes).map_err(TokenFailure::NoRandom)?;
        Ok(Self { text: bytes.iter().map(|byte| format!("{byte:02x}")).collect() })
    }

    /// The token itself.
    pub(super) fn reveal(&self) -> &str {
        &self.text
    }

    /// Whether `given` is the token. How long that takes tells nothing of where they differ: hashes are compared, in
    /// constant time.
    pub(super) fn is(&self, given: &str) -> bool {
        blake3::hash(given.as_bytes()) == blake3::hash(self.text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_itself_alone_and_never_the_same_twice() {
        let (one, other) = (Token::random().unwrap(), Token::random().unwrap());
        assert_eq!(one.reveal().len(), 2 * RANDOM_BYTES);
        assert!(
            one.is(one.reveal()) && !one.is(other.reveal()) && !one.is("") && !one.is(&one.reveal()[1..])
        );
    }

    #[test]
    fn a_file_without_a_good_token_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("token");
        assert!(matches!(Token::read(&path), Err(TokenFailure::Unreadable { .. })));
        for (text, length) in
            [("", 0), ("short", 5), ("fifteen letters", 15), ("sixteen letters and spaces", 26)]
        {
            std::fs::write(&path, text).unwrap();
            assert!(
                matches!(Token::read(&path), Err(TokenFailure::Weak { length: l, .. }) if l == length),
                "{text}"
            );
        }
        std::fs::write(&path, "0123456789abcdef\n").unwrap();
        assert!(Token::read(&path).unwrap().is("0123456789abcdef"));
    }
}
