//! Over a serial line, and with masters of others, pymodbus and mbpoll: `cargo xtask plugs` installs them.

use std::process::{Command, Stdio};
use std::time::Duration;

use lafet_hub::Clock;
use rmodbus::ModbusProto;
use tokio::io::AsyncWriteExt;

use super::master::{HEARTBEAT, Master, SESSION};
use super::{HORIZONTAL, PATIENT, free, opening, site_at};
use crate::modbus::pty;
use crate::support::{Site, stays, until};

/// A site whose server is on a serial line; and a stream to that line.
async fn serial()
-> (Site, impl tokio::io::AsyncRead + tokio::io::AsyncWrite + Unpin, std::os::fd::OwnedFd) {
    let (ours, path, open) = pty();
    let text = format!(
        "[[modbus_server]]\nname = \"line\"\nlisten = \"serial://{path}?baud=115200&parity=none\"\nunit = 5\nrole = \"operator\"\n{PATIENT}\n"
    );
    let site = site_at(1, Clock::System, &text).await;
    until_open(&site).await;
    (site, ours, open)
}

/// Until the server has opened its line.
async fn until_open(site: &Site) {
    let began = tokio::time::Instant::now();
    loop {
        let plug = site.get("", "/api/hub/state").await.body["plugs"][0].clone();
        if plug["clients"].as_array().is_some_and(|it| !it.is_empty()) {
            return;
        }
        assert!(began.elapsed() < crate::support::PATIENCE, "{plug:#}");
    }
}

/// A frame with its checksum, computed bit by bit.
fn rtu(bytes: &[u8]) -> Vec<u8> {
    let sum = rmodbus_crc(bytes);
    bytes.iter().copied().chain(sum.to_le_bytes()).collect()
}

fn rmodbus_crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(
            crc ^ u16::from(*byte),
            |crc, _| {
                if crc & 1 == 0 { crc >> 1 } else { crc >> 1 ^ 0xA001 }
            },
        )
    })
}

#[tokio::test]
async fn a_serial_line_is_served_like_tcp() {
    let (site, stream, _open) = serial().await;
    let master = Master::on(stream, ModbusProto::Rtu, 5).live().await;
    assert_eq!(master.command(1, 1, [0; 4]).await, (2, 0));
    assert_eq!(master.command(4, 1, [1, 100, 0, 0]).await, (2, 0));
    until("it moves", || site.bus.position(0, HORIZONTAL) > 100.0).await;
    assert_eq!(master.command(7, 1, [0; 4]).await, (2, 0));
    assert_eq!(master.command(5, 1, [1, 0, 0, 0]).await, (2, 0));
    until("it opens", || opening(&site) > 0.9).await;
    master.beat(false);
    let frames = master.frames();
    let longest = frames.iter().map(Vec::len).max().unwrap();
    assert_eq!(longest, 9 + 26, "frames of a serial line");
}

#[tokio::test]
async fn a_broadcast_stops_and_noise_does_not() {
    let (site, mut stream, _open) = serial().await;
    let mut console = site.ws("").await;
    console.authority("M1", "take").await;
    let moving = || site.bus.commanded(0, HORIZONTAL) != 0;
    let mut go = async |target: i32| {
        let request = format!("Move Horizontal {target}");
        let asked = serde_json::json!({ "type": "request", "monitor": "M1", "request": request });
        assert_eq!(console.ask(asked).await["result"]["ok"], true);
        until("it moves", moving).await;
    };
    // Command, all units: 13 words at 264; stop of monitor 1, then everything else, which does nothing.
    let broadcast = |unit: u8, command: u8| {
        let mut pdu = vec![unit, 16, 1, 8, 0, 13, 26, 0, 1, 0, 0, 0, 0, 0, command, 0, 1];
        pdu.extend([0; 16]);
        rtu(&pdu)
    };
    go(9000).await;
    for other in [1, 3, 4, 5, 8, 9, 10] {
        stream.write_all(&broadcast(0, other)).await.unwrap();
    }
    // For another unit, and with a checksum that is wrong.
    stream.write_all(&broadcast(6, 7)).await.unwrap();
    tokio::time::sleep(Duration::from_millis(60)).await;
    let mut wrong = broadcast(5, 7);
    wrong[20] ^= 4;
    stream.write_all(&wrong).await.unwrap();
    assert!(stays(Duration::from_millis(300), moving).await, "nothing of it is a Stop");
    stream.write_all(&broadcast(0, 7)).await.unwrap();
    until("the broadcast stops", || !moving()).await;
    assert!(site.bus.position(0, HORIZONTAL) < 8900.0, "it is not at its target");
    // Behind noise the beginning of a frame is not certain: Stop is taken, and nothing else.
    go(-9000).await;
    let mut noisy = vec![0x55; 40];
    noisy.extend(broadcast(5, 7));
    stream.write_all(&noisy).await.unwrap();
    until("it stops behind noise", || !moving()).await;
    assert!(site.bus.position(0, HORIZONTAL) > -8900.0, "it is not at its target");
    let state = site.get("", "/api/hub/state").await.body["plugs"][0].clone();
    assert!(state["malformed"].as_u64() > Some(0), "{state:#}");
}

