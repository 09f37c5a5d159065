//! A serial line, 8N1 (observed: 19200, 57600 and 115200 are in use).

use std::io;
use std::path::Path;

use serial2_tokio::{CharSize, FlowControl, Parity, SerialPort, Settings, StopBits};

/// A port.
#[derive(Debug)]
pub struct Serial(SerialPort);

impl Serial {
    /// Opens a port.
    pub fn open(path: &Path, baud: u32) -> io::Result<Self> {
        let port = SerialPort::open(path, |mut settings: Settings| {
            settings.set_raw();
            settings.set_baud_rate(baud)?;
            settings.set_char_size(CharSize::Bits8);
            settings.set_stop_bits(StopBits::One);
            settings.set_parity(Parity::None);
            settings.set_flow_control(FlowControl::None);
            Ok(settings)
        })?;
        // What came before we listened belongs to nobody.
        port.discard_input_buffer()?;
        Ok(Self(port))
    }

    /// Sends all bytes.
    pub async fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes).await
    }

    /// Waits for bytes.
    pub async fn recv(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        super::not_ended(self.0.read(buffer).await?)
    }
}

impl From<SerialPort> for Serial {
    fn from(port: SerialPort) -> Self {
        Self(port)
    }
}
