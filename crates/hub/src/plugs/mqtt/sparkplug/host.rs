//! A host application, made from the specification alone, with a reader of its own: what it shows is what a host of
//! others would.

use std::collections::{BTreeMap, BTreeSet};

/// A value on the wire.
#[derive(Clone, Debug, PartialEq)]
pub enum Wire {
    Number(u64),
    Double(f64),
    Bytes(Vec<u8>),
}

impl Wire {
    pub fn text(&self) -> String {
        match self {
            Self::Bytes(bytes) => String::from_utf8(bytes.clone()).expect("a text"),
            other => panic!("{other:?}"),
        }
    }

    fn number(&self) -> u64 {
        match self {
            Self::Number(number) => *number,
            other => panic!("{other:?}"),
        }
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            other => panic!("{other:?}"),
        }
    }
}

fn varint(bytes: &mut &[u8]) -> u64 {
    let (mut number, mut shift) = (0, 0);
    loop {
        let (first, rest) = bytes.split_first().expect("a byte");
        *bytes = rest;
        number |= u64::from(first & 0x7F) << shift;
        if first & 0x80 == 0 {
            return number;
        }
        shift += 7;
    }
}

fn fields(mut bytes: &[u8]) -> Vec<(u64, Wire)> {
    let mut fields = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let value = match key & 7 {
            0 => Wire::Number(varint(&mut bytes)),
            1 => {
                let (eight, rest) = bytes.split_at(8);
                bytes = rest;
                Wire::Double(f64::from_le_bytes(eight.try_into().unwrap()))
            }
            2 => {
                let length = usize::try_from(varint(&mut bytes)).unwrap();
                let (taken, rest) = bytes.split_at(length);
                bytes = rest;
                Wire::Bytes(taken.to_vec())
            }
            kind => panic!("wire type {kind}"),
        };
        fields.push((key >> 3, value));
    }
    fields
}

fn one(fields: &[(u64, Wire)], number: u64) -> Option<&Wire> {
    fields.iter().find(|(it, _)| *it == number).map(|(_, value)| value)
}

/// What is known of a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    datatype: u64,
    pub value: Option<Wire>,
    pub at_ms: u64,
    pub quality: Option<u64>,
}

/// A device.
#[derive(Debug, Default)]
pub struct Device {
    pub online: bool,
    pub metrics: BTreeMap<String, Shown>,
}

/// The host.
#[derive(Debug, Default)]
pub struct Host {
    pub online: bool,
    bd_seq: Option<u64>,
    seq: u64,
    aliases: BTreeMap<u64, (Option<String>, String)>,
    pub node: BTreeMap<String, Shown>,
    pub devices: BTreeMap<String, Device>,
    /// Device, metric, time, value.
    pub past: Vec<(String, String, u64, Option<Wire>)>,
    /// Something is missing: it asks for births, and shows nothing before they come.
    pub wants_births: bool,
    pub births: usize,
    /// Nothing is lost on the way to it: what does not fit is an error of the node.
    pub strict: bool,
}

impl Host {
    /// One to which everything comes.
    pub fn strict() -> Self {
        Self { strict: true, ..Self::default() }
    }

    pub fn hear(&mut self, topic: &str, payload: &[u8]) {
        let parts: Vec<&str> = topic.split('/').collect();
        let (kind, device) = (parts[2], parts.get(4).map(|it| (*it).to_owned()));
        assert_eq!((parts[0], parts[1], parts[3]), ("spBv1.0", "site", "hub"), "{topic}");
        let all = fields(payload);
        let metrics: Vec<_> =
            all.iter().filter(|(it, _)| *it == 2).map(|(_, it)| fields(it.bytes())).collect();
        assert!(one(&all, 1).is_some(), "a time: {topic}");
        if kind == "NDEATH" {
            assert!(one(&all, 3).is_none(), "a death of the node has no place in the sequence");
            return self.death(&metrics);
        }
        let seq = one(&all, 3).expect("a place in the sequence").number();
        assert!(seq < 256);
        if kind == "NBIRTH" {
            assert_eq!(seq, 0);
            return self.birth(&metrics);
        }
        if !self.online || self.wants_births || seq != self.seq {
            self.wants_births = true;
            return;
        }
        self.seq = (self.seq + 1) % 256;
        let fits = match (kind, device) {
            ("DBIRTH", Some(id)) => {
                self.device_birth(id, &metrics);
                true
            }
            ("DDEATH", Some(id)) => {
                let device = self.devices.get_mut(&id).filter(|it| it.online);
                device.map(|it| it.online = false).is_some()
            }
            ("DDATA", Some(id)) => {
                self.devices.get(&id).is_some_and(|it| it.online)
                    && metrics.iter().all(|it| self.data(Some(&id), it))
            }
            ("NDATA", None) => metrics.iter().all(|it| self.data(None, it)),
            _ => panic!("{topic}"),
        };
        assert!(fits || !self.strict, "{topic}");
        self.wants_births |= !fits;
    }

