//! Wrong installations: good ones with exactly one thing wrong. The check that is for it has to find it.

use std::collections::BTreeSet;
use std::future::Future;
use std::sync::Arc;

use lafet_acceptance::{Stage, check};
use lafet_proto::param::Param;
use serde_json::json;
use tokio::sync::Semaphore;
use tokio::task::JoinSet;

use crate::bench::{Field, Running, Site, failed, shown};

/// So many installations at a time.
const AT_A_TIME: usize = 4;

const READ: &[Stage] = &[Stage::Read];
const DRY: &[Stage] = &[Stage::Read, Stage::Dry];
const OUTLET: &[Stage] = &[Stage::Outlet];

pub struct Wrong {
    pub name: &'static str,
    /// The check that finds it.
    finds: &'static str,
    stages: &'static [Stage],
    site: Site,
}

/// Runs all of them, a few at a time.
pub async fn side_by_side<T: Send + 'static, F: Future<Output = ()> + Send + 'static>(
    all: Vec<T>,
    run: impl Fn(T) -> F,
) {
    let room = Arc::new(Semaphore::new(AT_A_TIME));
    let mut running = JoinSet::new();
    for it in all {
        let (room, one) = (room.clone(), run(it));
        running.spawn(async move {
            let _place = room.acquire_owned().await.unwrap();
            one.await;
        });
    }
    let mut wrong = 0;
    while let Some(ended) = running.join_next().await {
        wrong += usize::from(ended.is_err());
    }
    assert_eq!(wrong, 0, "so many have failed; what each has found is above");
}

fn of(
    name: &'static str,
    finds: &'static str,
    stages: &'static [Stage],
    change: impl FnOnce(&mut Site),
) -> Wrong {
    let mut site = Site::good();
    change(&mut site);
    Wrong { name, finds, stages, site }
}

/// Another line in the file of the hub.
fn filed(name: &'static str, finds: &'static str, from: &str, to: &str) -> Wrong {
    of(name, finds, READ, |it| *it = it.clone().file(from, to))
}

