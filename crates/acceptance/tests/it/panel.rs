//! The panel of the site: a Modbus server that is not ours, and what is wired to it.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rmodbus::server::ModbusFrame;
use rmodbus::server::context::ModbusContext;
use rmodbus::server::storage::ModbusStorageSmall;
use rmodbus::{ModbusFrameBuf, ModbusProto, guess_request_frame_len};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

#[derive(Clone, Default)]
pub struct Panel {
    memory: Arc<Mutex<ModbusStorageSmall>>,
}

impl Panel {
    pub async fn listen() -> (Self, SocketAddr) {
        let panel = Self::default();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let own = panel.clone();
        tokio::spawn(async move {
            loop {
                let (stream, _) = listener.accept().await.unwrap();
                tokio::spawn(own.clone().serve(stream));
            }
        });
        (panel, address)
    }

    fn memory(&self) -> MutexGuard<'_, ModbusStorageSmall> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn coil(&self, at: u16) -> bool {
        self.memory().get_coil(at).unwrap()
    }

    pub fn set(&self, at: u16, on: bool) {
        self.memory().set_discrete(at, on).unwrap();
    }

    async fn serve(self, mut stream: TcpStream) {
        let mut received = Vec::new();
        let mut buffer = [0; 256];
        while let Ok(len @ 1..) = stream.read(&mut buffer).await {
            received.extend_from_slice(&buffer[..len]);
            while let Ok(len) = guess_request_frame_len(&received, ModbusProto::TcpUdp) {
                if received.len() < usize::from(len) {
                    break;
                }
                let request: Vec<u8> = received.drain(..usize::from(len)).collect();
                if stream.write_all(&self.answer(&request)).await.is_err() {
                    return;
                }
            }
        }
    }

    /// Units above 9 are not there.
    fn answer(&self, request: &[u8]) -> Vec<u8> {
        let mut frame: ModbusFrameBuf = [0; 256];
        frame[..request.len()].copy_from_slice(request);
        let mut answer = Vec::new();
        if request[6] > 9 {
            return answer;
        }
        let mut frame = ModbusFrame::new(request[6], &frame, ModbusProto::TcpUdp, &mut answer);
        frame.parse().expect("a sound request");
        if frame.processing_required {
            match frame.readonly {
                true => frame.process_read(&*self.memory()).expect("it is read"),
                false => frame.process_write(&mut *self.memory()).expect("it is written"),
            }
        }
        frame.finalize_response().expect("it fits");
        answer
    }
}
