//! Answers and frames as Python values.

use std::fmt::Display;

use lafet_client::AnswerBuf;
use lafet_proto::dictionary::layouts;
use lafet_proto::flags::set_flags;
use lafet_proto::link::{self, Decoder, WIRE_MAX};
use lafet_proto::record::Records;
use lafet_texts::{Lang, Shown, Text};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::failures::name;
use crate::requests::Request;
use crate::texts::say;

/// The answer of one subsystem.
#[pyclass(frozen, module = "lafet._native")]
pub struct Answer(AnswerBuf);

impl From<AnswerBuf> for Answer {
    fn from(answer: AnswerBuf) -> Self {
        Self(answer)
    }
}

#[pymethods]
impl Answer {
    /// The request that is answered, by its name.
    #[getter]
    fn request(&self) -> String {
        Shown(&self.0.request()).of(Lang::En)
    }

    /// The subsystem that answers.
    #[getter]
    fn subsystem(&self) -> String {
        Shown(&self.0.from()).of(Lang::En)
    }

    /// The status (§2), by its name.
    #[getter]
    fn status(&self) -> String {
        name(self.0.status())
    }

    /// Whether the request was accepted.
    #[getter]
    fn accepted(&self) -> bool {
        self.0.status().is_success()
    }

    /// The data, not decoded.
    #[getter]
    fn data<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.0.data())
    }

    /// The status word of a state; none of another answer.
    #[getter]
    fn bits(&self) -> Option<u32> {
        self.0.decode().ok()?.data.flags_bits()
    }

    /// The flags that are set in the status word.
    #[getter]
    fn flags(&self) -> Vec<String> {
        let bits = self.bits().unwrap_or(0);
        set_flags(self.0.from(), bits).map(|flag| flag.to_string()).collect()
    }

    /// The fields of the data, in their order.
    fn fields(&self) -> Vec<(&'static str, i64)> {
        let layouts = layouts::of_answer(self.0.request(), self.0.from());
        let layout = layouts.iter().find(|layout| layout.fits(self.0.data()));
        let values = layout.map(|layout| layout.values(self.0.data()));
        values.into_iter().flatten().map(|(_, field, value)| (field.name, value)).collect()
    }

    fn __repr__(&self) -> String {
        format!("<{} of {}: {}>", self.request(), self.subsystem(), self.status())
    }
}

/// A frame of a byte stream.
#[pyclass(frozen, get_all, module = "lafet._native")]
pub struct Frame {
    /// Address of the receiver.
    to: u8,
    /// Address of the sender.
    sender: u8,
    /// Where the frame ends in the bytes.
    end: usize,
    records: Vec<Record>,
}

/// What a frame carries: a request, or an answer. Only the direction distinguishes them.
#[pyclass(frozen, module = "lafet._native")]
#[derive(Clone)]
pub struct Record(AnswerBuf);

#[pymethods]
impl Record {
    /// As the answer of a monitor.
    fn answer(&self) -> Answer {
        Answer(self.0.clone())
    }

    /// As a request to a monitor, in the words of `lafet send`.
    fn request(&self) -> String {
        lafet_proto::text::RequestText(self.0.record()).to_string()
    }
}

/// The bytes of a frame with these requests.
#[pyfunction]
#[pyo3(signature = (requests, to=1, sender=129))]
pub fn encode<'py>(
    py: Python<'py>,
    requests: Vec<PyRef<'py, Request>>,
    to: u8,
    sender: u8,
) -> PyResult<Bound<'py, PyBytes>> {
    let payload: Vec<u8> = requests.iter().flat_map(|it| it.0.bytes().to_vec()).collect();
    let most = link::PAYLOAD_MAX;
    if payload.len() > most {
        let values: [(&str, &dyn Display); 2] = [("size", &payload.len()), ("most", &most)];
        return Err(PyValueError::new_err(say("frame-too-long", &values)));
    }
    let mut wire = [0; WIRE_MAX];
    let frame = link::Frame { dst: to, src: sender, payload: &payload };
    let len = link::encode(&frame, &mut wire).unwrap_or(0);
    Ok(PyBytes::new(py, &wire[..len]))
}

/// The frames in a stream of bytes; bytes that are not a frame are passed over.
#[pyfunction]
pub fn decode(data: &[u8]) -> Vec<Frame> {
    let mut decoder: Decoder = Decoder::new();
    let mut frames = Vec::new();
    for (at, byte) in data.iter().enumerate() {
        if let Some(frame) = decoder.push(*byte) {
            let records = Records::new(frame.payload).map_while(Result::ok);
            let records = records.map(|record| Record(AnswerBuf::new(&record))).collect();
            frames.push(Frame { to: frame.dst, sender: frame.src, end: at + 1, records });
        }
    }
    frames
}
