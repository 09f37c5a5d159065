//! The demonstration as a picture in the terminal.

use super::scene::{Line, Scene, View};
use crate::failure::Failure;

/// x
pub struct Picture;

impl Picture {
    /// x
    pub fn open() -> Result<Self, Failure> {
        Ok(Self)
    }
}

impl View for Picture {
    fn line(&mut self, _: &Line) -> Result<(), Failure> {
        Ok(())
    }
    fn draw(&mut self, _: &Scene) -> Result<(), Failure> {
        Ok(())
    }
    fn close(&mut self, _: &Scene, _: bool) -> Result<(), Failure> {
        Ok(())
    }
}
