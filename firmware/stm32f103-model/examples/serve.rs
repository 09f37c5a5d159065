//! The board in the model of its chip, at a TCP port: for `lafet` and every other controller.
//!
//! `serve [PORT [SECONDS]]`; a fire burns at 30°, 25 m off. It ends when the fire is out and the controller
//! has left, or, with a failure, when the seconds are over.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use lafet_sim::fire::FireSpec;
use lafet_stm32f103_model::chip::Byte;
use lafet_stm32f103_model::rig::{Rig, Wrong};

fn main() -> ExitCode {
    let number = |n: usize| std::env::args().nth(n).and_then(|number| number.parse().ok());
    let port = number(1).and_then(|port| u16::try_from(port).ok()).unwrap_or(10_485);
    match serve(port, number(2).unwrap_or(u64::MAX)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("port {port}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether the fire is out.
fn serve(port: u16, limit_s: u64) -> io::Result<bool> {
    let listener = TcpListener::bind(("127.0.0.1", port))?;
    let fire = FireSpec { azimuth_deg: 30.0, range_m: 25.0, ..FireSpec::default() };
    let mut rig = Rig::new(Wrong::NOTHING, vec![fire]);
    println!("the board is at tcp://127.0.0.1:{port}, address 7; a fire burns");
    listener.set_nonblocking(true)?;
    let (began, first_ns) = (Instant::now(), rig.now_ns());
    let mut line: Option<TcpStream> = None;
    let mut is_out = false;
    loop {
        // A busy machine holds it up; then it catches up.
        let passed = began.elapsed().as_nanos() as u64;
        if rig.now_ns() - first_ns >= passed {
            std::thread::park_timeout(Duration::from_millis(1));
            continue;
        }
        rig.run(1);
        // One line, one connection at a time.
        if line.is_none()
            && let Ok((stream, _)) = listener.accept()
        {
            stream.set_nonblocking(true)?;
            stream.set_nodelay(true)?;
            line = Some(stream);
        }
        let goes_on = line.as_mut().is_none_or(|stream| exchange(&mut rig, stream).is_ok());
        if !goes_on {
            line = None;
        }
        let burns = rig.parts(|parts| parts.plant.world.fires.iter().any(|fire| fire.burns()));
        if !burns && !is_out {
            is_out = true;
            println!("the fire is out after {:.1} s", (rig.now_ns() - first_ns) as f64 / 1e9);
        }
        if is_out && line.is_none() || began.elapsed().as_secs() >= limit_s {
            return Ok(is_out);
        }
    }
}

/// Bytes of the connection go over the line at its baud, and back.
fn exchange(rig: &mut Rig, stream: &mut TcpStream) -> io::Result<()> {
    let mut bytes = [0; 256];
    let len = match stream.read(&mut bytes) {
        Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
        Ok(len) => len,
        Err(error) if error.kind() == ErrorKind::WouldBlock => 0,
        Err(error) => return Err(error),
    };
    let answer: Vec<u8> = rig.parts(|parts| {
        let chip = &mut parts.chip;
        let byte_ns = 10_000_000_000 / chip.line_baud;
        let last = chip.incoming.back().map_or(chip.now_ns, |byte| byte.at_ns);
        for (n, value) in (1..).zip(&bytes[..len]) {
            chip.incoming.push_back(Byte { at_ns: last + n * byte_ns, value: *value });
        }
        chip.outgoing.drain(..).map(|byte| byte.value).collect()
    });
    stream.write_all(&answer)
}
