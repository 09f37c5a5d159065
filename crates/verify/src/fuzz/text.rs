//! Any text as a request: either an error that points into the text, or a request whose own text
//! means the same.

use lafet_proto::record::{DATA_MAX, HEADER_SIZE, Records, Writer};
use lafet_proto::text::{self, RequestText};
use lafet_proto::{DecodeError, Request};

pub fn run(input: &[u8]) -> u64 {
    let text = String::from_utf8_lossy(input);
    let mut buffer = [0; text::BUFFER_SIZE];
    let request = match text::parse(&text, &mut buffer) {
        Ok(request) => request,
        Err(error) => {
            let (start, end) = (error.column, error.column + error.len);
            assert!(text.get(start..end).is_some(), "{start}..{end} of {text:?}");
            if let Some(suggestion) = error.suggestion {
                assert!(!text[start..end].eq_ignore_ascii_case(suggestion), "{suggestion}");
            }
            return error.to_string().len() as u64;
        }
    };
    let bytes = encoded(&request);
    let shown = request.to_string();
    let mut buffer = [0; text::BUFFER_SIZE];
    let again = text::parse(&shown, &mut buffer)
        .unwrap_or_else(|error| panic!("`{shown}` of {text:?} is not read: {error}"));
    assert_eq!(encoded(&again), bytes, "{text:?} is `{shown}`");
    assert_eq!(again.to_string(), shown, "{text:?}");

    let record = Records::new(&bytes).next().expect("a record").expect("a whole record");
    let decoded: Result<Request<'_>, DecodeError> = Request::decode(&record);
    if let Ok(decoded) = decoded {
        assert_eq!(encoded(&decoded), bytes, "{text:?}");
    }
    (bytes.len() + shown.len() + RequestText(record).to_string().len()) as u64
}

fn encoded(request: &Request<'_>) -> Vec<u8> {
    let mut buffer = [0; HEADER_SIZE + DATA_MAX];
    let mut writer = Writer::new(&mut buffer);
    request.encode(&mut writer).expect("what is parsed fits a record");
    writer.written().to_vec()
}
