//! The servers that this program is: an echo, and tokio-modbus.

use std::future;

use lafet_proto::{RequestId, SubsystemId, link};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;
use tokio_modbus::prelude::*;
use tokio_modbus::server::Service;
use tokio_modbus::server::tcp::{Server, accept_tcp_connection};

/// Bytes of a request for the state of a drive in its frame, and of the answer.
pub const REQUEST: usize = 11;
/// See [`REQUEST`].
pub const ANSWER: usize = 19;

/// Serves for ever.
pub async fn serve(who: &str, port: &str) -> Result<(), String> {
    let listener = TcpListener::bind(format!("127.0.0.1:{port}")).await;
    let listener = listener.map_err(|e| format!("{port}: {e}"))?;
    match who {
        "echo" => echo(listener).await,
        "tokio-modbus" => modbus(listener).await,
        _ => Err(format!("no contender is called {who}")),
    }
}

/// The state of a drive at rest, from monitor 1 to console 129.
fn answer() -> [u8; ANSWER] {
    let mut record = [0; 4 + 8];
    record[..4].copy_from_slice(&[RequestId::GET_STATUS.0, SubsystemId::VERTICAL.0, 0, 8]);
    let (mut frame, mut wire) = ([0; ANSWER], [0; link::wire_max(4 + 8)]);
    let of = link::Frame { dst: 129, src: 1, payload: &record };
    let len = link::encode(&of, &mut wire).unwrap_or_default();
    frame[..len].copy_from_slice(&wire[..len]);
    frame
}

/// What a monitor would answer, without a look at what it is asked.
async fn echo(listener: TcpListener) -> Result<(), String> {
    let answers: &'static [u8] = answer().repeat(512 / REQUEST + 1).leak();
    loop {
        let (mut stream, _) = listener.accept().await.map_err(|e| e.to_string())?;
        stream.set_nodelay(true).map_err(|e| e.to_string())?;
        tokio::spawn(async move {
            let (mut bytes, mut left) = ([0; 512], 0);
            while let Ok(count @ 1..) = stream.read(&mut bytes).await {
                left += count;
                let wanted = left / REQUEST * ANSWER;
                left %= REQUEST;
                if stream.write_all(&answers[..wanted]).await.is_err() {
                    return;
                }
            }
        });
    }
}

/// 16 registers.
#[derive(Clone)]
struct Registers([u16; 16]);

impl Service for Registers {
    type Request = Request<'static>;
    type Response = Response;
    type Exception = ExceptionCode;
    type Future = future::Ready<Result<Response, ExceptionCode>>;

    fn call(&self, request: Self::Request) -> Self::Future {
        let Request::ReadHoldingRegisters(first, count) = request else {
            return future::ready(Err(ExceptionCode::IllegalFunction));
        };
        let (first, count) = (usize::from(first), usize::from(count));
        let values = self.0.get(first..first + count).map(<[u16]>::to_vec);
        let answer = values.map(Response::ReadHoldingRegisters);
        future::ready(answer.ok_or(ExceptionCode::IllegalDataAddress))
    }
}

async fn modbus(listener: TcpListener) -> Result<(), String> {
    let server = Server::new(listener);
    let registers = |_| Ok(Some(Registers([0x41; 16])));
    let connected = |stream: tokio::net::TcpStream, address| async move {
        stream.set_nodelay(true)?;
        accept_tcp_connection(stream, address, registers)
    };
    server.serve(&connected, |_| {}).await.map_err(|e| e.to_string())
}
