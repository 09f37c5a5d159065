//! A serial line, 8N1 (observed: 19200, 57600 and 115200 are in use).

use std::io;
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::task::{Context, Poll};

#[cfg(target_os = "linux")]
use serial2::rs4xx::Rs485Config;
use serial2::{CharSize, FlowControl, Parity, Settings, StopBits};

use super::door::Visits;
use super::port::Claim;
pub use crate::port_error::CannotSwitch;
#[cfg(target_os = "linux")]
use crate::url::Echo;
use crate::url::SerialLine;

/// An open serial port, with or without a runtime.
#[derive(Debug)]
pub struct Port<P> {
    port: P,
    /// Excludes other programs; released after the port is closed.
    _claim: Claim,
    /// Keep who has given way from opening the port again; end after the port.
    visits: Visits,
}

impl<P: Opens> Port<P> {
    /// Opens a port, for this program only unless the line is shared. It is an error if the kernel
    /// is to switch the direction of an RS-485 transceiver and the port's driver cannot: the bus
    /// would receive nothing, or be blocked.
    ///
    /// # Errors
    ///
    /// The error of the system; with a [`PortError`](super::port::PortError) inside if another
    /// program uses the port, permission is missing, or it is no serial port or does not exist; with
    /// [`CannotSwitch`] inside if the driver cannot switch the direction.
    pub fn open(path: &Path, line: &SerialLine) -> io::Result<Self> {
        Self::open_for(false, path, line)
    }

    /// The same for what is urgent or not. A Stop that is killed must not keep out the next one, so it
    /// excludes only programs that lock as well.
    pub(crate) fn open_for(urgent: bool, path: &Path, line: &SerialLine) -> io::Result<Self> {
        let mut claim = Claim::lock(path, line.shared)?;
        let port = P::open(path, line.baud)?;
        if !line.shared && !urgent {
            claim.keep_others_out()?;
        }
        port.switch_direction(line)?;
        // Bytes from before the port was opened answer no request of this program.
        port.discard_input()?;
        Ok(Self { port, _claim: claim, visits: Visits::default() })
    }

    /// Ends visits together with the port.
    pub(crate) fn visiting(mut self, visits: Visits) -> Self {
        self.visits = visits;
        self
    }
}

impl<P> Deref for Port<P> {
    type Target = P;

    fn deref(&self) -> &P {
        &self.port
    }
}

impl<P> DerefMut for Port<P> {
    fn deref_mut(&mut self) -> &mut P {
        &mut self.port
    }
}

/// What opening a port needs of a library.
pub trait Opens: Sized {
    /// Opens a port with this speed, 8N1.
    ///
    /// # Errors
    ///
    /// The error of the system.
    fn open(path: &Path, baud: u32) -> io::Result<Self>;

    /// Makes the kernel switch the direction of a transceiver, if the line requires it.
    ///
    /// # Errors
    ///
    /// With [`CannotSwitch`] inside if the driver cannot.
    fn switch_direction(&self, line: &SerialLine) -> io::Result<()>;

    /// Drops received bytes.
    ///
    /// # Errors
    ///
    /// The error of the system.
    fn discard_input(&self) -> io::Result<()>;
}

macro_rules! opens {
    ($port:ty) => {
        impl Opens for $port {
            fn open(path: &Path, baud: u32) -> io::Result<Self> {
                Self::open(path, |settings| configured(settings, baud))
            }

            #[cfg(target_os = "linux")]
            fn switch_direction(&self, line: &SerialLine) -> io::Result<()> {
                match rs485(line) {
                    Some(config) => self.set_rs4xx_mode(config).map_err(cannot_switch),
                    None => Ok(()),
                }
            }

            #[cfg(not(target_os = "linux"))]
            fn switch_direction(&self, line: &SerialLine) -> io::Result<()> {
                match line.rs485 {
                    Some(_) => Err(cannot_switch(io::ErrorKind::Unsupported.into())),
                    None => Ok(()),
                }
            }

            fn discard_input(&self) -> io::Result<()> {
                self.discard_input_buffer()
            }
        }
    };
}

opens!(serial2::SerialPort);
opens!(serial2_tokio::SerialPort);

fn configured(mut settings: Settings, baud: u32) -> io::Result<Settings> {
    settings.set_raw();
    settings.set_baud_rate(baud)?;
    settings.set_char_size(CharSize::Bits8);
    settings.set_stop_bits(StopBits::One);
    settings.set_parity(Parity::None);
    settings.set_flow_control(FlowControl::None);
    Ok(settings)
}

/// A port in the runtime.
pub type Serial = Port<serial2_tokio::SerialPort>;

impl Serial {
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
fn rs485(line: &SerialLine) -> Option<Rs485Config> {
    let rs485 = line.rs485?;
    let mut config = Rs485Config::new();
    config.set_invert_rts(rs485.low);
    config.set_delay_before_send(rs485.before);
    config.set_delay_after_send(rs485.after);
    config.set_bus_termination(rs485.terminate);
    // The echo comes from a receiver that stays on while sending.
    config.set_full_duplex(line.echo != Echo::Off);
    Some(config)
}

fn cannot_switch(error: io::Error) -> io::Error {
    io::Error::new(error.kind(), CannotSwitch(error))
}
