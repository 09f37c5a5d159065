//! A console: requests as text, one a line, and what the monitor answers.
//!
//! ```sh
//! cargo run -p lafet-client --example console -- tcp://127.0.0.1:10485
//! ```

use std::error::Error;
use std::io::{BufRead, Write};

use lafet_client::blocking::Client;
use lafet_proto::request::Body;
use lafet_proto::text::{BUFFER_SIZE, Exchange, parse};
use lafet_proto::{Request, SubsystemId};

fn main() -> Result<(), Box<dyn Error>> {
    let url = std::env::args().nth(1).unwrap_or("tcp://127.0.0.1:10485".into());
    let client = Client::connect(&url.parse()?)?;
    console(&client, std::io::stdin().lock(), std::io::stdout().lock())
}

fn console(
    client: &Client,
    input: impl BufRead,
    mut output: impl Write,
) -> Result<(), Box<dyn Error>> {
    for line in input.lines() {
        let (line, mut data) = (line?, [0; BUFFER_SIZE]);
        let answers = match parse(&line, &mut data) {
            Ok(request) => client.request(&request).map(|answers| (request, answers)),
            Err(mistake) => {
                writeln!(output, "{mistake}")?;
                continue;
            }
        };
        match answers {
            Ok((request, answers)) => {
                for answer in answers.iter() {
                    writeln!(output, "{}", Exchange::new(&request, answer.decode()?))?;
                }
            }
            Err(error) => writeln!(output, "{error}")?,
        }
    }
    // No motion outlives the console.
    client.request(&Request::new(SubsystemId::ALL, Body::Stop))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::{SocketAddr, TcpListener};

    use lafet_device::Source;
    use lafet_device::port::Port;
    use lafet_sim::sim::{Config, Sim};

    use super::*;

    /// A simulated monitor for one connection.
    fn monitor() -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let place = listener.local_addr().expect("its address");
        std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().expect("a client");
            let mut sim = Sim::new(Config::default());
            let (mut port, mut buffer) = (Port::new(Source::ExternalConn), [0; 1024]);
            while let Ok(len @ 1..) = stream.read(&mut buffer) {
                sim.advance_ms(1000);
                let answer = sim.receive(&mut port, &buffer[..len]);
                stream.write_all(&answer).expect("the client reads");
            }
        });
        place
    }

    #[test]
    fn requests_are_answered_and_mistakes_named() {
        let url = format!("tcp://{}", monitor());
        let client = Client::connect(&url.parse().expect("a URL")).expect("a connection");
        let requests = "Move Vertical 100\nDeploy\nFly away\n";
        let mut shown = Vec::new();
        console(&client, requests.as_bytes(), &mut shown).expect("answers");
        let shown = String::from_utf8(shown).expect("text");
        let lines: Vec<&str> = shown.lines().collect();
        assert_eq!(
            lines[..2],
            ["Vertical Move → Denied (Deployer)", "Deployer Deploy → Accepted",]
        );
        assert!(lines[2].starts_with("column 1: expected a request"), "{shown}");
        assert_eq!(lines.len(), 3);
    }
}
