//! Runs the hub inside this program: its threads, its logs, a browser.

pub mod cameras;
mod faults;
mod log;
mod looks;
pub mod scene;
pub mod training;
mod watchdog;

use std::io::IsTerminal;
use std::process::{Command, Stdio};

use lafet_hub::store::{Loss, StoreError};
use lafet_hub::{Clock, Config, Hub, Server};
use lafet_texts::{Shown, Text as _, cli as text};
use serde_json::json;
use tokio::sync::oneshot;

use crate::cmd::schema;
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;

pub use log::log;

/// Number of threads: commands to monitors must not wait for logins, exports or a busy simulator.
const THREADS: usize = 4;

/// A hub that runs on threads of its own.
pub struct Running {
    runtime: Option<tokio::runtime::Runtime>,
    hub: Hub,
    url: String,
    end: Option<oneshot::Sender<()>>,
    ended: tokio::task::JoinHandle<()>,
    _looks: looks::Looks,
}

impl Running {
    /// Starts a hub.
    pub async fn start(mut config: Config) -> Result<Self, Failure> {
        config.camera_program = cameras::program();
        let (listen, folder) = (config.listen, config.data.clone());
        let hub = Hub::new(config, Clock::System, schema::schema()).map_err(|error| {
            if let StoreError::Lost(losses) = &error {
                return lost(losses);
            }
            if let StoreError::Newer(newer) = &error {
                return Failure::Usage(newer.words().of(current()).to_owned());
            }
            if let StoreError::Shared(folder) = &error {
                let folder = folder.display();
                return Failure::Usage(text::FolderShared { folder: Shown(folder) }.of(current()));
            }
            if let StoreError::InUse(folder) = &error {
                let folder = folder.display();
                return Failure::Usage(text::FolderInUse { folder: Shown(folder) }.of(current()));
            }
            let what = text::CannotOpenStorage.str(current());
            match (error, folder) {
                (StoreError::Io(source), Some(folder)) => {
                    Failure::io(format!("{what} {}", folder.display()), source)
                }
                (error, _) => Failure::Usage(format!("{what}: {}", error.of(current()))),
            }
        })?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(THREADS)
            .thread_name("lafet-hub")
            .enable_all()
            .build()?;
        let looks = looks::start(runtime.handle())?;
        let (end, ending) = oneshot::channel::<()>();
        let (ready, server) = oneshot::channel();
        let own = hub.clone();
        let ended = runtime.spawn(async move {
            match Server::bind(own).await {
                Ok(server) => {
                    _ = ready.send(server.url());
                    // Dropping the sender ends the hub as well.
                    server.serve(async { _ = ending.await }).await;
                }
                Err(error) => _ = ready.send(Err(error)),
            }
        });
        let cannot = || text::CannotListenHub { listen: Shown(listen) }.of(current());
        let url = match server.await {
            Ok(Ok(url)) => url,
            Ok(Err(error)) => {
                runtime.shutdown_background();
                return Err(Failure::io(cannot(), error));
            }
            Err(_) => return Err(Failure::Ended(cannot())),
        };
        if let Err(error) = watchdog::start(runtime.handle(), &hub) {
            runtime.shutdown_background();
            return Err(error.into());
        }
        Ok(Self { runtime: Some(runtime), hub, url, end: Some(end), ended, _looks: looks })
    }

    /// The URL to open in a browser.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// The running hub.
    pub const fn hub(&self) -> &Hub {
        &self.hub
    }

    /// Prints the URL, and the one-time link while there are no users.
    pub fn announce(&self, out: &mut Out, login: bool) -> Outcome {
        let link = if login { self.hub.access().setup_link() } else { Ok(None) };
        let link = link.map_err(|error| {
            let what = text::CannotOpenStorage.str(current());
            Failure::io(what, std::io::Error::other(error.to_string()))
        })?;
        let link = link.map(|token| format!("{}/setup#{token}", self.url));
        let mut text = self.url.clone();
        if let Some(link) = &link {
            text += &format!("\n{}", text::NoUsersYet { link }.of(current()));
        }
        out.show(text, || json!({ "listening": self.url, "setup": link }))
    }

    /// Waits until the hub ends by itself, as a part of it has failed.
    pub async fn failed(&mut self) -> Failure {
        _ = (&mut self.ended).await;
        Failure::Ended(text::HubFailed.of(current()))
    }

    /// Ends the hub: motions are released, open requests answered, the audit log closed.
    pub async fn end(mut self) {
        drop(self.end.take());
        _ = (&mut self.ended).await;
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

/// Describes lost state files, and how to continue without them.
fn lost(losses: &[Loss]) -> Failure {
    let of = |lang| losses.iter().map(|it| it.both().of(lang).to_owned()).collect::<Vec<_>>();
    let mut words: Vec<&str> = losses.iter().map(|it| it.file.word()).collect();
    words.dedup();
    let words = words.join(",");
    Failure::Usage(text::StateLost { list: of(current()).join("\n  "), words }.of(current()))
}

/// Opens a page in a browser, if there is a display.
pub fn browse(url: &str) {
    let screen = ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    let opener = match () {
        () if cfg!(target_os = "macos") => "open",
        () if cfg!(windows) => "explorer",
        () if screen => "xdg-open",
        () => return,
    };
    if std::io::stdout().is_terminal() {
        let mut command = Command::new(opener);
        command.arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        // The URL is printed as well, so a failure to start a browser is ignored.
        _ = command.spawn();
    }
}
