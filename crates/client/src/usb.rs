//! A USB adapter behind a serial port.

use std::fmt;

/// Description of a USB adapter, from the adapter itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Usb {
    /// Vendor, four hexadecimal digits.
    pub vendor_id: String,
    /// Product, four hexadecimal digits.
    pub product_id: String,
    /// The vendor's name.
    pub vendor: Option<String>,
    /// The product's name.
    pub product: Option<String>,
    /// Its serial number.
    pub serial: Option<String>,
}

impl fmt::Display for Usb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(product) = &self.product {
            write!(f, "{product} ")?;
        }
        write!(f, "{}:{}", self.vendor_id, self.product_id)?;
        self.serial.iter().try_for_each(|serial| write!(f, " {serial}"))
    }
}
