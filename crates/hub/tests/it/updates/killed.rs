//! A hub that is killed in the middle of an update, and the next one.

use std::path::{Path, PathBuf};

use tokio::runtime::{Builder, Runtime};

use super::*;

/// A hub with a runtime of its own: dropped, nothing of it runs any more, and nothing was brought to an end.
struct Process {
    site: Option<Site>,
    runtime: Option<Runtime>,
}

impl Process {
    async fn start(at: &(Bus, SocketAddr), data: &Path, id: &'static str) -> Self {
        let runtime = Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
        let (bus, data) = (at.clone(), data.to_owned());
        let site = runtime.spawn(super::at(bus, move |config| {
            (config.login, config.data) = (false, Some(data));
            config.monitors[0].id = id.to_owned();
        }));
        Self { site: Some(site.await.unwrap()), runtime: Some(runtime) }
    }

    fn site(&self) -> &Site {
        self.site.as_ref().unwrap()
    }

    /// Kills it; what it had in its memory is gone.
    async fn kill(mut self) {
        let runtime = self.runtime.take().unwrap();
        tokio::task::spawn_blocking(move || runtime.shutdown_timeout(Duration::from_secs(30)))
            .await
            .unwrap();
        self.site.take();
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

/// A folder of data that goes with the test.
struct Data(PathBuf);

impl Data {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        Self(folder)
    }

    /// Notes of updates that are under way.
    fn notes(&self) -> usize {
        std::fs::read_dir(self.0.join("updates/words")).map_or(0, |it| it.flatten().count())
    }
}

impl Drop for Data {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

fn is_on_trial(site: &Site) -> bool {
    site.bus.lock()[0].running().is_some_and(|it| it.trial)
}

/// Killed while it sends, and while the image is on trial: nothing starts by itself, and the same update goes on with
/// what is noted, whatever the monitor is called now.
#[tokio::test]
async fn the_same_update_goes_on() {
    let (data, at) = (Data::new("killed"), bus(1).await);
    let hub = Process::start(&at, &data.0, "M1").await;
    let digest = store(hub.site(), &image(NEW, LARGE)).await;
    begin(hub.site(), &digest).await;
    run_until(hub.site(), "it sends", sends).await;
    hub.kill().await;
    assert_eq!(data.notes(), 1);

    let hub = Process::start(&at, &data.0, "North").await;
    assert!(run_now(hub.site()).await.is_null(), "nothing starts by itself");
    assert!(is_locked(hub.site(), "North"), "it is as it was left");
    // The commit is behind it, the word does not arrive.
    at.0.lose_confirmations(true);
    begin(hub.site(), &digest).await;
    until("it is on trial", || is_on_trial(hub.site())).await;
    hub.kill().await;
    at.0.lose_confirmations(false);
    assert_eq!((at.0.lock()[0].running().unwrap().trial, data.notes()), (true, 1));

    let hub = Process::start(&at, &data.0, "M1").await;
    begin(hub.site(), &digest).await;
    let run = ended(hub.site()).await;
    assert_eq!(states(&run), ["done"], "{run:#}");
    assert_eq!((runs(hub.site(), 0), data.notes()), ((NEW, false), 0));
    // The lockout of the hub that was killed was there before this run.
    assert!(is_locked(hub.site(), "M1"));
    release(hub.site(), "M1").await;
    hub.kill().await;
}

/// The note is lost, or the image is another one: what is on trial is confirmed by nothing here, and goes back.
#[tokio::test]
async fn nothing_is_confirmed_without_its_note() {
    let (data, at) = (Data::new("noteless"), bus(1).await);
    let hub = Process::start(&at, &data.0, "M1").await;
    let digest = store(hub.site(), &image(NEW, SMALL)).await;
    let other = store(hub.site(), &image([3, 0, 0, 0], SMALL)).await;
    at.0.lose_confirmations(true);
    begin(hub.site(), &digest).await;
    until("it is on trial", || is_on_trial(hub.site())).await;
    hub.kill().await;
    at.0.lose_confirmations(false);

    let hub = Process::start(&at, &data.0, "M1").await;
    begin(hub.site(), &other).await;
    let run = ended(hub.site()).await;
    assert_eq!(states(&run), ["failed"], "{run:#}");
    assert!(text(&run["monitors"][0]).contains("another image"), "{run:#}");
    let note = std::fs::read_dir(data.0.join("updates/words")).unwrap().flatten().next().unwrap();
    std::fs::write(note.path(), b"half a no").unwrap();
    begin(hub.site(), &digest).await;
    let run = ended(hub.site()).await;
    assert!(text(&run["monitors"][0]).contains("cannot be read"), "{run:#}");
    std::fs::remove_file(note.path()).unwrap();
    begin(hub.site(), &digest).await;
    let run = ended(hub.site()).await;
    assert!(text(&run["monitors"][0]).contains("not sent"), "{run:#}");
    assert_eq!(runs(hub.site(), 0), (NEW, true));
    until("it goes back", || {
        let mut sims = at.0.lock();
        sims[0].advance_ms(1_000);
        sims[0].running().is_some_and(|it| !it.trial)
    })
    .await;
    assert_eq!(runs(hub.site(), 0), (OLD, false));
    begin(hub.site(), &digest).await;
    let run = ended(hub.site()).await;
    assert_eq!((states(&run), runs(hub.site(), 0)), (vec!["done"], (NEW, false)), "{run:#}");
    hub.kill().await;
}

/// An orderly end of the hub ends the run as a kill does, and its log says so.
#[tokio::test]
async fn an_orderly_end_ends_the_run() {
    let site = open(1).await;
    let digest = store(&site, &image(NEW, LARGE)).await;
    begin(&site, &digest).await;
    run_until(&site, "it sends", sends).await;
    site.hub.begin_shutdown();
    let hub = site.hub.clone();
    let began = Instant::now();
    let found = loop {
        let log = hub.audit().latest(None, 100, None, None).await.unwrap();
        let found = log
            .into_iter()
            .find(|it| it.record.act.as_ref().is_some_and(|act| act["type"] == "end_update"));
        match found {
            Some(found) => break found,
            None => assert!(began.elapsed() < Duration::from_secs(30), "it goes on"),
        }
        sleep(Duration::from_millis(20)).await;
    };
    let act = found.record.act.unwrap();
    assert_eq!((&act["done"], &act["monitors"]), (&json!(0), &json!(1)), "{act:#}");
    assert!(act["text"]["en"].as_str().unwrap().contains("the hub ends"), "{act:#}");
}
