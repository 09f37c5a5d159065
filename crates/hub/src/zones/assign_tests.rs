use super::super::fires::FireStanding;
use super::*;

fn place(standing: FireStanding, at: [f64; 2]) -> FirePlace {
    FirePlace {
        zone: "hall".into(),
        standing,
        at,
        height_m: None,
        major_m: 0.5,
        minor_m: 0.3,
        direction_deg: 0.0,
        detectors: Vec::new(),
    }
}

fn sure(at: [f64; 2]) -> FirePlace {
    place(FireStanding::Sure, at)
}

fn known(plan: &Plan) -> Vec<(u64, [f64; 2])> {
    plan.fires.iter().map(|it| (it.number, it.at)).collect()
}

fn s(after: u64) -> Now {
    Now::from_secs(100 + after)
}

/// Before the zone has water.
fn see(plan: &mut Plan, places: &[FirePlace], now: Now) {
    plan.see(places, now, false, |_| None);
}

#[test]
fn a_fire_is_out_when_it_is_not_seen_while_another_one_is() {
    let (a, b) = (sure([0.0, 20.0]), sure([30.0, 20.0]));
    let mut plan = Plan::default();
    see(&mut plan, &[a.clone(), b.clone()], s(0));
    assert_eq!(known(&plan), [(1, a.at), (2, b.at)]);
    see(&mut plan, &[place(FireStanding::Doubtful, a.at)], s(50));
    assert_eq!(plan.fires.len(), 2, "steam hides both");
    see(&mut plan, std::slice::from_ref(&b), s(52));
    see(&mut plan, std::slice::from_ref(&b), s(56));
    assert_eq!(plan.fires.len(), 2);
    see(&mut plan, std::slice::from_ref(&b), s(57));
    assert_eq!(known(&plan), [(2, b.at)]);
    see(&mut plan, &[a], s(58));
    assert_eq!(plan.fires[1].number, 3, "a new one");
    see(&mut plan, &[], s(118));
    assert_eq!(known(&plan), [], "no sight of any for a minute");
}

/// Steam hides a fire, and what the water suffices for has to be known for as long as it flows.
#[test]
fn the_last_fire_is_planned_for_while_there_is_water() {
    let (a, b) = (sure([0.0, 20.0]), sure([30.0, 20.0]));
    for (wet, left) in [(true, 1), (false, 0)] {
        let mut plan = Plan::default();
        plan.see(&[a.clone(), b.clone()], s(0), false, |_| None);
        for after in 1..=90 {
            plan.see(
                if after < 10 { std::slice::from_ref(&b) } else { &[] },
                s(after),
                wet,
                |_| None,
            );
        }
        let known: Vec<_> = plan.counted().map(|it| it.at).collect();
        assert_eq!(known, vec![b.at; left], "{wet}");
    }
}

/// Whatever another one does meanwhile: only the time counts in which it is seen.
#[test]
fn a_fire_goes_out_while_another_one_flickers() {
    let (a, b) = (sure([0.0, 20.0]), sure([30.0, 20.0]));
    let mut plan = Plan::default();
    see(&mut plan, &[a, b.clone()], s(0));
    for after in 1..=10 {
        assert_eq!(plan.fires.len(), 2, "{after}");
        let seen = if after % 2 == 1 { std::slice::from_ref(&b) } else { &[] };
        see(&mut plan, seen, s(after));
    }
    assert_eq!(known(&plan), [(2, b.at)]);
}

#[test]
fn a_fire_that_moves_is_the_same_one_until_no_jet_scans_it() {
    let mut plan = Plan::default();
    see(&mut plan, &[sure([0.0, 20.0])], s(0));
    plan.by.insert("M1".into(), 1);
    see(&mut plan, &[sure([1.5, 20.0])], s(1));
    assert_eq!(known(&plan), [(1, [0.0, 20.0])], "not far enough for another plan");
    assert_eq!(plan.fires[0].place.at, [1.5, 20.0], "but aimed at where it is");
    see(&mut plan, &[sure([4.0, 20.0])], s(2));
    assert_eq!(known(&plan), [(1, [4.0, 20.0])]);
    see(&mut plan, &[sure([8.0, 20.0])], s(3));
    assert_eq!(known(&plan), [(2, [8.0, 20.0])]);
    assert_eq!(plan.by["M1"], 2, "its monitor stays its");
    let wide = FirePlace { major_m: 60.0, ..sure([30.0, 20.0]) };
    see(&mut plan, &[wide], s(4));
    assert_eq!(plan.fires.len(), 2, "however wide its ellipse");
}