/// Wrong in the file of the hub.
#[rustfmt::skip]
fn configured() -> Vec<Wrong> {
    vec![
        filed("delay left on", "delay", "delay_s = 2\n", "delay_s = 30\n"),
        filed("delay left out", "delay", "delay_s = 2\n", "delay_s = 0\n"),
        filed("hold too long", "delay", "hold_max_s = 60", "hold_max_s = 600"),
        filed("hold switched off", "delay", "hold_max_s = 60", "hold = false"),
        filed("one vote", "two-signals", "votes = \"2oo3\"\nkinds = 2\nwhen_failed = [\"2oo2\", \"alarm\"]", "votes = \"1oo3\"\none_detector_releases = true"),
        filed("all three have to vote", "votes", "votes = \"2oo3\"\nkinds = 2\nwhen_failed = [\"2oo2\", \"alarm\"]", "votes = \"3oo3\"\nkinds = 2"),
        filed("kinds forgotten", "votes", "kinds = 2", "kinds = 1"),
        filed("coincidence too short", "coincidence", "coincidence_s = 5", "coincidence_s = 1"),
        filed("coincidence too long", "coincidence", "coincidence_s = 5", "coincidence_s = 20"),
        filed("a failed detector stops the zone", "when-failed", "when_failed = [\"2oo2\", \"alarm\"]\n", ""),
        filed("water too short", "water-max", "water_max_s = 600", "water_max_s = 60"),
        filed("never back to automatic", "returns", "return_after_s = 7200\n", ""),
        filed("back to automatic too late", "returns", "return_after_s = 7200", "return_after_s = 604800"),
        filed("first start in manual", "mode", "votes = \"2oo3\"", "mode = \"manual\"\nvotes = \"2oo3\""),
        filed("automatic off at the first start", "mode", "votes = \"2oo3\"", "mode = \"off\"\nvotes = \"2oo3\""),
        filed("one jet of two", "served", "kinds = 2\n", "kinds = 2\njets = 1\n"),
        filed("monitors in the wrong order", "served", "monitors = [\"M1\", \"M2\"]", "monitors = [\"M2\", \"M1\"]"),
        filed("one monitor forgotten", "served", "monitors = [\"M1\", \"M2\"]\nvotes", "monitors = [\"M1\"]\nvotes").without_aim("M2"),
        filed("zone valve and outlet exchanged", "served", "valve = \"hall-valve\"\ntest_outlet = \"hall-outlet\"", "valve = \"hall-outlet\"\ntest_outlet = \"hall-valve\""),
        filed("detector of another kind", "detectors", "id = \"flame-east\"\nkind = \"flame\"", "id = \"flame-east\"\nkind = \"smoke\""),
        filed("silence unnoticed", "silence", "id = \"heat\"\n", "id = \"heat\"\nsilent_after_s = 3600\n"),
        filed("place of a detector wrong", "detector-place", "at = [30.0, 0.0, 6.0]", "at = [30.0, 5.0, 6.0]"),
        filed("place of a detector forgotten", "detector-place", "at = [30.0, 0.0, 6.0]\n", ""),
        filed("wrong aim program", "aims", "program = 0", "program = 3"),
        filed("aim to the wrong side", "aims", "horizontal = -2320", "horizontal = 1320"),
        filed("aim too high", "aims", "vertical = 300", "vertical = 1300"),
        filed("aim with a narrow jet", "aims", "nozzle = 60", "nozzle = 10"),
        filed("keep-out missing", "keep-outs", "[[keep_out]]\nname = \"stand\"\nfor = \"people\"\nmonitor = \"M1\"\nbearings = [170.0, 200.0]\n", ""),
        filed("keep-out of the other monitor", "keep-outs", "monitor = \"M1\"\nbearings", "monitor = \"M2\"\nbearings"),
        filed("keep-out too narrow", "keep-outs", "[170.0, 200.0]", "[170.0, 180.0]"),
        filed("heading in the file off by 2°", "place", "heading = 0.0", "heading = 2.0"),
        filed("place in the file off by a metre", "place", "at = [-20.0, 0.0]", "at = [-19.0, 0.0]"),
        filed("height in the file wrong", "place", "height = 2.0", "height = 6.0"),
        filed("pumps in the wrong order", "pumps", "id = \"main\"", "id = \"first\"").renamed(&[("\"second\"", "\"main\""), ("\"first\"", "\"second\"")]),
        filed("delay of a pump forgotten", "pumps", "start_delay_s = 2\n", ""),
        filed("second pump is only a standby", "pumps", "start_delay_s = 2\n", "start_delay_s = 2\nstandby = true\n"),
        filed("abort station is a hold", "contacts", "kind = \"abort\"", "kind = \"hold\""),
        filed("abort station for no monitor's zone", "contacts", "[[input]]\nid = \"abort\"\nkind = \"abort\"\nzones = [\"hall\"]\nsource = { modbus = \"panel\", unit = 2, on = \"discrete:20\" }\n", ""),
        filed("release station missing", "contacts", "[[input]]\nid = \"station\"\nkind = \"release\"\nzones = [\"hall\"]\ndebounce_ms = 200\nsource = { modbus = \"panel\", unit = 2, on = \"discrete:21\" }\n", ""),
        filed("sounder missing", "outputs", "[[output]]\nid = \"horn\"\nkind = \"sounder\"\ntarget = { modbus = \"panel\", unit = 4, set = \"coil:5\" }\n", ""),
        filed("sounder is a lamp", "outputs", "kind = \"sounder\"", "kind = \"trouble_lamp\""),
        filed("a monitor the plan does not have", "monitors-known", "[[modbus]]", "[[monitor]]\nid = \"M3\"\nurl = \"tcp://LINE?addr=3\"\n\n[[modbus]]"),
        filed("detector on a device that is not there", "buses", "unit = 1, alarm", "unit = 77, alarm"),
        filed("contacts on a device that is not there", "buses", "unit = 2, on = \"discrete:20\"", "unit = 78, on = \"discrete:20\""),
    ]
}

impl Wrong {
    fn without_aim(mut self, monitor: &str) -> Self {
        let aim = self.site.file.split("[[").find(|part| {
            part.starts_with("aim]]") && part.contains(&format!("monitor = \"{monitor}\""))
        });
        let aim = format!("[[{}", aim.expect("an aim"));
        self.site.file = self.site.file.replace(&aim, "");
        self
    }

    fn renamed(mut self, names: &[(&str, &str)]) -> Self {
        for (from, to) in names {
            self.site.file = self.site.file.replace(from, to);
        }
        self
    }
}

