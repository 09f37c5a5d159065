//! GeoJSON: features with their geometry, and of their properties layer, name and height.

use std::fmt;

use lafet_texts::drawing as text;
use serde::Deserialize;
use serde::de::{self, IgnoredAny, MapAccess, SeqAccess, Visitor};

use crate::shape::{Builder, Drawing, Format, Geometry, Height, Shape};
use crate::{DEPTH_MAX, Limits, Problem};

/// Names of reference systems that are WGS 84 with the longitude first.
const WGS84: [&str; 4] = ["CRS84", "4326", "OGC:1.3:CRS84", "WGS84"];
/// Objects of the file for a shape of it, and lists besides its positions.
const PARTS: usize = 4;

pub fn read(bytes: &[u8], limits: &Limits) -> Result<Drawing, Problem> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    // What is read takes far more memory than empty lists and objects do as text.
    let count = |letter: u8| bytes.iter().filter(|it| **it == letter).count();
    let parts = limits.shapes.saturating_mul(PARTS).saturating_add(PARTS);
    if count(b'{') > parts || count(b'[') > parts.saturating_add(limits.points) {
        let Limits { shapes, points, .. } = *limits;
        return Err(Problem::new(text::TooMuch { shapes, points }, text::TooMuchRemedy));
    }
    let object: Object = serde_json::from_slice(bytes).map_err(|error| {
        let (line, column) = (error.line(), error.column());
        Problem::at(line, text::NotGeoJson { column }, text::NotGeoJsonRemedy)
    })?;
    let mut builder = Builder::new(Format::GeoJson, limits);
    if let Some(name) = object.crs.and_then(|it| it.properties).and_then(|it| it.name) {
        let known = WGS84.iter().any(|it| name.to_ascii_uppercase().ends_with(it));
        builder.drawing.reference = (!known).then(|| crate::shape::name(&name));
    }
    match object.kind.as_str() {
        "FeatureCollection" => {
            for feature in object.features.unwrap_or_default() {
                add_feature(&mut builder, feature)?;
            }
        }
        "Feature" => {
            let Object { properties, geometry, .. } = object;
            add_feature(&mut builder, Feature { properties, geometry })?;
        }
        _ => {
            let Object { kind, coordinates, geometries, .. } = object;
            let feature = Feature {
                properties: None,
                geometry: Some(Shaped { kind, coordinates, geometries }),
            };
            add_feature(&mut builder, feature)?;
        }
    }
    Ok(builder.drawing)
}

/// The whole: a collection, a feature or a geometry.
#[derive(Deserialize)]
struct Object {
    #[serde(rename = "type")]
    kind: String,
    crs: Option<Reference>,
    features: Option<Vec<Feature>>,
    properties: Option<Properties>,
    geometry: Option<Shaped>,
    coordinates: Option<Coordinates>,
    geometries: Option<Vec<Shaped>>,
}

#[derive(Deserialize)]
struct Reference {
    properties: Option<ReferenceName>,
}

#[derive(Deserialize)]
struct ReferenceName {
    name: Option<String>,
}

#[derive(Deserialize)]
struct Feature {
    properties: Option<Properties>,
    geometry: Option<Shaped>,
}

#[derive(Deserialize)]
struct Shaped {
    #[serde(rename = "type")]
    kind: String,
    coordinates: Option<Coordinates>,
    geometries: Option<Vec<Shaped>>,
}

/// What of the properties is used, whatever the capitals of their names; of several the first.
#[derive(Default)]
struct Properties {
    layer: Option<Word>,
    name: Option<Word>,
    height: Option<Word>,
}

impl<'de> Deserialize<'de> for Properties {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Named)
    }
}

struct Named;

impl<'de> Visitor<'de> for Named {
    type Value = Properties;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("properties")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Properties, A::Error> {
        let mut properties = Properties::default();
        while let Some(key) = map.next_key::<String>()? {
            let place = match key.to_ascii_lowercase().as_str() {
                "layer" => Some(&mut properties.layer),
                "name" => Some(&mut properties.name),
                "height" => Some(&mut properties.height),
                _ => None,
            };
            match place.filter(|it| it.is_none()) {
                Some(place) => *place = Some(map.next_value()?),
                None => _ = map.next_value::<IgnoredAny>()?,
            }
        }
        Ok(properties)
    }
}

/// What a property may be; what is neither text nor number is not used, and not kept.
enum Word {
    Text(String),
    Number(f64),
    Other,
}

impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyWord)
    }
}

struct AnyWord;

