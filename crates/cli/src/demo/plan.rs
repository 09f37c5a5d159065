//! The plan view: the monitor from above, its field of view, where its water lands, the fires.

use lafet_proto::SubsystemId;
use lafet_proto::flags::DetectorFlags;
use lafet_sim::jet::Landing;
use lafet_texts::cli as text;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::Marker;
use ratatui::widgets::Block;
use ratatui::widgets::canvas::{Canvas, Circle, Context, Line, Points};

use super::scene::Scene;
use crate::lang::current;

/// Least distance shown in front of the monitor, m.
const FRONT_M: f64 = 30.0;
/// Distance shown behind it, m.
const BACK_M: f64 = 3.0;
/// Distance between two arcs, m.
const ARC_M: f64 = 10.0;
/// Length of the barrel in the plan, m; drawn longer than it is.
const BARREL_M: f64 = 4.0;
/// Half the detector's field of view, radians (its parameter FieldOfView is 15°).
const HALF_VIEW: f64 = 0.131;
/// Dots of the raster per character cell, across and down.
const DOTS: (f64, f64) = (2.0, 4.0);

/// Draws the plan.
pub fn render(frame: &mut Frame<'_>, scene: &Scene, area: Rect) {
    let block = Block::bordered().title(text::PlanTitle.str(current()));
    let inner = block.inner(area);
    let fires = scene.world.fires.iter();
    let farthest = fires.map(|(at, ..)| at.0.hypot(at.1)).fold(FRONT_M, f64::max) * 1.15;
    let (dots_x, dots_y) = (f64::from(inner.width) * DOTS.0, f64::from(inner.height) * DOTS.1);
    // One scale for both directions, so that circles are round.
    let scale = ((farthest + BACK_M) / dots_y.max(1.0)).max(1.2 * farthest / dots_x.max(1.0));
    let half = scale * dots_x / 2.0;
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds([-half, half])
        .y_bounds([-BACK_M, scale * dots_y - BACK_M])
        .paint(|context| paint(context, scene, farthest));
    frame.render_widget(canvas, area);
}

/// Canvas coordinates of a place (forward, left), m: forward is up, left is left.
const fn place((forward, left): (f64, f64)) -> (f64, f64) {
    (-left, forward)
}

fn towards(azimuth: f64, range_m: f64) -> (f64, f64) {
    place((range_m * azimuth.cos(), range_m * azimuth.sin()))
}

fn ray(context: &mut Context<'_>, azimuth: f64, range_m: f64, color: Color) {
    let (x2, y2) = towards(azimuth, range_m);
    context.draw(&Line { x1: 0.0, y1: 0.0, x2, y2, color });
}

fn paint(context: &mut Context<'_>, scene: &Scene, farthest: f64) {
    let world = &scene.world;
    let arcs = (farthest / ARC_M) as u32;
    for arc in 1..=arcs {
        let radius = f64::from(arc) * ARC_M;
        let points: Vec<(f64, f64)> =
            (-45..=45).map(|step| towards(f64::from(step) / 30.0, radius)).collect();
        context.draw(&Points { coords: &points, color: Color::DarkGray });
        context.print(0.0, radius, format!("{radius:.0}"));
    }
    context.layer();
    let detector = DetectorFlags::from_bits_retain(scene.flags(SubsystemId::DETECTOR));
    if detector.contains(DetectorFlags::SEARCHING) && world.deployed {
        ray(context, world.azimuth - HALF_VIEW, farthest, Color::Green);
        ray(context, world.azimuth + HALF_VIEW, farthest, Color::Green);
    }
    for (at, size_m, heat) in &world.fires {
        let (x, y) = place(*at);
        let color = if *heat > 0.0 { Color::Red } else { Color::DarkGray };
        for part in [1.0, 0.6, 0.2] {
            context.draw(&Circle { x, y, radius: part * size_m / 2.0, color });
        }
        let label = match *heat > 0.0 {
            true => format!(" {:.0} %", heat * 100.0),
            false => text::PlanOut.str(current()).to_owned(),
        };
        context.print(x, y, label);
    }
    if let Some(landing) = &world.landing {
        jet(context, landing);
    }
    let barrel_m = if world.deployed { BARREL_M } else { BARREL_M / 4.0 };
    ray(context, world.azimuth, barrel_m, Color::White);
    context.draw(&Circle { x: 0.0, y: 0.0, radius: 0.8, color: Color::White });
}

/// The path of the water and the ellipse that it wets.
fn jet(context: &mut Context<'_>, landing: &Landing) {
    let (x2, y2) = place(landing.at);
    context.draw(&Line { x1: 0.0, y1: 0.0, x2, y2, color: Color::Blue });
    let (sin, cos) = landing.heading.sin_cos();
    let edge: Vec<(f64, f64)> = (0..48)
        .map(|step| {
            let angle = f64::from(step) * std::f64::consts::TAU / 48.0;
            let (along, across) = (landing.along_m * angle.cos(), landing.across_m * angle.sin());
            let forward = landing.at.0 + along * cos - across * sin;
            let left = landing.at.1 + along * sin + across * cos;
            place((forward, left))
        })
        .collect();
    context.draw(&Points { coords: &edge, color: Color::LightBlue });
}