/// Wrong as it was left, or worn, without anything moving.
#[rustfmt::skip]
fn at_rest() -> Vec<Wrong> {
    vec![
        of("dead line", "link", READ, |it| it.silent = Some(1)),
        of("WaterTimeout 0", "water-timeout", READ, |it| it.params = vec![(0, Param::GeneralWaterTimeout, vec![0])]),
        of("WaterTimeout too short", "water-timeout", READ, |it| it.params = vec![(1, Param::GeneralWaterTimeout, vec![60])]),
        of("wrong nozzle table", "parameters", READ, |it| it.params = vec![(1, Param::ControlNozzleDiameter, vec![380])]),
        of("ballistics off", "parameters", READ, |it| it.params = vec![(0, Param::ControlBallistics, vec![0])]),
        of("drive too slow", "parameters", READ, |it| it.params = vec![(0, Param::HorizontalSpeed, vec![3])]),
        of("clock an hour behind", "clock", READ, |it| it.date_off_ms = 3_600_000),
        of("clock 5 s ahead", "clock", READ, |it| it.date_off_ms = -5000),
        of("masked detector left", "disabled", READ, |it| it.before = vec![("/api/detectors/heat/bypass", json!({ "bypass": "masked" }))]),
        of("disabled detector left", "able", READ, |it| it.before = vec![("/api/detectors/flame-west/bypass", json!({ "bypass": "disabled" }))]),
        of("automatic left off", "mode", READ, |it| it.before = vec![("/api/zones/hall/mode", json!({ "mode": "off" }))]),
        of("manual left on", "mode", READ, |it| it.before = vec![("/api/zones/hall/mode", json!({ "mode": "manual" }))]),
        of("dry test left on", "mode", READ, |it| it.before = vec![("/api/zones/hall/mode", json!({ "mode": "test_dry" }))]),
        of("abort never reset", "disabled", READ, |it| it.before = vec![("/api/zones/hall/abort", json!({}))]),
        of("lockout left on", "disabled", READ, |it| it.before = vec![("/api/zones/lock", json!({}))]),
        of("pump left off by hand", "disabled", READ, |it| it.before = vec![("/api/pumps/main", json!({ "on": false }))]),
        of("pump left running by hand", "pumps-rest", READ, |it| it.before = vec![("/api/pumps/main", json!({ "on": true }))]),
        of("monitor left in a person's hands", "free", READ, |it| it.before = vec![("/api/monitors/M1/authority", json!({ "action": "take" }))]),
        of("monitor locked out", "ready", READ, |it| it.before = vec![("/api/monitors/M2/lockout", json!({}))]),
        of("stale detector", "able", READ, |it| it.mute = [true, false]),
        of("detector dirty", "able", READ, |it| it.condition = ["ready", "dirty"]),
        of("detector starting for ever", "able", READ, |it| it.condition = ["starting", "ready"]),
        of("detector masked at itself", "able", READ, |it| it.condition = ["ready", "masked"]),
        of("fault contact open", "able", READ, |it| *it = it.clone().file("!discrete:12", "discrete:12")),
        of("abort stuck on", "disabled", READ, |it| it.stuck = vec![crate::bench::ABORT]),
        of("release station stuck on", "troubles", READ, |it| it.stuck = vec![crate::bench::STATION]),
        of("stuck flow switch", "pumps-rest", READ, |it| it.stuck = vec![32]),
        of("heat detector stuck in alarm", "quiet", READ, |it| it.stuck = vec![crate::bench::HEAT]),
        of("switch of a valve broken", "ready", READ, |it| it.faults = vec![(0, "valve1-close-switch")]),
        of("no login", "login", READ, |it| it.login = false),
        of("full disk", "disk", READ, |it| it.answers = vec![("/api/hub/state", "/disk", json!({ "free_bytes": 200_000_000_u64, "total_bytes": 100_000_000_000_u64 }))]),
        of("log not written", "storage", READ, |it| it.answers = vec![("/health", "/storage", json!("failing"))]),
        of("log changed", "audit-chain", READ, |it| it.answers = vec![("/health", "/audit_chain/state", json!("broken"))]),
    ]
}

/// Wrong in a way that only shows when something moves.
#[rustfmt::skip]
fn moving() -> Vec<Wrong> {
    vec![
        of("monitors swapped", "which", DRY, |it| it.addresses = [2, 1]),
        of("heading off by 2°", "heading", DRY, |it| it.headings = [2.0, 0.0]),
        of("heading off by 2° to the left", "heading", DRY, |it| it.headings = [0.0, -2.0]),
        of("drive counts the wrong way", "motion", DRY, |it| it.faults = vec![(0, "horizontal-encoder-reversed")]),
        of("drive jammed", "motion", DRY, |it| it.faults = vec![(1, "vertical-jam")]),
        of("motor not connected", "motion", DRY, |it| it.faults = vec![(0, "vertical-motor-open")]),
        of("limits keep the target out", "heading", DRY, |it| it.params = vec![(0, Param::HorizontalMinLimit, vec![-1800])]),
    ]
}

