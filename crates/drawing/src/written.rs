//! What a person states, as it is written on a command line: `10.5,20=0,0`.

use lafet_texts::{Text, Words, drawing as text};

use crate::placing::{Distance, Pair};
use crate::site::{Chosen, Mark, Role};
use crate::{Geodetic, Stated};

/// Numbers with commas between.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    list(text)?.try_into().ok()
}

fn list(text: &str) -> Option<Vec<f64>> {
    let number = |it: &str| it.trim().parse::<f64>().ok().filter(|it| it.is_finite());
    text.split(',').map(number).collect()
}

fn known<T>(found: Option<T>, form: impl Text) -> Result<T, Words> {
    found.ok_or_else(|| form.words())
}

/// A unit, `wgs84` or `points`.
///
/// # Errors
///
/// What there is.
pub fn unit(text: &str) -> Result<Stated, Words> {
    known(Stated::by_name(text), text::WrittenUnit { names: Stated::names() })
}

/// `X,Y`.
///
/// # Errors
///
/// How it is written.
pub fn place(text: &str) -> Result<[f64; 2], Words> {
    known(numbers(text), text::WrittenPlace)
}

/// `X,Y=EAST,NORTH`.
///
/// # Errors
///
/// How it is written.
pub fn point(text: &str) -> Result<Pair, Words> {
    let read = || {
        let (drawn, site) = text.split_once('=')?;
        Some(Pair { drawn: numbers(drawn)?, site: numbers(site)? })
    };
    known(read(), text::WrittenPoint)
}

/// `LATITUDE,LONGITUDE`.
///
/// # Errors
///
/// How it is written, or that there is no such place.
pub fn on_earth(text: &str) -> Result<Geodetic, Words> {
    let [latitude, longitude] = known(numbers(text), text::WrittenOnEarth)?;
    Geodetic::new(latitude, longitude).map_err(|problem| problem.what)
}

/// `X,Y=LATITUDE,LONGITUDE`.
///
/// # Errors
///
/// How it is written, or that there is no such place.
pub fn geo(text: &str) -> Result<([f64; 2], Geodetic), Words> {
    let (drawn, place) = known(text.split_once('='), text::WrittenGeo)?;
    Ok((known(numbers(drawn), text::WrittenGeo)?, on_earth(place)?))
}

/// `X,Y,X,Y=METRES`.
///
/// # Errors
///
/// How it is written.
pub fn distance(text: &str) -> Result<Distance, Words> {
    let read = || {
        let (ends, metres) = text.split_once('=')?;
        let [a, b, c, d] = numbers(ends)?;
        let [metres] = numbers(metres)?;
        Some(Distance { ends: [[a, b], [c, d]], metres })
    };
    known(read().filter(|it| it.metres > 0.0), text::WrittenDistance)
}

/// `NAME=ROLE` or `NAME=ROLE:HEIGHT`.
///
/// # Errors
///
/// How it is written.
pub fn layer(text: &str) -> Result<Chosen, Words> {
    let read = || {
        let (name, rest) = text.rsplit_once('=')?;
        let (role, height) = match rest.split_once(':') {
            Some((role, height)) => (role, Some(height)),
            None => (rest, None),
        };
        let height_m = match height {
            Some(height) => Some(numbers::<1>(height)?[0]),
            None => None,
        };
        let role = Role::by_name(role.trim())?;
        Some(Chosen { layer: name.trim().to_owned(), role, height_m })
    };
    known(read(), text::WrittenLayer { roles: roles() })
}

/// `ROLE:NAME=X,Y…` or `ROLE:NAME:HEIGHT=X,Y…`.
///
/// # Errors
///
/// How it is written.
pub fn mark(text: &str) -> Result<Mark, Words> {
    let read = || {
        let (head, places) = text.rsplit_once('=')?;
        let mut head = head.splitn(3, ':');
        let (role, name, height) = (head.next()?, head.next()?, head.next());
        let height_m = match height {
            Some(height) => Some(numbers::<1>(height)?[0]),
            None => None,
        };
        let flat = list(places).filter(|it| it.len() % 2 == 0)?;
        let points = flat.chunks(2).map(|it| [it[0], it[1]]).collect();
        let (role, name) = (Role::by_name(role.trim())?, crate::shape::name(name));
        Some(Mark { role, name, height_m, points }).filter(|it| !it.name.is_empty())
    };
    known(read(), text::WrittenMark { roles: roles() })
}

fn roles() -> String {
    Role::ALL.map(Role::name).join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let pair = point("10.5,-20=0,1e2").unwrap();
        assert_eq!((pair.drawn, pair.site), ([10.5, -20.0], [0.0, 100.0]));
        assert_eq!(distance("0,0,3,4=5").unwrap().ends[1], [3.0, 4.0]);
        assert_eq!(geo("1,2=59.9,30.3").unwrap().1.longitude, 30.3);
        let tanks = layer("A=B=tank:12.5").unwrap();
        assert_eq!(
            (tanks.layer.as_str(), tanks.role, tanks.height_m),
            ("A=B", Role::Tank, Some(12.5))
        );
        assert_eq!(layer("M=monitor").unwrap().height_m, None);
        let tank = mark("tank:T-1:12=640,420,700,420").unwrap();
        assert_eq!((tank.name.as_str(), tank.points.len()), ("T-1", 2));
        assert_eq!(mark("monitor:M1=1,2").unwrap().height_m, None);
    }

    #[test]
    fn what_is_not_so_says_how_it_is_written() {
        for text in ["", "1", "1,2", "1,2=3", "1,2=3,nan", "1;2=3;4", "1,2=3,4,5", "inf,0=0,0"] {
            assert!(point(text).unwrap_err().en.contains("X,Y=EAST,NORTH"), "{text}");
        }
        assert!(geo("1,2=95,30").is_err() && on_earth("30").is_err());
        assert!(
            distance("0,0,3,4=-5").is_err() && layer("A=lake:2").is_err() && layer("A").is_err()
        );
        assert!(mark("tank:T-1:12=640,420,700").is_err() && mark("tank:=1,2").is_err());
    }
}
