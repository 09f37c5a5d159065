//! What is on a site: walls, tanks, and what shines without burning.

use lafet_texts::{Text as _, sim as text};

use super::file::fresh_name;
use super::plan::Exercise;
use super::reader::{Problem, Table};
use crate::obstacle::{Obstacle, Shape};
use crate::site::SiteGlare;

/// Reads `[[tank]]`, `[[wall]]` and `[[glare]]`.
pub fn read(exercise: &mut Exercise, root: &Table<'_>) -> Result<(), Problem> {
    for table in root.tables("tank")? {
        let name = fresh_name(&table, &exercise.obstacles)?;
        let [x, y] = table.needed_numbers("at")?;
        let diameter_m = table.needed("diameter", 0.5, 120.0)?;
        let height_m = table.needed("height", 0.2, 60.0)?;
        exercise.obstacles.push(name);
        let shape = Shape::Tank((x, y), diameter_m);
        exercise.site.obstacles.push(Obstacle { shape, height_m });
        table.finish()?;
    }
    for table in root.tables("wall")? {
        let name = fresh_name(&table, &exercise.obstacles)?;
        let points = table.places("points")?;
        let height_m = table.needed("height", 0.2, 60.0)?;
        if points.len() < 2 {
            let what = text::TwoPlaces.words();
            return Err(table.wrong("points", what));
        }
        for ends in points.windows(2) {
            // Each stretch is an obstacle; the name is at the first.
            let first = ends[0] == points[0];
            exercise.obstacles.push(if first { name.clone() } else { String::new() });
            let shape = Shape::Wall(ends[0], ends[1]);
            exercise.site.obstacles.push(Obstacle { shape, height_m });
        }
        table.finish()?;
    }
    for table in root.tables("glare")? {
        let name = fresh_name(&table, &exercise.glares)?;
        let glare = if table.has("bearing") {
            SiteGlare::Sun {
                bearing_deg: table.needed("bearing", 0.0, 360.0)?,
                elevation_deg: table.needed("elevation", -10.0, 90.0)?,
                brightness: table.needed("brightness", 1.0, 1e6)?,
            }
        } else {
            let [x, y] = table.needed_numbers("at")?;
            SiteGlare::Hot {
                at: (x, y),
                height_m: table.needed("height", 0.0, 60.0)?,
                size_m: table.needed("size", 0.1, 30.0)?,
                kw: table.needed("kw", 1.0, 1e6)?,
            }
        };
        exercise.glares.push(name);
        exercise.site.glares.push(glare);
        table.finish()?;
    }
    Ok(())
}

/// The middle and the height of a tank's top.
pub const fn top_of(obstacle: &Obstacle) -> Option<((f64, f64), f64)> {
    match obstacle.shape {
        Shape::Tank(middle, _) => Some((middle, obstacle.height_m)),
        Shape::Wall(..) => None,
    }
}