/// Wrong in the field, in a way that only shows when people try the test outlet.
#[rustfmt::skip]
fn in_the_field() -> Vec<Wrong> {
    let wired = |name, finds, field| of(name, finds, OUTLET, |it| it.field = field);
    vec![
        wired("detectors swapped", "responds", Field::DetectorsSwapped),
        wired("mirrored detector", "bearing", Field::DetectorMirrored),
        wired("detector turned by 20°", "bearing", Field::DetectorTurned),
        wired("blind detector", "responds", Field::DetectorBlind),
        wired("heat detector on another input", "responds", Field::HeatUnwired),
        wired("detector sees the sources of another", "alone", Field::DetectorTooWide),
        wired("pumps wired crosswise", "pump-runs", Field::PumpsSwapped),
        wired("second pump does not start", "pump-runs", Field::PumpDead),
        wired("both pumps on one relay", "pump-runs", Field::PumpsTogether),
        wired("pressure switch stuck off", "pump-runs", Field::GaugeDead),
        wired("valve behind a pump is shut", "pump-runs", Field::PumpShutOff),
        wired("zone valve and outlet wired crosswise", "outlet-water", Field::ValvesSwapped),
        wired("test outlet jammed", "outlet", Field::OutletJammed),
        wired("pipe of the test outlet shut off", "outlet-water", Field::OutletShutOff),
        wired("too little pressure at the outlet", "outlet-pressure", Field::OutletThrottled),
        wired("test outlet does not close", "abort", Field::OutletStays),
        wired("abort station not wired", "abort", Field::AbortCut),
        wired("second pump does not stop", "abort", Field::PumpStays),
        of("delay of the second pump left out", "pump-order", OUTLET, |it| *it = it.clone().file("start_delay_s = 2\n", "")),
        of("delay that the plan does not have", "release", OUTLET, |it| *it = it.clone().file("delay_s = 2\n", "delay_s = 9\n")),
    ]
}

async fn is_found(wrong: Wrong) {
    let Wrong { name, finds, stages, site } = wrong;
    assert!(check::by_id(finds).is_some(), "{finds} is no check");
    let running = Running::start(site).await;
    let outcome = running.test(stages).await;
    let all = failed(&outcome);
    let found = all.iter().any(|it| it.split(' ').next() == Some(finds));
    println!(
        "{name}: {} in {} ms {all:?}",
        if found { "found" } else { "NOT FOUND" },
        outcome.took_ms
    );
    assert!(found, "{name}: {}", shown(&outcome));
    // Whatever is wired to what, no monitor gives water.
    assert!(!all.iter().any(|it| it.starts_with("closed")), "{name}: {}", shown(&outcome));
    assert!(!running.world.was_wet(), "{name}: {}", shown(&outcome));
}

#[test]
fn each_is_wrong_in_its_own_way() {
    let all: Vec<Wrong> = every().collect();
    let names: BTreeSet<&str> = all.iter().map(|it| it.name).collect();
    assert_eq!(names.len(), all.len());
    assert!(all.len() >= 100, "{}", all.len());
}

fn every() -> impl Iterator<Item = Wrong> {
    configured().into_iter().chain(at_rest()).chain(moving()).chain(in_the_field())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "minutes: a hundred installations"]
async fn what_the_file_has_wrong_is_found() {
    side_by_side(configured(), is_found).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "minutes: a hundred installations"]
async fn what_was_left_or_worn_is_found() {
    side_by_side(at_rest(), is_found).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "minutes: a hundred installations"]
async fn what_shows_when_it_moves_is_found() {
    side_by_side(moving(), is_found).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "minutes: a hundred installations"]
async fn what_shows_at_the_test_outlet_is_found() {
    side_by_side(in_the_field(), is_found).await;
}

/// A few of them with every run of the tests.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn some_wrong_installations_are_found() {
    let few = [
        "delay left on",
        "wrong aim program",
        "WaterTimeout 0",
        "masked detector left",
        "heading off by 2°",
        "mirrored detector",
        "pumps wired crosswise",
    ];
    let few: Vec<Wrong> = every().filter(|it| few.contains(&it.name)).collect();
    assert_eq!(few.len(), 7);
    side_by_side(few, is_found).await;
}
