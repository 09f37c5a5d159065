//! The bytes of a frame, field by field.

use lafet_proto::dictionary::{self, layouts};
use lafet_proto::flags;
use lafet_proto::link::{self, BODY_MAX, Check};
use lafet_proto::param::{Param, Unit};
use lafet_proto::record::Records;
use lafet_proto::text::{AnswerText, RequestText};
use lafet_proto::{DecodeError, Record, SubsystemId};
use lafet_texts::{Shown, Text, Undecodable, Words, decimal_mark, play as text};

use crate::view::{Anatomy, Flag, Part, words};

/// Whose frame it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    Request,
    Answer,
}

impl Anatomy {
    /// Names every byte of a frame, or says why it is none.
    pub fn of(way: Way, wire: &[u8]) -> Result<Self, DecodeError> {
        let mut body = [0; BODY_MAX];
        let check = link::check_of(wire);
        let end = 2 + link::decode_datagram(wire, &mut body)?.payload.len();
        let body = body.get(..end + check.size()).unwrap_or_default();
        let [dst, src] = [0, 1].map(|it| same(body.get(it).copied().unwrap_or_default()));
        let payload = body.get(2..end).unwrap_or_default();
        let mut parts = Parts { sizes: Vec::new(), record: None, parts: Vec::new() };
        parts.put("dst", 1, dst, text::FieldReceiver.words());
        parts.put("src", 1, src, text::FieldSender.words());
        let texts = parts.records(way, payload);
        let meaning = match check {
            Check::Crc16 => text::FieldCrc16.words(),
            Check::Crc32c => text::FieldCrc32c.words(),
        };
        parts.put("crc", check.size(), hex(body.get(end..).unwrap_or_default()), meaning);
        let size: usize = body.iter().map(|byte| link::size_on_wire(*byte)).sum();
        let start = wire.len().saturating_sub(size + 1);
        Ok(Self { bytes: wire.to_vec(), parts: parts.on_wire(start, body), text: texts })
    }
}

struct Parts {
    /// Length of each part in the unescaped bytes.
    sizes: Vec<usize>,
    record: Option<usize>,
    parts: Vec<Part>,
}

impl Parts {
    fn put(&mut self, name: &str, len: usize, value: Words, meaning: Words) {
        self.sizes.push(len);
        let (name, record) = (name.to_owned(), self.record);
        self.parts.push(Part { at: 0, len: 0, record, name, value, meaning, flags: Vec::new() });
    }

    /// All records; the text of each.
    fn records(&mut self, way: Way, payload: &[u8]) -> Vec<String> {
        let mut texts = Vec::new();
        let mut records = Records::new(payload);
        loop {
            let rest = records.rest();
            self.record = Some(texts.len());
            match records.next() {
                None => break,
                Some(Ok(record)) => {
                    self.record(way, &record);
                    texts.push(match way {
                        Way::Request => RequestText(record).to_string(),
                        Way::Answer => AnswerText(record).to_string(),
                    });
                }
                Some(Err(error)) => {
                    self.put("?", rest.len(), hex(rest), Undecodable(&error).words());
                    texts.push(format!("# {error}"));
                }
            }
        }
        self.record = None;
        texts
    }

    fn record(&mut self, way: Way, record: &Record<'_>) {
        let Record { request, device, status, data } = *record;
        let info = dictionary::request(request);
        let meaning = match info {
            Some(info) => {
                let (title, section) = (info.title, info.section);
                text::FieldRequest { title: &title, section }.words()
            }
            None => text::RequestUnknown.words(),
        };
        let name = info.map_or_else(|| format!("{:#04x}", request.0), |it| it.name.to_owned());
        self.put("request", 1, Words::same(name), meaning);
        let title: &dyn Text = match dictionary::subsystem(device) {
            Some(info) => &info.title,
            None => &text::SubsystemUnknown,
        };
        let meaning = match way {
            Way::Request => text::FieldAddressee { title }.words(),
            Way::Answer => text::FieldAnswerer { title }.words(),
        };
        self.put("device", 1, Words::same(device.to_string()), meaning);
        let meaning = match (way, dictionary::status(status)) {
            (Way::Request, _) => text::FieldNoStatus.words(),
            (Way::Answer, Some(info)) => info.meaning.words(),
            (Way::Answer, None) => text::StatusUnknown.words(),
        };
        let shown = match way {
            Way::Request => status.0.to_string(),
            Way::Answer => status.to_string(),
        };
        self.put("status", 1, Words::same(shown), meaning);
        let size = Words::same(data.len().to_string());
        self.put("data_size", 1, size, text::FieldDataSize.words());
        self.data(way, record);
    }

