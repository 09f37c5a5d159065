//! Payloads of Sparkplug B in the encoding of Protocol Buffers: of the format what an edge node needs. Other fields are
//! skipped when they are read.

use prost::Message;

/// Longest payload that is read, bytes.
pub const PAYLOAD_MAX: usize = 4096;

/// Numbers of data types.
pub mod datatype {
    /// A signed number of 32 bits.
    pub const INT32: u32 = 3;
    /// A signed number of 64 bits.
    pub const INT64: u32 = 4;
    /// A fraction of 64 bits.
    pub const DOUBLE: u32 = 10;
    /// True or false.
    pub const BOOLEAN: u32 = 11;
    /// A text.
    pub const STRING: u32 = 12;
}

/// A payload.
#[derive(Clone, PartialEq, Message)]
pub struct Payload {
    /// When it was sent, ms since 1970.
    #[prost(uint64, optional, tag = "1")]
    pub timestamp: Option<u64>,
    /// The metrics.
    #[prost(message, repeated, tag = "2")]
    pub metrics: Vec<Metric>,
    /// Its place in the sequence, 0…255; a death of the node has none.
    #[prost(uint64, optional, tag = "3")]
    pub seq: Option<u64>,
}

/// A metric.
#[derive(Clone, PartialEq, Message)]
pub struct Metric {
    /// Its name; between births of the node the alias alone.
    #[prost(string, optional, tag = "1")]
    pub name: Option<String>,
    /// Its number within the node.
    #[prost(uint64, optional, tag = "2")]
    pub alias: Option<u64>,
    /// When it was so, ms since 1970.
    #[prost(uint64, optional, tag = "3")]
    pub timestamp: Option<u64>,
    /// Its data type.
    #[prost(uint32, optional, tag = "4")]
    pub datatype: Option<u32>,
    /// It was so earlier, and is not the present value.
    #[prost(bool, optional, tag = "5")]
    pub is_historical: Option<bool>,
    /// There is no value.
    #[prost(bool, optional, tag = "7")]
    pub is_null: Option<bool>,
    /// What is said of it besides.
    #[prost(message, optional, tag = "9")]
    pub properties: Option<PropertySet>,
    /// The value.
    #[prost(oneof = "Value", tags = "10, 11, 12, 13, 14, 15")]
    pub value: Option<Value>,
}

/// A value. Signed numbers are in two's complement.
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum Value {
    /// Of up to 32 bits.
    #[prost(uint32, tag = "10")]
    Int(u32),
    /// Of up to 64 bits.
    #[prost(uint64, tag = "11")]
    Long(u64),
    /// A fraction of 32 bits.
    #[prost(float, tag = "12")]
    Float(f32),
    /// A fraction of 64 bits.
    #[prost(double, tag = "13")]
    Double(f64),
    /// True or false.
    #[prost(bool, tag = "14")]
    Boolean(bool),
    /// A text.
    #[prost(string, tag = "15")]
    Text(String),
}

/// Properties: the values in the order of their keys.
#[derive(Clone, PartialEq, Message)]
pub struct PropertySet {
    /// The keys.
    #[prost(string, repeated, tag = "1")]
    pub keys: Vec<String>,
    /// The values.
    #[prost(message, repeated, tag = "2")]
    pub values: Vec<PropertyValue>,
}

/// The value of a property.
#[derive(Clone, PartialEq, Message)]
pub struct PropertyValue {
    /// Its data type.
    #[prost(uint32, optional, tag = "1")]
    pub datatype: Option<u32>,
    /// The value.
    #[prost(oneof = "Property", tags = "3, 6, 8")]
    pub value: Option<Property>,
}

/// What a property can be.
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum Property {
    /// A number of 32 bits.
    #[prost(uint32, tag = "3")]
    Int(u32),
    /// A fraction.
    #[prost(double, tag = "6")]
    Double(f64),
    /// A text.
    #[prost(string, tag = "8")]
    Text(String),
}

impl PropertySet {
    /// One more.
    pub fn with(mut self, key: &str, value: Property) -> Self {
        let datatype = match value {
            Property::Int(_) => datatype::INT32,
            Property::Double(_) => datatype::DOUBLE,
            Property::Text(_) => datatype::STRING,
        };
        self.keys.push(key.to_owned());
        self.values.push(PropertyValue { datatype: Some(datatype), value: Some(value) });
        self
    }
}

