use super::*;
use crate::fault::{Fault, SingleFault};
use lafet_device::Source;
use lafet_proto::record::Writer;
use lafet_proto::text;

const MAIN: SupplySpec = SupplySpec { closed_mpa: 1.0, flow_lps: 40.0, pressure_mpa: 0.8 };

fn monitor(at: (f64, f64), heading_deg: f64) -> MonitorConfig {
    let sim =
        Config { composition: lafet_device::composition::Composition::REMOTE, ..Config::default() };
    MonitorConfig { pose: Pose { at, heading_deg }, sim, ..MonitorConfig::default() }
}

fn fire(at: (f64, f64)) -> SiteFire {
    SiteFire { at, spec: FireSpec { size_m: 1.5, ..FireSpec::default() }, on: None }
}

fn send(site: &mut Site, monitor: usize, request: &str) {
    let (mut buffer, mut record) = ([0; text::BUFFER_SIZE], [0; 260]);
    let mut writer = Writer::new(&mut record);
    text::parse(request, &mut buffer).unwrap().encode(&mut writer).unwrap();
    site.members[monitor].sim.request(Source::ExternalConn, writer.written());
}

/// North of a monitor that faces east is on its left, and everything leads back.
#[test]
fn poses() {
    let pose = Pose { at: (10.0, 5.0), heading_deg: 90.0 };
    let local = pose.local((30.0, 25.0));
    assert!((local.0 - 20.0).abs() < 1e-9 && (local.1 - 20.0).abs() < 1e-9, "{local:?}");
    let back = pose.site(local);
    assert!((back.0 - 30.0).abs() < 1e-9 && (back.1 - 25.0).abs() < 1e-9, "{back:?}");
    assert!((pose.azimuth_deg(45.0) - 45.0).abs() < 1e-9);
    assert!((pose.azimuth_deg(350.0) - 100.0).abs() < 1e-9);
    let from = WindSpec { from_deg: 270.0, speed_mps: 4.0, gusts_mps: 0.0 };
    let wind = Wind::new(from, 1).now_mps();
    assert!((wind.0 - 4.0).abs() < 1e-9 && wind.1.abs() < 1e-9, "a west wind blows east");
    assert!((pose.turned(wind).0 - 4.0).abs() < 1e-9);
}

/// Two monitors face each other across a fire: both throw at it, both count, either alone takes
/// longer.
#[test]
fn the_water_of_all_counts() {
    let out_ms = |open: &[usize]| {
        let monitors = vec![monitor((0.0, -31.0), 0.0), monitor((0.0, 31.0), 180.0)];
        let mut site = Site::new(SiteConfig {
            fires: vec![SiteFire {
                spec: FireSpec { size_m: 6.0, ..FireSpec::default() },
                ..fire((0.0, 0.0))
            }],
            monitors,
            ambient_c: 20.0,
            ..SiteConfig::default()
        });
        for index in open {
            site.members[*index].sim.world_mut().drives[0].position = 360.0;
            send(&mut site, *index, "Open Valve1");
        }
        for _ in 0..300 {
            site.advance_ms(1_000);
            if !site.fires[0].burns() {
                return Some(site.now_ms());
            }
        }
        None
    };
    let (one, other, both) = (out_ms(&[0]), out_ms(&[1]), out_ms(&[0, 1]));
    assert_eq!(one, other, "the site is symmetric");
    assert!(both.unwrap() + 5_000 < one.unwrap(), "{both:?} {one:?}");
    assert_eq!(out_ms(&[]), None);
}

/// A main for two: the second that opens takes pressure from the first.
#[test]
fn a_shared_main_gives_less_to_each() {
    let at = |x: f64| MonitorConfig { supply: Some(0), ..monitor((x, 0.0), 0.0) };
    let mut site = Site::new(SiteConfig {
        supplies: vec![MAIN],
        monitors: vec![at(0.0), at(20.0), at(40.0)],
        ..SiteConfig::default()
    });
    let mut pressures = Vec::new();
    for index in 0..3 {
        send(&mut site, index, "Open Valve1");
        site.advance_ms(12_000);
        pressures.push(site.members[0].sim.world().water.pressure_mpa);
    }
    assert!(pressures.is_sorted_by(|a, b| a > b), "{pressures:?}");
    assert!(pressures[0] > 0.75 && pressures[2] < 0.8 * pressures[0], "{pressures:?}");
    site.supplies[0].share = 0.0;
    site.advance_ms(10_000);
    assert!(site.members.iter().all(|member| member.sim.world().water.pressure_mpa < 0.01));
}

