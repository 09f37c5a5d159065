//! Programs at the controller: real connections, on a line without monitors.

use std::net::SocketAddr;
use std::time::Duration;

use lafet_client::bus::{ControllerConfig, Driver, DriverConfig, PROGRAMS_MAX};
use lafet_client::transport::Link;
use lafet_client::transport::memory::Memory;
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::{Frame, encode};
use lafet_proto::{RequestId, SubsystemId};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

use super::medium::{Medium, encoded, frames};

/// The controller answers its probe; `false`: the connection is closed.
async fn is_served(program: &mut TcpStream) -> bool {
    let mut wire = [0; 64];
    let len = encode(&Frame { dst: CONTROLLER, src: 129, payload: &[] }, &mut wire).unwrap();
    program.write_all(&wire[..len]).await.is_ok()
        && program.read(&mut wire).await.is_ok_and(|len| len > 0)
}

/// A controller with programs at this listener, on a line without monitors.
fn controller(listener: TcpListener, line: Medium) -> Driver {
    let config = DriverConfig {
        controller: ControllerConfig { addresses: Vec::new(), ..ControllerConfig::default() },
        monitors: "serial:///line".parse().unwrap(),
        consoles: None,
        programs: Some(listener),
    };
    Driver::opening(config, move |_| {
        let link = Link::Memory(Memory::new(line.station(false)));
        async move { Ok(link) }
    })
}

/// Connections that are half open keep no program out: the one that was quiet for longest gives way.
#[tokio::test]
async fn who_is_quiet_gives_way_where_there_are_too_many() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let place = listener.local_addr().unwrap();
    let mut driver = controller(listener, Medium::new(115_200, 0, 1));
    let programs = async {
        let mut programs = as_many_as_there_may_be(place).await;
        let mut more = TcpStream::connect(place).await.unwrap();
        assert!(!is_served(&mut more).await, "all of them have just been heard");
        tokio::time::pause();
        tokio::time::advance(Duration::from_secs(20)).await;
        tokio::time::resume();
        for program in &mut programs[1..] {
            assert!(is_served(program).await);
        }
        tokio::time::pause();
        tokio::time::advance(Duration::from_secs(20)).await;
        tokio::time::resume();
        let mut more = TcpStream::connect(place).await.unwrap();
        assert!(is_served(&mut more).await);
        assert!(!is_served(&mut programs[0]).await, "it was quiet for longest");
        for program in &mut programs[1..] {
            assert!(is_served(program).await);
        }
    };
    tokio::select! {
        () = driver.run(|_| ()) => {}
        () = programs => {}
    }
}

async fn as_many_as_there_may_be(place: SocketAddr) -> Vec<TcpStream> {
    let mut programs = Vec::new();
    for _ in 0..PROGRAMS_MAX {
        let mut program = TcpStream::connect(place).await.unwrap();
        assert!(is_served(&mut program).await);
        programs.push(program);
    }
    programs
}

/// Where all places are taken by programs that are busy, what stops is sent all the same; anything else
/// has no place, and connections that say nothing keep no Stop out.
#[tokio::test]
async fn a_stop_finds_a_place_beside_programs_that_are_busy() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let place = listener.local_addr().unwrap();
    let line = Medium::new(115_200, 0, 1);
    let mut driver = controller(listener, line.clone());
    let programs = async {
        let mut programs = as_many_as_there_may_be(place).await;
        let mut silent = Vec::new();
        for _ in 0..20 {
            silent.push(TcpStream::connect(place).await.unwrap());
        }
        let stop = [RequestId::STOP.0, SubsystemId::ALL.0, 0, 0];
        let mut urgent = TcpStream::connect(place).await.unwrap();
        urgent.write_all(&encoded(1, 129, &stop)).await.unwrap();
        let sent = |written: &[u8]| frames(written).iter().any(|(_, _, payload)| *payload == stop);
        while !line.log().iter().any(|written| sent(&written.bytes)) {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        let mut reads = TcpStream::connect(place).await.unwrap();
        assert!(!is_served(&mut reads).await, "it does not stop anything");
        for program in &mut programs {
            assert!(is_served(program).await);
        }
    };
    tokio::select! {
        () = driver.run(|_| ()) => {}
        done = tokio::time::timeout(Duration::from_secs(20), programs) => {
            done.expect("the Stop is sent");
        }
    }
}

/// Many scripts at the same moment, one for each monitor: none of their Stops is lost.
#[tokio::test]
async fn many_stops_at_once_at_a_full_gateway_are_all_sent() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let place = listener.local_addr().unwrap();
    let line = Medium::new(115_200, 0, 1);
    let mut driver = controller(listener, line.clone());
    let programs = async {
        let _programs = as_many_as_there_may_be(place).await;
        let mut urgent = Vec::new();
        for monitor in 1..=20 {
            let mut one = TcpStream::connect(place).await.unwrap();
            let stop = [RequestId::STOP.0, SubsystemId::ALL.0, 0, 0];
            one.write_all(&encoded(monitor, 129, &stop)).await.unwrap();
            urgent.push(one);
        }
        let stopped = || {
            let log = line.log();
            let all = log.iter().flat_map(|written| frames(&written.bytes));
            let stops = all.filter(|(_, _, payload)| payload.first() == Some(&RequestId::STOP.0));
            stops.map(|(dst, ..)| dst).collect::<std::collections::BTreeSet<u8>>().len()
        };
        while stopped() < 20 {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    tokio::select! {
        () = driver.run(|_| ()) => {}
        done = tokio::time::timeout(Duration::from_secs(20), programs) => {
            done.expect("every Stop is sent");
        }
    }
}
