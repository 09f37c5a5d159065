//! This program as the process of a camera.

use std::ffi::OsString;

use lafet_hub::CameraProgram;

/// The argument that makes it one. No command of people: it is in no help.
const WORD: &str = "camera-process";

/// Whether this is to be the process of a camera.
pub fn is_wanted(mut arguments: impl ExactSizeIterator<Item = OsString>) -> bool {
    arguments.len() == 2 && arguments.nth(1).is_some_and(|word| word == WORD)
}

/// How the hub starts one.
pub fn program() -> CameraProgram {
    // On Linux that which runs, also after an upgrade has put another file in its place.
    let own = match cfg!(target_os = "linux") {
        true => Some("/proc/self/exe".into()),
        false => std::env::current_exe().ok(),
    };
    own.map(|own| vec![own.into_os_string(), WORD.into()]).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_hub_makes_it_a_process_of_a_camera() {
        let is = |arguments: &[&str]| {
            is_wanted(
                arguments.iter().map(|it| OsString::from(*it)).collect::<Vec<_>>().into_iter(),
            )
        };
        assert!(is(&["lafet", WORD]));
        assert!(!is(&["lafet"]) && !is(&["lafet", "serve"]) && !is(&["lafet", WORD, "--help"]));
        assert_eq!(program().len(), 2);
    }
}
