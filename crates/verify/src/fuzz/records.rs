//! A frame's payload as requests and as answers: what decodes is encoded to the same bytes; what
//! does not still has a text, which parses to the same record.

use lafet_proto::record::{DATA_MAX, HEADER_SIZE, Record, Records, Writer};
use lafet_proto::text::{self, AnswerText, Exchange, RequestText};
use lafet_proto::{Answer, Request, Status, SubsystemId};

const RECORD_MAX: usize = HEADER_SIZE + DATA_MAX;

pub fn run(input: &[u8]) -> u64 {
    let mut records = Records::new(input);
    let (mut at, mut work) = (0, 0);
    while let Some(next) = records.next() {
        match next {
            Ok(record) => {
                at += record.size();
                assert_eq!((records.offset(), records.rest()), (at, &input[at..]));
                work += record_as_it_is(&record) + request(&record) + answer(&record);
            }
            Err(error) => {
                assert!(error.offset >= at && error.offset <= input.len(), "{error}");
                assert!(records.rest().is_empty(), "something comes after an error");
                assert!(!error.to_string().is_empty());
            }
        }
    }
    assert!(records.next().is_none());
    work
}

fn written(write: impl FnOnce(&mut Writer<'_>)) -> Vec<u8> {
    let mut buffer = [0; RECORD_MAX];
    let mut writer = Writer::new(&mut buffer);
    write(&mut writer);
    writer.written().to_vec()
}

fn only(bytes: &[u8]) -> Record<'_> {
    let mut records = Records::new(bytes);
    let record = records.next().expect("a record").expect("a whole record");
    assert_eq!(records.next(), None, "more than a record");
    record
}

fn record_as_it_is(record: &Record<'_>) -> u64 {
    let bytes = written(|writer| writer.push(record).expect("255 bytes fit"));
    assert_eq!(only(&bytes), *record);
    let mut short = vec![0xEE; bytes.len() - 1];
    let mut writer = Writer::new(&mut short);
    assert!(writer.push(record).is_err() && writer.is_empty(), "half a record");
    bytes.len() as u64
}

fn request(record: &Record<'_>) -> u64 {
    let shown = RequestText(*record).to_string();
    if let Ok(request) = Request::decode(record) {
        let bytes = written(|writer| request.encode(writer).expect("it was a record"));
        let again = only(&bytes);
        assert_eq!(again, Record { status: Status::OK, ..*record }, "{request:?}");
        assert_eq!(Request::decode(&again), Ok(request));
        assert_eq!(request.to, record.device);
    }
    let mut buffer = [0; text::BUFFER_SIZE];
    let read = text::parse(&shown, &mut buffer)
        .unwrap_or_else(|error| panic!("`{shown}` is not read: {error}"));
    let bytes = written(|writer| read.encode(writer).expect("it was a record"));
    assert_eq!(only(&bytes), Record { status: Status::OK, ..*record }, "{shown}");
    (shown.len() + bytes.len()) as u64
}

fn answer(record: &Record<'_>) -> u64 {
    let mut shown = AnswerText(*record).to_string();
    assert!(!shown.is_empty());
    if let Ok(answer) = Answer::decode(record) {
        let bytes = written(|writer| answer.encode(writer).expect("it was a record"));
        let again = only(&bytes);
        assert_eq!(Answer::decode(&again), Ok(answer));
        assert_eq!((again.request, again.device), (record.request, record.device));
        assert_eq!(again.status, record.status);
        let to = SubsystemId::ALL;
        shown += &Exchange { to, answer }.to_string();
    }
    shown.len() as u64
}