    /// Its own connection has ended: nothing that it shows is the present state.
    pub fn lost(&mut self) {
        self.online = false;
        self.devices.values_mut().for_each(|it| it.online = false);
    }

    fn death(&mut self, metrics: &[Vec<(u64, Wire)>]) {
        let [metric] = metrics else { panic!("{metrics:?}") };
        assert_eq!(one(metric, 1).map(Wire::text).as_deref(), Some("bdSeq"));
        let number = one(metric, 11).map(Wire::number);
        // That of an earlier connection comes late.
        if number.is_some() && number == self.bd_seq {
            self.lost();
        }
    }

    fn birth(&mut self, metrics: &[Vec<(u64, Wire)>]) {
        (self.online, self.wants_births, self.seq) = (true, false, 1);
        self.births += 1;
        self.devices.values_mut().for_each(|it| it.online = false);
        self.aliases.clear();
        self.node = self.announced(None, metrics);
        let rebirth = self.node.get("Node Control/Rebirth").expect("the write of births");
        assert_eq!((rebirth.datatype, &rebirth.value), (11, &Some(Wire::Number(0))));
        let number = self.node.get("bdSeq").expect("the number of the connection");
        assert_eq!(number.datatype, 4);
        self.bd_seq = number.value.as_ref().map(Wire::number);
    }

    fn device_birth(&mut self, id: String, metrics: &[Vec<(u64, Wire)>]) {
        self.aliases.retain(|_, (device, _)| device.as_ref() != Some(&id));
        let metrics = self.announced(Some(&id), metrics);
        self.devices.insert(id, Device { online: true, metrics });
    }

    fn announced(
        &mut self,
        device: Option<&String>,
        metrics: &[Vec<(u64, Wire)>],
    ) -> BTreeMap<String, Shown> {
        let mut all = BTreeMap::new();
        for metric in metrics {
            let name = one(metric, 1).expect("a name").text();
            assert!(one(metric, 5).is_none(), "a birth is of now");
            if let Some(alias) = one(metric, 2) {
                let owner = (device.cloned(), name.clone());
                let other = self.aliases.insert(alias.number(), owner);
                assert!(other.is_none(), "{name} and {other:?} have the same alias");
            } else {
                assert_eq!(name, "Node Control/Rebirth", "an alias");
            }
            let datatype = one(metric, 4).expect("a data type").number();
            let shown = shown(metric, datatype, None);
            assert!(shown.quality.is_some(), "{name}");
            assert!(all.insert(name, shown).is_none(), "names are each of one metric");
        }
        all
    }

    /// Whether it is one of a metric that was announced.
    fn data(&mut self, device: Option<&String>, metric: &[(u64, Wire)]) -> bool {
        assert!(one(metric, 1).is_none() && one(metric, 4).is_none(), "the alias says both");
        let alias = one(metric, 2).expect("an alias").number();
        let Some((owner, name)) = self.aliases.get(&alias) else { return false };
        let metrics = match device {
            Some(id) => self.devices.get_mut(id).map(|it| &mut it.metrics),
            None => Some(&mut self.node),
        };
        let own = metrics.and_then(|it| it.get_mut(name)).filter(|_| owner.as_ref() == device);
        let Some(own) = own else { return false };
        let new = shown(metric, own.datatype, own.quality);
        if one(metric, 5) == Some(&Wire::Number(1)) {
            let device = device.cloned().unwrap_or_default();
            self.past.push((device, name.clone(), new.at_ms, new.value));
        } else {
            *own = new;
        }
        true
    }
}

fn shown(metric: &[(u64, Wire)], datatype: u64, quality: Option<u64>) -> Shown {
    let at_ms = one(metric, 3).expect("a time").number();
    let values: BTreeSet<u64> =
        metric.iter().map(|(it, _)| *it).filter(|it| (10..=19).contains(it)).collect();
    let is_null = one(metric, 7) == Some(&Wire::Number(1));
    assert_eq!(values.len(), usize::from(!is_null), "one value, or none: {metric:?}");
    let value = values.first().and_then(|it| one(metric, *it)).cloned();
    let field = match datatype {
        3 => 10,
        4 => 11,
        10 => 13,
        11 => 14,
        12 => 15,
        other => panic!("data type {other}"),
    };
    assert!(values.iter().all(|it| *it == field), "{datatype}: {metric:?}");
    let said = one(metric, 9).map(|it| {
        let set = fields(it.bytes());
        let of = |number: u64| set.iter().filter(move |(it, _)| *it == number);
        assert_eq!(of(1).count(), of(2).count(), "a value for each key");
        let at = of(1).position(|(_, key)| key.text() == "Quality").expect("a quality");
        let value = fields(of(2).nth(at).expect("a value").1.bytes());
        assert_eq!(one(&value, 1), Some(&Wire::Number(3)));
        one(&value, 3).expect("a number").number()
    });
    let quality = said.or(quality);
    assert!(quality.is_none_or(|it| [0, 192, 500].contains(&it)), "{quality:?}");
    Shown { datatype, value, at_ms, quality }
}
