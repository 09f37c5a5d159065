//! A serial line, 8N1 (observed: 19200, 57600 and 115200 are in use).

use std::io;
use std::path::Path;
use std::task::{Context, Poll};

use serial2_tokio::{CharSize, FlowControl, Parity, SerialPort, Settings, StopBits};

use super::port::Claim;
pub use crate::port_error::CannotSwitch;
use crate::url::SerialLine;

/// An open serial port.
#[derive(Debug)]
pub struct Serial {
    port: SerialPort,
    /// Excludes other programs; released after the port is closed.
    _claim: Claim,
}

impl Serial {
    /// Opens a port, for this program only unless the line is shared. It is an error if the kernel
    /// is to switch the direction of an RS-485 transceiver and the port's driver cannot: the bus
    /// would receive nothing, or be blocked.
    ///
    /// # Errors
    ///
    /// The error of the system; with a [`PortError`](super::port::PortError) inside if another
    /// program uses the port, permission is missing or it does not exist; with [`CannotSwitch`]
    /// inside if the driver cannot switch the direction.
    pub fn open(path: &Path, line: &SerialLine) -> io::Result<Self> {
        let mut claim = Claim::lock(path, line.shared)?;
        let port = SerialPort::open(path, |mut settings: Settings| {
            settings.set_raw();
            settings.set_baud_rate(line.baud)?;
            settings.set_char_size(CharSize::Bits8);
            settings.set_stop_bits(StopBits::One);
            settings.set_parity(Parity::None);
            settings.set_flow_control(FlowControl::None);
            Ok(settings)
        })?;
        if !line.shared {
            claim.keep_others_out()?;
        }
        switch_direction(&port, line)?;
        // Bytes from before the port was opened answer no request of this program.
        port.discard_input_buffer()?;
        Ok(Self { port, _claim: claim })
    }

    /// Sends the rest of a frame, of which `sent` bytes are gone.
    pub fn poll_send(
        &mut self,
        cx: &mut Context<'_>,
        frame: &[u8],
        sent: &mut usize,
    ) -> Poll<io::Result<()>> {
        super::poll_write_all(&mut self.port, cx, frame, sent)
    }

    /// Waits for bytes; `UnexpectedEof` at their end.
    pub fn poll_recv(
        &mut self,
        cx: &mut Context<'_>,
        buffer: &mut [u8],
    ) -> Poll<io::Result<usize>> {
        super::poll_read(&mut self.port, cx, buffer)
    }
}

#[cfg(target_os = "linux")]
fn switch_direction(port: &SerialPort, line: &SerialLine) -> io::Result<()> {
    use serial2_tokio::rs4xx::Rs485Config;

    use crate::url::Echo;

    let Some(rs485) = line.rs485 else { return Ok(()) };
    let mut config = Rs485Config::new();
    config.set_invert_rts(rs485.low);
    config.set_delay_before_send(rs485.before);
    config.set_delay_after_send(rs485.after);
    config.set_bus_termination(rs485.terminate);
    // The echo comes from a receiver that stays on while sending.
    config.set_full_duplex(line.echo != Echo::Off);
    port.set_rs4xx_mode(config).map_err(cannot_switch)
}

#[cfg(not(target_os = "linux"))]
fn switch_direction(_: &SerialPort, line: &SerialLine) -> io::Result<()> {
    match line.rs485 {
        None => Ok(()),
        Some(_) => Err(cannot_switch(io::ErrorKind::Unsupported.into())),
    }
}

fn cannot_switch(error: io::Error) -> io::Error {
    io::Error::new(error.kind(), CannotSwitch(error))
}