impl<'de> Visitor<'de> for AnyWord {
    type Value = Word;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a property")
    }

    fn visit_str<E>(self, value: &str) -> Result<Word, E> {
        Ok(Word::Text(value.to_owned()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Word, E> {
        Ok(Word::Number(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Word, E> {
        Ok(Word::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Word, E> {
        Ok(Word::Number(value as f64))
    }

    fn visit_bool<E>(self, _: bool) -> Result<Word, E> {
        Ok(Word::Other)
    }

    fn visit_unit<E>(self) -> Result<Word, E> {
        Ok(Word::Other)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Word, A::Error> {
        while seq.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Word::Other)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Word, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Word::Other)
    }
}

impl Word {
    fn text(&self) -> Option<String> {
        match self {
            Self::Text(text) => Some(text.clone()),
            Self::Number(number) => Some(number.to_string()),
            Self::Other => None,
        }
    }

    /// Metres: a number, or one with its unit as OpenStreetMap writes it.
    fn metres(&self) -> Option<f64> {
        let metres = match self {
            Self::Number(number) => Some(*number),
            Self::Text(text) => {
                let text = text.trim();
                text.strip_suffix('m').unwrap_or(text).trim().parse().ok()
            }
            Self::Other => None,
        };
        metres.filter(|it: &f64| it.is_finite() && *it > 0.0)
    }
}

/// A position, or a list of what has positions.
enum Coordinates {
    Position([f64; 3]),
    List(Vec<Coordinates>),
}

/// A part of a position, or another list.
enum Part {
    Number(f64),
    Inner(Coordinates),
}

impl<'de> Deserialize<'de> for Coordinates {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(List)
    }
}

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Any)
    }
}

struct List;
struct Any;

impl<'de> Visitor<'de> for List {
    type Value = Coordinates;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("coordinates")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Coordinates, A::Error> {
        let mut position = [f64::NAN, f64::NAN, 0.0];
        let mut count = 0;
        let mut list = Vec::new();
        while let Some(part) = seq.next_element::<Part>()? {
            match part {
                Part::Number(number) if list.is_empty() => {
                    if let Some(place) = position.get_mut(count) {
                        *place = number;
                    }
                    count += 1;
                }
                Part::Inner(inner) if count == 0 => list.push(inner),
                Part::Number(_) | Part::Inner(_) => {
                    return Err(de::Error::custom("numbers beside lists"));
                }
            }
        }
        match count {
            0 => Ok(Coordinates::List(list)),
            1 => Err(de::Error::custom("a position has two numbers or more")),
            _ => Ok(Coordinates::Position(position)),
        }
    }
}

impl<'de> Visitor<'de> for Any {
    type Value = Part;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a list")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Part, E> {
        Ok(Part::Number(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Part, E> {
        Ok(Part::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Part, E> {
        Ok(Part::Number(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Part, A::Error> {
        List.visit_seq(seq).map(Part::Inner)
    }
}

/// What the shapes of a feature have in common.
struct Common {
    layer: usize,
    name: Option<String>,
    height: Option<Height>,
}

fn add_feature(builder: &mut Builder<'_>, feature: Feature) -> Result<(), Problem> {
    let properties = feature.properties.unwrap_or_default();
    let Some(geometry) = feature.geometry else { return Ok(()) };
    let Properties { layer, name, height } = properties;
    let of = |word: Option<Word>| word.as_ref().and_then(Word::text);
    let layer = of(layer).unwrap_or_default();
    let common = Common {
        layer: builder.layer(&layer)?,
        name: of(name).map(|it| crate::shape::name(&it)),
        height: height.as_ref().and_then(Word::metres).map(Height::Metres),
    };
    add_geometry(builder, &common, geometry, 0)
}

fn add_geometry(
    builder: &mut Builder<'_>,
    common: &Common,
    shaped: Shaped,
    depth: usize,
) -> Result<(), Problem> {
    if shaped.kind == "GeometryCollection" {
        if depth >= DEPTH_MAX {
            let (block, most) = (shaped.kind, DEPTH_MAX);
            return Err(Problem::new(text::TooDeep { block, most }, text::TooDeepRemedy));
        }
        return shaped
            .geometries
            .unwrap_or_default()
            .into_iter()
            .try_for_each(|it| add_geometry(builder, common, it, depth + 1));
    }
    // How deep the lists of a kind are, and whether they close.
    let (lists, closed) = match shaped.kind.as_str() {
        "Point" => (0, false),
        "MultiPoint" => (1, false),
        "LineString" => (0, false),
        "MultiLineString" => (1, false),
        "Polygon" => (1, true),
        "MultiPolygon" => (2, true),
        other => {
            builder.skip(other);
            return Ok(());
        }
    };
    let points = shaped.kind.ends_with("Point");
    let Some(coordinates) = shaped.coordinates else { return Err(wrong(&shaped.kind)) };
    let form = Form { points, closed, kind: &shaped.kind };
    add_coordinates(builder, common, coordinates, lists, &form)
}

struct Form<'a> {
    points: bool,
    closed: bool,
    kind: &'a str,
}

fn add_coordinates(
    builder: &mut Builder<'_>,
    common: &Common,
    coordinates: Coordinates,
    lists: usize,
    form: &Form<'_>,
) -> Result<(), Problem> {
    let geometry = match coordinates {
        Coordinates::List(inner) if lists > 0 => {
            return inner
                .into_iter()
                .try_for_each(|it| add_coordinates(builder, common, it, lists - 1, form));
        }
        Coordinates::Position([x, y, _]) if lists == 0 && form.points => Geometry::Point([x, y]),
        Coordinates::List(positions) if lists == 0 && !form.points => {
            let mut points = Vec::new();
            for it in positions {
                let Coordinates::Position([x, y, _]) = it else { return Err(wrong(form.kind)) };
                points.push([x, y]);
            }
            let twice = form.closed && points.len() > 1 && points.first() == points.last();
            if twice {
                points.pop();
            }
            Geometry::Path { points, closed: form.closed }
        }
        Coordinates::Position(_) | Coordinates::List(_) => return Err(wrong(form.kind)),
    };
    let Common { layer, name, height } = common;
    let shape = Shape {
        layer: *layer,
        name: name.clone(),
        geometry,
        height: *height,
        base: None,
        part: false,
    };
    builder.add(shape, 0)
}

fn wrong(kind: &str) -> Problem {
    let kind = crate::shape::name(kind);
    Problem::new(text::WrongCoordinates { kind }, text::NotGeoJsonRemedy)
}