#[test]
fn a_full_table_of_fires_that_are_not_seen_has_room_for_a_new_one() {
    let mut plan = Plan::default();
    let many: Vec<_> = (0..9).map(|n| sure([20.0 * f64::from(n), 50.0])).collect();
    see(&mut plan, &many, s(0));
    assert_eq!(plan.fires.len(), FIRES_MAX);
    let new = sure([0.0, -50.0]);
    for after in 1..=6 {
        see(&mut plan, std::slice::from_ref(&new), s(after));
    }
    assert_eq!(known(&plan), [(5, new.at)]);
}

/// A detector that turns to another fire crosses the old bearing of the other one where nothing burns.
#[test]
fn while_a_zone_has_water_one_sight_is_no_fire() {
    let cross = |at| FirePlace { detectors: vec!["D1".into(), "D2".into()], ..sure(at) };
    let fire = cross([0.0, 20.0]);
    let mut plan = Plan::default();
    let heard = |at: [u64; 2]| move |id: &str| Some(s(at[usize::from(id == "D2")]));
    plan.see(std::slice::from_ref(&fire), s(0), false, heard([0, 0]));
    assert!(plan.fires[0].counts, "the first ones count at once");
    let ghost = cross([30.0, 20.0]);
    for now in 10..20 {
        plan.see(std::slice::from_ref(&ghost), s(now), true, heard([now, 9]));
        assert_eq!(plan.counted().filter(|it| it.at == ghost.at).count(), 0, "{now}");
    }
    let new = cross([60.0, 20.0]);
    for (now, counts) in [(20, false), (21, false), (22, true)] {
        plan.see(std::slice::from_ref(&new), s(now), true, heard([now, now]));
        assert_eq!(plan.counted().any(|it| it.at == new.at), counts, "{now}");
    }
}

#[test]
fn a_plan_is_for_its_fires_monitors_wind_and_pressure() {
    let wind = |from: f64, speed_mps| Wind { from: from.to_radians(), speed_mps };
    let able: BTreeSet<String> = ["M1".to_owned(), "M2".to_owned()].into();
    let (fires, wind_now) = (vec![(1, [0.0, 20.0])], wind(350.0, 6.0));
    let basis = Basis { fires, able, wind: wind_now, pressure_mpa: 0.8 };
    let like = |change: &dyn Fn(&mut Basis)| {
        let mut other = basis.clone();
        change(&mut other);
        basis.is_like(&other)
    };
    assert!(like(&|_| {}));
    assert!(like(&|it| it.wind = wind(2.0, 6.0)));
    assert!(!like(&|it| it.wind = wind(10.0, 6.0)));
    assert!(!like(&|it| it.wind = wind(350.0, 8.0)));
    assert!(like(&|it| it.pressure_mpa = 0.74));
    assert!(!like(&|it| it.pressure_mpa = 0.7));
    assert!(!like(&|it| it.fires[0].1 = [0.0, 22.5]));
    assert!(!like(&|it| it.fires[0].0 = 2));
    assert!(!like(&|it| _ = it.able.remove("M2")));
}

/// M2 is lost, M4 is idle: neither takes a fire from M3, which replaces them.
#[test]
fn monitors_that_are_not_there_take_no_fire() {
    let text = (1..=5).map(|n| format!("\"M{n}\"")).collect::<Vec<_>>().join(", ");
    let config = format!(
        "monitors = [{text}]\n[[detector]]\nid = \"d\"\nkind = \"flame\"\nzones = [\"hall\"]\n\
         [[zone]]\nid = \"hall\"\nvotes = \"1oo1\"\none_detector_releases = true\nmonitors = [{text}]\nwater_max_s = 60\n"
    );
    let config: lafet_site::Config = toml::from_str(&config).unwrap();
    let zone = config.zones[0].clone();
    let (site, _) = lafet_site::Site::new(config, 0, None).unwrap();
    let mut state = site.state();
    for it in &mut state.monitors {
        it.withheld = None;
    }
    let ids = |state: &State, of| {
        present(state, &zone, of).into_iter().map(String::as_str).collect::<Vec<_>>()
    };
    state.monitors[1].withheld = Some(Withheld::Unreachable);
    state.troubles = vec![lafet_site::TroubleState {
        trouble: Trouble::MonitorIdle,
        subject: "M4".into(),
        since_ms: 0,
        active: true,
    }];
    assert_eq!(ids(&state, "M3"), ["M1", "M3", "M5"], "before the release");
    for engaged in [0, 1, 3] {
        state.monitors[engaged].engaged_for = Some("hall".into());
    }
    assert_eq!(ids(&state, "M3"), ["M1", "M3"], "M5 is at rest");
}
