//! Good installations, each a little different: nothing of them may be found wrong.

use lafet_acceptance::{Stage, Verdict};
use lafet_proto::param::Param;

use crate::bench::{Running, Site, failed, shown};

/// Configured in another way.
fn configured() -> Vec<(&'static str, Site)> {
    let good = Site::good;
    vec![
        ("as it is", good()),
        ("no delay", good().both("delay_s = 2\n", "delay_s = 0\n")),
        ("a delay of 4 s", good().both("delay_s = 2\n", "delay_s = 4\n")),
        ("coincidence of 7 s", good().both("coincidence_s = 5", "coincidence_s = 7")),
        ("one kind is enough", good().both("kinds = 2", "kinds = 1")),
        ("three of three", good().both("2oo3", "3oo3")),
        ("one jet", good().both("kinds = 2\n", "kinds = 2\njets = 1\n")),
        ("a short hold", good().both("hold_max_s = 60", "hold_max_s = 30")),
        ("pumps at once", good().both("start_delay_s = 2", "start_delay_s = 0")),
        ("pumps far apart", good().both("start_delay_s = 2", "start_delay_s = 3")),
        (
            "the first pump waits",
            good().both("id = \"main\"\n", "id = \"main\"\nstart_delay_s = 2\n"),
        ),
    ]
}

/// Built, mounted or planned in another way.
fn built() -> Vec<(&'static str, Site)> {
    let good = Site::good;
    let with = |change: fn(&mut Site)| {
        let mut site = good();
        change(&mut site);
        site
    };
    vec![
        (
            "a heading to the north-east",
            with(|it| {
                *it = it.clone().both("heading = 0.0", "heading = 30.0");
                *it = it.clone().both("horizontal = -2320", "horizontal = -520");
                it.headings[0] = 30.0;
            }),
        ),
        ("a little off", with(|it| it.headings = [0.4, -0.4])),
        (
            "another nozzle",
            with(|it| {
                it.plan = it.plan.replace("[280]", "[320]");
                it.params =
                    (0..2).map(|at| (at, Param::ControlNozzleDiameter, vec![320])).collect();
            }),
        ),
        (
            "a slow drive",
            with(|it| {
                it.plan =
                    it.plan.replace("\"Horizontal.Speed\" = [20]", "\"Horizontal.Speed\" = [8]");
                it.params = vec![(0, Param::HorizontalSpeed, vec![8])];
            }),
        ),
        (
            "more time for forgotten water",
            with(|it| it.params = vec![(1, Param::GeneralWaterTimeout, vec![900])]),
        ),
        (
            "a sector written in another way",
            with(|it| it.plan = it.plan.replace("[170.0, 200.0]", "[-190.0, 200.0]")),
        ),
        ("another date zone", with(|it| it.date_off_ms = 900)),
        ("a play in the gear", with(|it| it.faults = vec![(0, "horizontal-encoder-noise")])),
        (
            "a plan of little",
            with(|it| {
                it.plan = "name = \"Hall\"\n[[monitor]]\nid = \"M1\"\n[[monitor]]\nid = \"M2\"\n\
                       [[target]]\nname = \"door\"\nat = [0.0, 25.0, 2.0]\n\
                       [[zone]]\nid = \"hall\"\ndelay_s = 2\n\
                       [[detector]]\nid = \"flame-west\"\nat = [-30.0, 0.0, 6.0]\n\
                       [[detector]]\nid = \"flame-east\"\nat = [30.0, 0.0, 6.0]\n"
                    .into();
            }),
        ),
        (
            "other names",
            with(|it| {
                it.plan = it.plan.replace("\"main\"", "\"насос 1\"");
                it.file = it.file.replace("\"main\"", "\"насос 1\"");
            }),
        ),
    ]
}

async fn is_good(name: &str, site: Site) {
    let running = Running::start(site).await;
    let outcome = running.test(&Stage::ALL).await;
    let nothing: Vec<String> = Vec::new();
    assert_eq!(failed(&outcome), nothing, "{name}: {}", shown(&outcome));
    assert!(outcome.ended.is_none() && outcome.left.is_empty(), "{name}: {}", shown(&outcome));
    assert!(!running.world.was_wet(), "{name}: {}", shown(&outcome));
    assert!(outcome.findings.count(Verdict::Pass) > 20, "{name}: {}", shown(&outcome));
    println!("{name}: {} passed in {} ms", outcome.findings.count(Verdict::Pass), outcome.took_ms);
    let zones = running.hub.zones_view().unwrap();
    assert!(zones.state.troubles.iter().all(|it| !it.active), "{name}: {:?}", zones.state);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_good_site_passes_every_step() {
    is_good("as it is", Site::good()).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "minutes: twenty-one installations"]
async fn nothing_is_found_wrong_with_good_sites() {
    let all: Vec<(&str, Site)> = configured().into_iter().chain(built()).collect();
    assert_eq!(all.len(), 21);
    crate::wrong::side_by_side(all, |(name, site)| async move {
        is_good(name, site).await;
    })
    .await;
}