/// Reads a payload; `None`: it is none, or too long.
pub fn read(bytes: &[u8]) -> Option<Payload> {
    if bytes.len() > PAYLOAD_MAX {
        return None;
    }
    Payload::decode(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hex(text: &str) -> Vec<u8> {
        let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
        let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16);
        digits.chunks(2).map(|pair| byte(pair).unwrap()).collect()
    }

    /// Made by the protobuf library of Google from the description that mqtt-spb-wrapper 2.1.2 has.
    const BIRTH: &str = "08fbd095ffbc31126c0a085472617665727365106618e4d095ffbc31200a4a4c0a075175616c69747\
        90a07656e67556e69740a06656e674c6f770a07656e67486967681205080318c0011206080c4202c2b0120b080a310000000\
        0008076c0120b080a31000000000080764069d122dbf97e2a24c018ff01";
    const DATA: &str = "08fbd095ffbc31121a10681801280138014a100a075175616c6974791205080318f403120b10cc01180\
        250f9ffffff0f120b102c1803588080808080201206106d18047000120d106418057a0762795f68616e641800";
    /// Made by mqtt-spb-wrapper 2.1.2 itself.
    const STOP: &str = "08fbd095ffbc3112190a0c436f6d6d616e642f53746f7018e4d095ffbc31200b70011800";
    /// Made by pysparkplug 0.6.1.
    const WRITES: &str = "08fbd095ffbc3112220a05416c69766518e4d095ffbc31200c7a10303030303030303030\
        30303030306666122b0a0c436f6d6d616e642f5465787418e4d095ffbc31200c7a127b22\
        636f6d6d616e64223a2273746f70227d12210a144e6f646520436f6e74726f6c2f526562\
        6972746818e4d095ffbc31200b7001";

    fn alias(alias: u64, timestamp: u64, value: Option<Value>) -> Metric {
        let (alias, timestamp) = (Some(alias), Some(timestamp));
        Metric { alias, timestamp, value, ..Metric::default() }
    }

    #[test]
    fn a_birth_is_byte_for_byte_that_of_another_implementation() {
        let properties = PropertySet::default()
            .with("Quality", Property::Int(192))
            .with("engUnit", Property::Text("°".into()))
            .with("engLow", Property::Double(-360.0))
            .with("engHigh", Property::Double(360.0));
        let metric = Metric {
            name: Some("Traverse".into()),
            datatype: Some(datatype::DOUBLE),
            properties: Some(properties),
            ..alias(102, 1_700_000_000_100, Some(Value::Double(-10.083)))
        };
        let (timestamp, seq) = (Some(1_700_000_000_123), Some(255));
        let payload = Payload { timestamp, metrics: vec![metric], seq };
        assert_eq!(payload.encode_to_vec(), hex(BIRTH));
        assert_eq!(read(&hex(BIRTH)), Some(payload));
    }

    #[test]
    fn data_are_byte_for_byte_those_of_another_implementation() {
        let past = Metric {
            is_historical: Some(true),
            is_null: Some(true),
            properties: Some(PropertySet::default().with("Quality", Property::Int(500))),
            ..alias(104, 1, None)
        };
        let metrics = vec![
            past,
            alias(204, 2, Some(Value::Int((-7_i32).cast_unsigned()))),
            alias(44, 3, Some(Value::Long(1 << 40))),
            alias(109, 4, Some(Value::Boolean(false))),
            alias(100, 5, Some(Value::Text("by_hand".into()))),
        ];
        let payload = Payload { timestamp: Some(1_700_000_000_123), metrics, seq: Some(0) };
        assert_eq!(payload.encode_to_vec(), hex(DATA));
        assert_eq!(read(&hex(DATA)), Some(payload));
    }

    #[test]
    fn commands_of_other_implementations_are_read() {
        let names = |text: &str| -> Vec<(String, Option<Value>)> {
            let metrics = read(&hex(text)).expect("a payload").metrics;
            metrics.into_iter().map(|it| (it.name.unwrap_or_default(), it.value)).collect()
        };
        let text = |it: &str| Some(Value::Text(it.to_owned()));
        let stop = ("Command/Stop".to_owned(), Some(Value::Boolean(true)));
        assert_eq!(names(STOP), [stop]);
        let writes = [
            ("Alive".to_owned(), text("00000000000000ff")),
            ("Command/Text".to_owned(), text(r#"{"command":"stop"}"#)),
            ("Node Control/Rebirth".to_owned(), Some(Value::Boolean(true))),
        ];
        assert_eq!(names(WRITES), writes);
    }

    #[test]
    fn what_is_none_or_too_long_is_not_read() {
        for wrong in [vec![0xFF; 9], vec![0x12, 0x7F, 0x00], vec![0; PAYLOAD_MAX + 1]] {
            assert_eq!(read(&wrong), None, "{} bytes", wrong.len());
        }
        // Fields that are not known here: a uuid, and a metric that is a template.
        let mut more = hex(STOP);
        more.extend([0x22, 1, b'u', 0x12, 3, 0x92, 0x01, 0]);
        assert_eq!(read(&more).map(|it| it.metrics.len()), Some(2));
    }
}
