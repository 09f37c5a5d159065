//! Programs at the controller: real connections, on a line without monitors.

use std::time::Duration;

use lafet_client::bus::{ControllerConfig, Driver, DriverConfig, PROGRAMS_MAX};
use lafet_client::transport::Link;
use lafet_client::transport::memory::Memory;
use lafet_proto::bus::CONTROLLER;
use lafet_proto::link::{Frame, encode};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

use super::medium::Medium;

/// The controller answers its probe; `false`: the connection is closed.
async fn is_served(program: &mut TcpStream) -> bool {
    let mut wire = [0; 64];
    let len = encode(&Frame { dst: CONTROLLER, src: 129, payload: &[] }, &mut wire).unwrap();
    program.write_all(&wire[..len]).await.is_ok()
        && program.read(&mut wire).await.is_ok_and(|len| len > 0)
}

/// Connections that are half open keep no program out: the one that was quiet for longest gives way.
#[tokio::test]
async fn who_is_quiet_gives_way_where_there_are_too_many() {
    let line = Medium::new(115_200, 0, 1);
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let place = listener.local_addr().unwrap();
    let config = DriverConfig {
        controller: ControllerConfig { addresses: Vec::new(), ..ControllerConfig::default() },
        monitors: "serial:///line".parse().unwrap(),
        consoles: None,
        programs: Some(listener),
    };
    let mut driver = Driver::opening(config, move |_| {
        let link = Link::Memory(Memory::new(line.station(false)));
        async move { Ok(link) }
    });
    let programs = async {
        let mut programs = Vec::new();
        for _ in 0..PROGRAMS_MAX {
            let mut program = TcpStream::connect(place).await.unwrap();
            assert!(is_served(&mut program).await);
            programs.push(program);
        }
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