/// Noise and a frame without a pause: once the line was silent, writes are taken again.
#[tokio::test]
async fn a_line_that_was_noisy_is_served_again() {
    let (_site, mut stream, _open) = serial().await;
    let mut noisy = vec![0x55; 40];
    noisy.extend(rtu(&[5, 6, 1, 0, 0, 9]));
    stream.write_all(&noisy).await.unwrap();
    tokio::time::sleep(Duration::from_millis(200)).await;
    let master = Master::on(stream, ModbusProto::Rtu, 5).live().await;
    assert_eq!(master.command(1, 1, [0; 4]).await, (2, 0));
}

#[tokio::test]
async fn frames_of_a_serial_line_come_over_tcp() {
    let address = free();
    let text = format!(
        "[[modbus_server]]\nname = \"line\"\nlisten = \"rtu+tcp://{address}\"\nrole = \"operator\"\n{PATIENT}\n"
    );
    let site = site_at(1, Clock::System, &text).await;
    until("it listens", || std::net::TcpStream::connect(address).is_ok()).await;
    let stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let master = Master::on(stream, ModbusProto::Rtu, 1).live().await;
    assert_eq!(master.command(1, 1, [0; 4]).await, (2, 0));
    assert_eq!(master.read(3, 1).await, [1]);
    drop(site);
}

/// Runs a script with pymodbus as the master; what it prints.
async fn pymodbus(arguments: &[&str]) -> String {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/plugs/master.py");
    let mut command = Command::new("python3");
    command.arg(script).args(arguments).stdout(Stdio::piped());
    let done =
        tokio::task::spawn_blocking(move || command.output()).await.unwrap().expect("python3");
    let printed = String::from_utf8(done.stdout).unwrap();
    assert!(done.status.success(), "pymodbus is needed: {printed}");
    printed
}

#[tokio::test]
#[ignore = "needs pymodbus and pyserial"]
async fn pymodbus_reads_moves_and_opens() {
    let address = free();
    let text = format!(
        "[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://{address}\"\nrole = \"operator\"\n{PATIENT}\n"
    );
    let site = site_at(8, Clock::System, &text).await;
    until("it listens", || std::net::TcpStream::connect(address).is_ok()).await;
    let port = address.port().to_string();
    let printed = pymodbus(&["tcp", &port]).await;
    for line in [
        "monitors 8",
        "good 8",
        "take 2 0",
        "goto 2 0",
        "arrived",
        "open 2 0",
        "opened",
        "wrong key 3 9",
        "stop 2 0",
    ] {
        assert!(printed.lines().any(|it| it == line), "{line}: {printed}");
    }
    assert!(opening(&site) > 0.9);
}

#[tokio::test]
#[ignore = "needs pymodbus and pyserial"]
async fn pymodbus_commands_over_a_serial_line() {
    let (ours, path, _open) = pty();
    let (theirs, master_path, _open_too) = pty();
    tokio::spawn(async move {
        let (mut ours, mut theirs) = (ours, theirs);
        _ = tokio::io::copy_bidirectional(&mut ours, &mut theirs).await;
    });
    let text = format!(
        "[[modbus_server]]\nname = \"line\"\nlisten = \"serial://{path}?baud=115200&parity=none\"\nrole = \"operator\"\n{PATIENT}\n"
    );
    let site = site_at(1, Clock::System, &text).await;
    until_open(&site).await;
    let printed = pymodbus(&["serial", &master_path]).await;
    for line in [
        "monitors 1",
        "good 1",
        "take 2 0",
        "goto 2 0",
        "arrived",
        "open 2 0",
        "opened",
        "wrong key 3 9",
        "stop 2 0",
    ] {
        assert!(printed.lines().any(|it| it == line), "{line}: {printed}");
    }
    assert!(opening(&site) > 0.9);
}

#[tokio::test]
#[ignore = "needs mbpoll"]
async fn mbpoll_reads_and_writes() {
    let address = free();
    let text =
        format!("[[modbus_server]]\nname = \"plc\"\nlisten = \"tcp://{address}\"\n{PATIENT}\n");
    let site = site_at(1, Clock::System, &text).await;
    until("it listens", || std::net::TcpStream::connect(address).is_ok()).await;
    let port = address.port().to_string();
    let mbpoll = async |arguments: &[&str]| {
        let mut command = Command::new("mbpoll");
        command.args(["-m", "tcp", "-p", &port, "-a", "1", "-0", "-1", "-q"]).args(arguments);
        let done =
            tokio::task::spawn_blocking(move || command.output()).await.unwrap().expect("mbpoll");
        String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr)
    };
    for kind in ["3", "4"] {
        let read = mbpoll(&["-t", kind, "-r", "0", "-c", "125", "127.0.0.1"]).await;
        assert!(read.contains("[3]: \t1") && read.contains("[124]:"), "{read}");
    }
    let beyond = mbpoll(&["-t", "4", "-r", "9000", "127.0.0.1"]).await;
    assert!(beyond.contains("Illegal data address"), "{beyond}");
    let beat = HEARTBEAT.to_string();
    let written = mbpoll(&["-t", "4", "-r", &beat, "127.0.0.1", "7"]).await;
    assert!(written.contains("Written 1 references"), "{written}");
    let number = SESSION.to_string();
    let refused = mbpoll(&["-t", "4", "-r", &number, "127.0.0.1", "7"]).await;
    assert!(refused.contains("Illegal data address"), "{refused}");
    drop(site);
}
