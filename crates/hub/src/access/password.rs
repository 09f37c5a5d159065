//! Passwords that are not guessed within the tries that the hub allows.

use lafet_texts::{Text as _, hub as text};
use zxcvbn::{Score, zxcvbn};

use super::users::AccessError;
use crate::text::Both;

/// Shortest password, characters.
pub const PASSWORD_MIN: usize = 10;
/// Longest password, bytes: hashing more is work for nothing.
pub const PASSWORD_MAX: usize = 1024;
/// More is not looked at for its strength.
const LOOKED_AT: usize = 100;
/// About a hundred million guesses: at one in 15 s that is 47 years.
const LEAST: Score = Score::Three;
/// The Russian keyboard, and what its keys have in Latin.
const KEYS: [&str; 2] = ["йцукенгшщзхъфывапролджэячсмитьбюё", "qwertyuiop[]asdfghjkl;'zxcvbnm,.`"];

/// Refuses a password that is too short or easily guessed.
pub fn check(user: &str, password: &str) -> Result<(), AccessError> {
    if password.chars().count() < PASSWORD_MIN || password.len() > PASSWORD_MAX {
        return Err(AccessError::Weak(short()));
    }
    let looked_at: String = password.chars().take(LOOKED_AT).collect();
    let typed: String = looked_at.to_lowercase().chars().map(on_keyboard).collect();
    let known = [user, "lafet", "monitor", "лафет", "пароль", "gfhjkm"];
    let weak = |text: &str| zxcvbn(text, &known).score() < LEAST;
    if weak(&looked_at) || looked_at != typed && weak(&typed) {
        return Err(AccessError::Weak(guessed()));
    }
    Ok(())
}

/// A Russian word typed on Latin keys, and the other way round, is no secret.
fn on_keyboard(letter: char) -> char {
    let at = KEYS[0].chars().position(|it| it == letter);
    at.and_then(|at| KEYS[1].chars().nth(at)).unwrap_or(letter)
}

fn short() -> Both {
    text::PasswordShort.words()
}

fn guessed() -> Both {
    text::PasswordGuessed.words()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_guessed_first_is_refused() {
        let weak = [
            "short",
            "aaaaaaaaaa",
            "1234567890",
            "password12",
            "qwertyuiop",
            "йцукенгшщз",
            "пароль1234",
            "operator-1",
            "2026202620",
            "abcabcabcabc",
        ];
        for password in weak {
            assert!(check("operator", password).is_err(), "{password}");
        }
        for password in ["correct horse", "жёлтый паровоз 41", "tk7#vPq2!x", "first password"]
        {
            assert!(check("operator", password).is_ok(), "{password}");
        }
        let long = "x7".repeat(PASSWORD_MAX);
        assert!(check("operator", &long).is_err(), "hashing it is work for nothing");
    }
}
