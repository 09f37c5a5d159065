//! `lafet serve` with TLS and third-party clients (curl, OpenSSL), and with peers that speak
//! neither HTTP nor TLS.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::support::{Running, Sim, hub};
use serde_json::Value;

/// Stop on an idle hub takes some ms; this leaves time for a busy machine.
const STOP_MAX: Duration = Duration::from_secs(5);

struct Site {
    // Dropped, and so ended, together with the hub.
    _sim: Sim,
    _hub: Running,
    folder: PathBuf,
    url: String,
}

impl Site {
    fn open(name: &str) -> Self {
        let sim = Sim::start(&["--profile", "remote"]);
        let folder = std::env::temp_dir().join(format!("lafet-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let made = Command::new("openssl")
            .args(["req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"])
            .args(["-nodes", "-keyout", "key.pem", "-out", "cert.pem", "-days", "2"])
            .args(["-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"])
            .current_dir(&folder)
            .output()
            .expect("openssl is there");
        assert!(made.status.success(), "{made:?}");
        let config = folder.join("hub.toml");
        let text = format!(
            "[server]\nlisten = \"127.0.0.1:0\"\nlogin = false\ndata = \"data\"\n\
             [tls]\ncert = \"cert.pem\"\nkey = \"key.pem\"\n\
             [[monitor]]\nid = \"M1\"\nurl = \"tcp://{}?addr=1\"\n",
            sim.place()
        );
        std::fs::write(&config, text).unwrap();
        let (hub, url) = hub(&config);
        let url = url.trim_end_matches('/').replace("127.0.0.1", "localhost");
        let site = Self { _sim: sim, _hub: hub, folder, url };
        let began = Instant::now();
        while site.curl("/health", &[]).json()["monitors"]["M1"] != "up" {
            assert!(began.elapsed() < Duration::from_secs(60), "M1 does not connect");
        }
        site
    }

    fn place(&self) -> &str {
        self.url.trim_start_matches("https://")
    }

    fn curl(&self, path: &str, options: &[&str]) -> Answer {
        let certificate = self.folder.join("cert.pem");
        let output = Command::new("curl")
            .args(["--silent", "--show-error", "--max-time", "30", "--cacert"])
            .arg(certificate)
            .args(["--write-out", "\n%{http_code} %{http_version} %{size_download}"])
            .args(options)
            .arg(format!("{}{path}", self.url))
            .output();
        Answer::of(&output.expect("curl is there"))
    }

    /// OpenSSL's output for a connection over which `input` is sent.
    fn openssl(&self, options: &[&str], input: &[u8]) -> String {
        let mut child = Command::new("openssl")
            .args(["s_client", "-connect", self.place(), "-servername", "localhost"])
            .args(["-CAfile", "cert.pem"])
            .args(options)
            .current_dir(&self.folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("openssl is there");
        // A refused connection does not read.
        _ = child.stdin.take().unwrap().write_all(input);
        let output = child.wait_with_output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        text(&output.stdout) + &text(&output.stderr)
    }

    fn stops(&self) {
        let began = Instant::now();
        let stopped = self.curl("/api/stop", &["--request", "POST"]);
        assert_eq!(stopped.json()["M1"]["ok"], true, "{stopped:?}");
        assert!(began.elapsed() < STOP_MAX, "{:?}", began.elapsed());
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// The result of a curl call.
#[derive(Debug)]
struct Answer {
    body: String,
    status: u16,
    version: String,
    size: usize,
}

impl Answer {
    fn of(output: &Output) -> Self {
        let text = String::from_utf8_lossy(&output.stdout);
        let (body, figures) = text.rsplit_once('\n').expect("the figures");
        let figures: Vec<&str> = figures.split(' ').collect();
        Self {
            body: body.to_owned(),
            status: figures[0].parse().unwrap(),
            version: figures[1].to_owned(),
            size: figures[2].parse().unwrap(),
        }
    }

    fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_default()
    }
}

#[test]
fn curl() {
    let site = Site::open("curl");
    // HTTP/2 is not served: a client that prefers it gets HTTP/1.1.
    for (options, version) in
        [(&["--http1.1"][..], "1.1"), (&["--http2"], "1.1"), (&["--http1.0", "--no-alpn"], "1")]
    {
        let answer = site.curl("/api/monitors", options);
        let said = (answer.status, answer.version.starts_with(version));
        assert_eq!(said, (200, true), "{options:?}: {answer:?}");
    }
    for tls in ["1.2", "1.3"] {
        let answer = site.curl("/api/hub", &[&format!("--tlsv{tls}"), "--tls-max", tls]);
        assert_eq!(answer.status, 200, "TLS {tls}: {answer:?}");
    }
    site.stops();

    let plain = site.curl("/api/openapi.json", &[]);
    let packed = site.curl("/api/openapi.json", &["--compressed"]);
    assert!(plain.json().is_object() && plain.body == packed.body);
    assert!(packed.size * 4 < plain.size, "{} of {}", packed.size, plain.size);
    let json = ["--header", "Content-Type: application/json", "--data", "{}"];
    let gzip = [&json[..], &["--header", "Content-Encoding: gzip"]].concat();
    assert_eq!(site.curl("/api/alarms/ack", &json).status, 200);
    assert_eq!(site.curl("/api/alarms/ack", &gzip).status, 415);

    // A body in chunks, one sent after 100-continue, and one that is too large.
    let chunked = [&json[..], &["--header", "Transfer-Encoding: chunked"]].concat();
    assert_eq!(site.curl("/api/alarms/ack", &chunked).status, 200);
    let asks = [&json[..], &["--header", "Expect: 100-continue"]].concat();
    assert_eq!(site.curl("/api/alarms/ack", &asks).status, 200);
    std::fs::write(site.folder.join("large"), vec![b' '; 100_000]).unwrap();
    let large = format!("@{}", site.folder.join("large").display());
    // Where it does not wait for the answer, the body that is still sent resets the connection.
    let large = ["--expect100-timeout", "30", "--data-binary", &large];
    assert_eq!(site.curl("/api/alarms/ack", &large).status, 413);
    assert_eq!(site.curl("/api/nothing", &[]).status, 404);
    assert_eq!(site.curl("/api/monitors", &["--header", "Host: elsewhere.example"]).status, 403);
    assert_eq!(site.curl("/api/monitors", &["--request", "NONSENSE"]).status, 405);
    site.stops();
}

#[test]
fn openssl() {
    let site = Site::open("openssl");
    let request = b"GET /health HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    for version in ["-tls1_2", "-tls1_3"] {
        let said = site.openssl(&[version, "-alpn", "h2,http/1.1", "-ign_eof"], request);
        for part in ["Verify return code: 0 (ok)", "ALPN protocol: http/1.1", "HTTP/1.1 200 OK"] {
            assert!(said.contains(part), "{version}, {part}: {said}");
        }
    }
    // Insecure versions and unsupported protocols get no handshake.
    for options in [&["-tls1_1"][..], &["-alpn", "h2"]] {
        let said = site.openssl(options, request);
        assert!(!said.contains("HTTP/1.1"), "{options:?}: {said}");
    }
    let said = site.openssl(&["-ign_eof", "-quiet"], b"\xff\xfe garbage \r\n\r\n");
    assert!(said.contains("HTTP/1.1 400"), "{said}");
    site.stops();
}

#[test]
fn neither_tls_nor_http() {
    let site = Site::open("garbage");
    let noise: Vec<u8> =
        (0..65_536_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    // A TLS record that is announced and never completed.
    let half = b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc".to_vec();
    let plain = b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n".to_vec();
    let mut open = Vec::new();
    for bytes in [noise, half, plain, Vec::new()] {
        for _ in 0..50 {
            let mut stream = TcpStream::connect(site.place()).unwrap();
            // The hub may close the connection before everything is sent.
            _ = stream.write_all(&bytes);
            open.push(stream);
        }
    }
    site.stops();
    // A connection without a handshake is closed.
    let ended = open.iter_mut().take(50).map(|stream| {
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        match stream.read_to_end(&mut Vec::new()) {
            Ok(_) => true,
            Err(error) => error.kind() == std::io::ErrorKind::ConnectionReset,
        }
    });
    assert_eq!(ended.filter(|it| *it).count(), 50);
    site.stops();
}