    fn data(&mut self, way: Way, record: &Record<'_>) {
        let Record { request, device, data, .. } = *record;
        let layouts = match way {
            Way::Request => layouts::of_request(request),
            Way::Answer => layouts::of_answer(request, device),
        };
        let layout = layouts.iter().find(|layout| layout.fits(data));
        let mut end = 0;
        let mut param = None;
        for (index, (at, field, value)) in
            layout.into_iter().flat_map(|layout| layout.values(data)).enumerate()
        {
            end = at + field.kind.size();
            let mut shown = shown(field.unit, value);
            match field.kind {
                layouts::Kind::Flags => shown = Words::same(format!("{value:#010x}")),
                layouts::Kind::Key => shown = Words::same(format!("{value:#06x}")),
                layouts::Kind::ParamId => {
                    let id = lafet_proto::ParamId(value as u16);
                    param = Param::find(device, id);
                    let name = param.map_or_else(|| id.to_string(), |it| it.name().to_owned());
                    shown = Words::same(name);
                }
                _ => {}
            }
            // The values of a parameter have the parameter's units.
            if let Some(param) = param.filter(|_| index > 0) {
                shown = self::shown(param.spec().element(index - 1).unit, value);
            }
            self.put(field.name, field.kind.size(), shown, field.text.words());
            if let (layouts::Kind::Flags, Some(part)) = (field.kind, self.parts.last_mut()) {
                part.flags = flags_of(device, value as u32);
            }
        }
        let rest = data.get(end..).unwrap_or_default();
        if !rest.is_empty() {
            self.put("data", rest.len(), hex(rest), text::FieldDataUnknown.words());
        }
    }

    /// The parts at their places on the wire, where some bytes are escaped; `start` bytes are before
    /// dst.
    fn on_wire(self, start: usize, body: &[u8]) -> Vec<Part> {
        let mark = |at, len, name: &str, meaning| Part {
            at,
            len,
            record: None,
            name: name.to_owned(),
            value: Words::default(),
            meaning,
            flags: Vec::new(),
        };
        let mut all = vec![mark(0, start, "start", text::FieldStart.words())];
        let (mut at, mut rest) = (start, body);
        for (mut part, len) in self.parts.into_iter().zip(self.sizes) {
            let (own, others) = rest.split_at_checked(len).unwrap_or((rest, &[]));
            rest = others;
            let size = own.iter().map(|byte| link::size_on_wire(*byte)).sum();
            if size > len {
                part.meaning = text::Escaped { meaning: &part.meaning }.words();
            }
            (part.at, part.len) = (at, size);
            at += size;
            all.push(part);
        }
        all.push(mark(at, 1, "end", text::FieldEnd.words()));
        all
    }
}

/// The flags that are set, with their meanings.
pub fn flags_of(subsystem: SubsystemId, bits: u32) -> Vec<Flag> {
    let class = flags::flags_of(subsystem);
    let set = class.set(bits).map(|flag| Flag {
        name: flag.to_string(),
        severity: severity(flag.severity()),
        meaning: words(lafet_texts::dictionary(flag.info.meaning)),
        remedy: words(lafet_texts::dictionary(flag.info.remedy)),
    });
    set.collect()
}

/// The name of a severity, as the page's styles have it.
pub fn severity(severity: flags::Severity) -> String {
    format!("{severity:?}").to_lowercase()
}

/// A value with its unit, tenths as a decimal fraction.
pub fn shown(unit: Unit, value: i64) -> Words {
    let (tenths, unit) = match unit {
        Unit::None | Unit::Choice => return Words::same(value.to_string()),
        Unit::Bits => return Words::same(format!("{value:#x}")),
        Unit::DeciAmpere => (true, text::Ampere.words()),
        Unit::DeciCelsius => (true, text::Celsius.words()),
        Unit::DeciAtmosphere => (true, text::Atmosphere.words()),
        Unit::DeciSecond => (true, Unit::Second.name().map(|it| it.words()).unwrap_or_default()),
        Unit::DeciMillimetre => {
            (true, Unit::Millimetre.name().map(|it| it.words()).unwrap_or_default())
        }
        other => (false, other.name().map(|it| it.words()).unwrap_or_default()),
    };
    Words::each(|lang| {
        let sign = if value < 0 { "−" } else { "" };
        let size = value.unsigned_abs();
        let number = match tenths {
            true => format!("{sign}{}{}{}", size / 10, decimal_mark(lang), size % 10),
            false => format!("{sign}{size}"),
        };
        let unit = unit.of(lang);
        let space = if matches!(unit, "'" | "°" | "") { "" } else { "\u{a0}" };
        format!("{number}{space}{unit}")
    })
}

fn hex(bytes: &[u8]) -> Words {
    let digits: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    Words::same(digits.join(" "))
}

/// What shows itself in every language.
pub fn same(text: impl std::fmt::Display) -> Words {
    Shown(text).words()
}
