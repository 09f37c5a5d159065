//! lafet for Python: the part in Rust. What users see is the package `lafet` in `python/`, which gives
//! these classes their types and their documentation.

mod answers;
mod failures;
mod fork;
mod hold;
mod link;
mod operation;
mod requests;
mod runtime;
mod simulator;
mod texts;

use pyo3::prelude::*;

#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::answers::{Answer, Frame, Record, decode, encode};
    #[pymodule_export]
    use crate::failures::set_language;
    #[pymodule_export]
    use crate::fork::{after_fork_in_child, after_fork_in_parent, before_fork};
    #[pymodule_export]
    use crate::hold::Hold;
    #[pymodule_export]
    use crate::link::{Link, connect};
    #[pymodule_export]
    use crate::operation::Operation;
    #[pymodule_export]
    use crate::requests::Request;
    #[pymodule_export]
    use crate::simulator::Simulator;
}
