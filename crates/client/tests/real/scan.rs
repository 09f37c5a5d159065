//! A scan of a network, on real sockets.

use std::time::Duration;

use lafet_client::scan::{ScanOptions, hosts, scan_network};
use tokio::net::TcpListener;
use tokio::time::timeout;

/// Ports that are open and never answer do not keep other ports from being tried: all are open at the
/// same time.
#[tokio::test]
async fn ports_that_never_answer_are_examined_beside_each_other() {
    const PORTS: usize = 200;
    let listener = TcpListener::bind("0.0.0.0:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let all_open = tokio::spawn(async move {
        let mut open = Vec::new();
        while open.len() < PORTS {
            open.push(listener.accept().await.unwrap());
        }
        open
    });
    let hosts = hosts(&format!("127.0.0.1-{PORTS}")).unwrap();
    // It listens for longer than the test may take, so a port that is held back is never tried.
    let options = ScanOptions { listen: Duration::from_secs(3600), ..ScanOptions::default() };
    let ports = [port];
    let scan = scan_network(&hosts, &ports, false, &options, |_, _| {});
    let bound = Duration::from_secs(60);
    tokio::select! {
        places = scan => panic!("{} places before all were tried", places.len()),
        open = timeout(bound, all_open) => {
            assert_eq!(open.expect("all ports are open at the same time").unwrap().len(), PORTS);
        }
    }
}