/// A wall stops the jet that it hides the fire from; one that is low enough does neither.
#[test]
fn walls_stop_water_and_sight() {
    for (height_m, burns) in [(8.0, true), (0.3, false)] {
        let shape = Shape::Wall((-5.0, 20.0), (5.0, 20.0));
        let mut site = Site::new(SiteConfig {
            obstacles: vec![Obstacle { shape, height_m }],
            fires: vec![fire((0.0, 31.0))],
            monitors: vec![monitor((0.0, 0.0), 0.0)],
            ..SiteConfig::default()
        });
        let world = site.members[0].sim.world_mut();
        world.drives[0].position = 360.0;
        site.advance_ms(100);
        let seen = site.members[0].sim.world().inputs().detector.spots[0].is_some();
        assert_eq!(seen, !burns, "{height_m}");
        send(&mut site, 0, "Open Valve1");
        site.advance_ms(60_000);
        assert_eq!(site.fires[0].burns(), burns, "{height_m}");
        assert_eq!(site.splashes()[0].stopped_by.is_some(), burns, "{height_m}");
    }
}

/// Water that passes the edge of a tank falls on its top, and nothing behind it gets any.
#[test]
fn a_tank_catches_what_falls_into_it() {
    let tank = |middle| Obstacle { shape: Shape::Tank(middle, 8.0), height_m: 3.0 };
    let on_top = SiteFire { on: Some(0), ..fire((0.0, 36.0)) };
    let on_top = SiteFire { spec: FireSpec { base_m: 3.0, ..on_top.spec }, ..on_top };
    let mut site = Site::new(SiteConfig {
        obstacles: vec![tank((0.0, 36.0)), tank((40.0, 36.0))],
        fires: vec![on_top, SiteFire { on: Some(1), ..on_top }, fire((0.0, 41.5))],
        monitors: vec![monitor((0.0, 0.0), 0.0)],
        ..SiteConfig::default()
    });
    site.members[0].sim.world_mut().drives[0].position = 900.0;
    send(&mut site, 0, "Open Valve1");
    site.advance_ms(8_000);
    let splash = &site.splashes()[0];
    assert_eq!(splash.stopped_by, Some(0), "{splash:?}");
    assert!((splash.portion.landing.at.1 - 36.0).abs() < 3.0, "{splash:?}");
    site.advance_ms(40_000);
    let burning: Vec<bool> = site.fires.iter().map(Fire::burns).collect();
    assert_eq!(burning, [false, true, true]);
}

/// Each monitor sees the fire in its own coordinates.
#[test]
fn a_fire_is_seen_from_everywhere() {
    let site = Site::new(SiteConfig {
        fires: vec![fire((10.0, 20.0))],
        monitors: vec![monitor((0.0, 20.0), 90.0), monitor((10.0, 0.0), 330.0)],
        ..SiteConfig::default()
    });
    let seen: Vec<(f64, f64)> = site
        .members
        .iter()
        .map(|member| member.sim.world().fires[0].spec)
        .map(|spec| (spec.azimuth_deg, spec.range_m))
        .collect();
    assert!(seen[0].0.abs() < 1e-9 && (seen[0].1 - 10.0).abs() < 1e-9, "{seen:?}");
    assert!((seen[1].0 + 30.0).abs() < 1e-9 && (seen[1].1 - 20.0).abs() < 1e-9, "{seen:?}");
}

#[test]
fn same_seed_same_site() {
    let run = |seed| {
        let wind = WindSpec { from_deg: 200.0, speed_mps: 3.0, gusts_mps: 2.0 };
        let monitors = vec![monitor((0.0, -25.0), 0.0), monitor((0.0, 25.0), 180.0)];
        let fires = vec![fire((0.0, 0.0))];
        let mut site =
            Site::new(SiteConfig { seed, wind, monitors, fires, ..SiteConfig::default() });
        send(&mut site, 0, "Open Valve1");
        site.members[1].sim.world_mut().inject(Fault::Single(SingleFault::DirtyLens));
        site.advance_ms(8_000);
        site.members.iter().map(|member| member.sim.trace_line()).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(run(3), run(3));
    assert_ne!(run(3), run(4));
}

/// Without power nothing is answered; with it the monitor starts again.
#[test]
fn power_cut() {
    let mut site =
        Site::new(SiteConfig { monitors: vec![monitor((0.0, 0.0), 0.0)], ..SiteConfig::default() });
    send(&mut site, 0, "Open Valve1");
    site.advance_ms(5_000);
    let sim = &mut site.members[0].sim;
    sim.power_off();
    assert_eq!(sim.request(Source::Radio, &[0xD4, 0xC2, 0, 0]), Vec::<u8>::new());
    site.advance_ms(5_000);
    assert!(site.members[0].sim.world().valves[0].opening > 0.9, "nothing closes it");
    site.members[0].sim.power_on();
    site.advance_ms(8_000);
    assert!(site.members[0].sim.world().valves[0].opening < 0.01, "closed after power-up");
    assert_eq!(site.now_ms(), site.members[0].sim.now_ms());
}
