//! A client of the hub that was not made for it: curl, with its cookies in a file.

use std::path::PathBuf;
use std::process::Command;

use serde_json::{Value, json};

use crate::run::output;

/// A user of a hub.
pub struct Client {
    address: String,
    cookies: PathBuf,
    /// What curl is run by.
    way: Vec<String>,
}

/// The first administrator of the hubs in these tests.
pub const USER: &str = "admin";
pub const PASSWORD: &str = "foam over water, 27 bar";

impl Client {
    pub fn new(address: &str, cookies: PathBuf, way: Vec<String>) -> Self {
        Self { address: address.to_owned(), cookies, way }
    }

    /// The first administrator, by the link that the hub has printed.
    pub fn set_up(&self, link: &str) -> Result<(), String> {
        let token = link.rsplit('#').next().unwrap_or_default();
        let body = json!({ "token": token, "user": USER, "password": PASSWORD });
        self.post("/api/setup", &body).map(drop)
    }

    pub fn log_in(&self) -> Result<(), String> {
        self.post("/api/login", &json!({ "user": USER, "password": PASSWORD })).map(drop)
    }

    pub fn get(&self, path: &str) -> Result<Value, String> {
        self.ask(self.curl(path))
    }

    fn post(&self, path: &str, body: &Value) -> Result<Value, String> {
        let mut curl = self.curl(path);
        curl.args(["-H", "Content-Type: application/json", "-d", &body.to_string()]);
        self.ask(curl)
    }

    fn curl(&self, path: &str) -> Command {
        let mut words = self.way.iter().map(String::as_str).chain(["curl"]);
        let mut curl = Command::new(words.next().unwrap_or("curl"));
        curl.args(words);
        curl.args(["--silent", "--show-error", "--fail-with-body", "--max-time", "20"]);
        curl.arg("--cookie").arg(&self.cookies).arg("--cookie-jar").arg(&self.cookies);
        curl.arg(format!("{}{path}", self.address));
        curl
    }

    fn ask(&self, mut curl: Command) -> Result<Value, String> {
        let text = output(&mut curl)?;
        serde_json::from_str(&text).map_err(|e| format!("{}: {e}: {text}", self.address))
    }
}
