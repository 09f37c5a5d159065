//! The methods: their arguments, what they ask for, and what they return. No I/O.

use std::time::Duration;

use opcua::types::{
    Argument, DataTypeId, LocalizedText, StatusCode, Variant, VariantScalarTypeId, VariantTypeId,
};

use super::{Language, words};
use crate::plugs::mqtt::message::{Asked, is_valve, targets_of};
use crate::plugs::orders::{Command, What};
use crate::plugs::refusal::{Failed, Refusal};

/// A method returns within this time.
pub const ANSWER: Duration = Duration::from_secs(5);

/// A method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// A command to a monitor.
    Of(Command),
    /// The key of the next opening.
    Key,
    /// A sign of life, with a ticket; gives the next one.
    Alive,
    /// Stop, Close or Lockout of all monitors.
    All(Command),
}

/// The methods of a monitor.
pub const OF_MONITOR: [Method; 11] = [
    Method::Of(Command::Take),
    Method::Of(Command::Release),
    Method::Of(Command::Ask),
    Method::Of(Command::GoTo),
    Method::Key,
    Method::Of(Command::Open),
    Method::Of(Command::Close),
    Method::Of(Command::Stop),
    Method::Of(Command::Lockout),
    Method::Of(Command::Deploy),
    Method::Of(Command::Stow),
];

/// The methods of the site.
pub const OF_SITE: [Method; 4] = [
    Method::Alive,
    Method::All(Command::Stop),
    Method::All(Command::Close),
    Method::All(Command::Lockout),
];

type Arguments = &'static [(&'static str, DataTypeId)];

const TICKET: (&str, DataTypeId) = ("Ticket", DataTypeId::UInt64);
const RESULT: Arguments = &[
    ("Done", DataTypeId::Boolean),
    ("Refusal", DataTypeId::UInt16),
    ("Status", DataTypeId::UInt16),
    ("By", DataTypeId::String),
    ("Text", DataTypeId::LocalizedText),
];

impl Method {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Of(Command::Take) => "Take",
            Self::Of(Command::Release) => "Release",
            Self::Of(Command::Ask) => "Ask",
            Self::Of(Command::GoTo) => "Move",
            Self::Of(Command::Open) => "Open",
            Self::Of(Command::Close) => "Close",
            Self::Of(Command::Stop) => "Stop",
            Self::Of(Command::Lockout) => "Lockout",
            Self::Of(Command::Deploy) => "Deploy",
            Self::Of(Command::Stow) => "Stow",
            Self::Key => "GetKey",
            Self::Alive => "Alive",
            Self::All(Command::Close) => "CloseAll",
            Self::All(Command::Lockout) => "LockoutAll",
            Self::All(_) => "StopAll",
        }
    }

    /// What it takes.
    pub const fn inputs(self) -> Arguments {
        match self {
            Self::Of(Command::GoTo) => &[
                TICKET,
                ("Traverse", DataTypeId::Double),
                ("Elevation", DataTypeId::Double),
                ("Nozzle", DataTypeId::Double),
            ],
            Self::Of(Command::Open) => {
                &[TICKET, ("Key", DataTypeId::UInt64), ("Valve", DataTypeId::UInt16)]
            }
            Self::Of(Command::Close) => &[("Valve", DataTypeId::UInt16)],
            Self::Of(Command::Stop | Command::Lockout) | Self::All(_) | Self::Key => &[],
            Self::Of(_) | Self::Alive => &[TICKET],
        }
    }

    /// What it returns.
    pub const fn outputs(self) -> Arguments {
        match self {
            Self::Of(_) | Self::All(_) => RESULT,
            Self::Key => &[("Key", DataTypeId::UInt64)],
            Self::Alive => &[TICKET, ("Live", DataTypeId::Boolean)],
        }
    }

    /// What a call asks for.
    pub fn asked(self, id: String, inputs: &[Variant]) -> Asked {
        let command = match self {
            Self::Of(command) | Self::All(command) => Some(command),
            Self::Key | Self::Alive => None,
        };
        let (what, key) = match command {
            Some(Command::GoTo) => (goes(inputs).map(What::GoTo), None),
            Some(Command::Open) => {
                let valve = count(inputs.get(2)).filter(|it| is_valve(*it));
                (valve.map(What::Open), number(inputs.get(1)))
            }
            Some(Command::Close) => {
                let valve = if inputs.is_empty() { Some(0) } else { count(inputs.first()) };
                (valve.filter(|it| *it == 0 || is_valve(*it)).map(What::Close), None)
            }
            Some(Command::Stop) => (Some(What::Stop), None),
            Some(Command::Lockout) => (Some(What::Lockout), None),
            Some(Command::Deploy) => (Some(What::Deploy), None),
            Some(Command::Stow) => (Some(What::Stow), None),
            Some(it @ (Command::Take | Command::Release | Command::Ask)) => {
                (Some(What::Authority(it)), None)
            }
            None => (None, None),
        };
        let (ticket, what) = (number(inputs.first()), what.ok_or(Refusal::Argument));
        Asked { id: Some(id), command, what, ticket, key, timeout: ANSWER }
    }
}

/// Targets of the drives; what is no number does not move.
fn goes(inputs: &[Variant]) -> Option<[Option<i16>; 3]> {
    let mut targets = [None; 3];
    for (target, input) in targets.iter_mut().zip(inputs.get(1..)?) {
        let value = double(input)?;
        *target = Some(value).filter(|it| !it.is_nan());
    }
    let moves = inputs.len() == 4 && targets.iter().any(Option::is_some);
    targets_of(targets).filter(|_| moves)
}

fn converted(input: Option<&Variant>, to: VariantScalarTypeId) -> Option<Variant> {
    Some(input?.convert(VariantTypeId::Scalar(to)))
}

fn double(input: &Variant) -> Option<f64> {
    match converted(Some(input), VariantScalarTypeId::Double) {
        Some(Variant::Double(value)) => Some(value),
        _ => None,
    }
}

fn count(input: Option<&Variant>) -> Option<u16> {
    u16::try_from(number(input)?).ok()
}

/// A whole number, of any type that has it.
pub fn number(input: Option<&Variant>) -> Option<u64> {
    match *input? {
        Variant::Byte(value) => Some(value.into()),
        Variant::UInt16(value) => Some(value.into()),
        Variant::UInt32(value) => Some(value.into()),
        Variant::UInt64(value) => Some(value),
        Variant::Int16(value) => value.try_into().ok(),
        Variant::Int32(value) => value.try_into().ok(),
        Variant::Int64(value) => value.try_into().ok(),
        _ => None,
    }
}

/// Arguments as they are declared.
pub fn declared(arguments: Arguments) -> Vec<Argument> {
    let one = |(name, kind): &(&'static str, DataTypeId)| Argument {
        name: (*name).into(),
        data_type: (*kind).into(),
        value_rank: -1,
        array_dimensions: None,
        description: LocalizedText::null(),
    };
    arguments.iter().map(one).collect()
}

/// What a call returns: its status, and its results. `by`: who has refused, as far as that is a client.
pub fn returned(
    result: Result<(), Failed>,
    by: &str,
    monitor: &str,
    language: Language,
) -> (StatusCode, Vec<Variant>) {
    let failed = result.err();
    let by = match failed.map(|it| it.why) {
        None => "",
        Some(Refusal::Held | Refusal::Asked) if !by.is_empty() => by,
        Some(Refusal::Refused) => monitor,
        Some(_) => "hub",
    };
    let status = failed.map_or(StatusCode::Good, |it| words::status(it.why));
    let words = failed.map(|it| words::of(it.why)).unwrap_or_default();
    let text = LocalizedText::new(language.code(), language.of(&words));
    let outputs = vec![
        failed.is_none().into(),
        failed.map_or(0, |it| it.why.number()).into(),
        failed.map_or(0, |it| it.status).into(),
        by.into(),
        text.into(),
    ];
    (status, outputs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(method: Method, inputs: &[Variant]) -> Asked {
        method.asked("1".into(), inputs)
    }

    #[test]
    fn arguments_are_read_and_what_is_wrong_is_refused() {
        let motion = Method::Of(Command::GoTo);
        let inputs = [7_u64.into(), (-10.01).into(), f64::NAN.into(), 60.0.into()];
        let it = asked(motion, &inputs);
        assert_eq!(it.what, Ok(What::GoTo([Some(-601), None, Some(60)])));
        assert_eq!((it.ticket, it.command), (Some(7), Some(Command::GoTo)));
        let nan = || Variant::from(f64::NAN);
        for wrong in [
            vec![7_u64.into(), nan(), nan(), nan()],
            vec![7_u64.into(), 1.0.into(), 1.0.into()],
            vec![7_u64.into(), 361.0.into(), nan(), nan()],
            vec![7_u64.into(), f64::INFINITY.into(), nan(), nan()],
            vec![7_u64.into(), "x".into(), nan(), nan()],
            vec![],
        ] {
            assert_eq!(asked(motion, &wrong).what, Err(Refusal::Argument), "{wrong:?}");
        }
        let open = Method::Of(Command::Open);
        let it = asked(open, &[7_u64.into(), 8_u64.into(), 2_u16.into()]);
        assert_eq!((it.what, it.key, it.ticket), (Ok(What::Open(2)), Some(8), Some(7)));
        for valve in [Variant::from(0_u16), 3_u16.into(), (-1_i32).into(), true.into()] {
            let it = asked(open, &[7_u64.into(), 8_u64.into(), valve]);
            assert_eq!(it.what, Err(Refusal::Argument));
        }
        assert_eq!(asked(Method::Of(Command::Close), &[]).what, Ok(What::Close(0)));
        let two = [Variant::from(2_i32)];
        assert_eq!(asked(Method::Of(Command::Close), &two).what, Ok(What::Close(2)));
    }

    #[test]
    fn every_command_is_a_method_and_has_its_arguments() {
        let of: Vec<Command> = OF_MONITOR
            .iter()
            .filter_map(|it| if let Method::Of(command) = it { Some(*command) } else { None })
            .collect();
        assert!(Command::ALL.iter().all(|it| of.contains(it)));
        for method in OF_MONITOR.into_iter().chain(OF_SITE) {
            let command = match method {
                Method::Of(command) | Method::All(command) => Some(command),
                _ => None,
            };
            let urgent = command.is_some_and(Command::is_urgent);
            let ticket = method.inputs().first() == Some(&TICKET);
            assert!(!(urgent && ticket), "{method:?} is always taken");
            assert!(urgent || ticket || method == Method::Key, "{method:?}");
        }
    }

    #[test]
    fn who_has_refused_is_named() {
        let by = |failed: Failed| {
            let (status, outputs) = returned(Err(failed), "anna", "M1", Language::Ru);
            assert!(status.is_bad());
            assert_eq!(outputs.len(), RESULT.len());
            assert_eq!(outputs[0], false.into());
            outputs[3].clone()
        };
        assert_eq!(by(Failed { why: Refusal::Refused, status: 7 }), "M1".into());
        assert_eq!(by(Refusal::Held.into()), "anna".into());
        assert_eq!(by(Refusal::Key.into()), "hub".into());
        let (status, outputs) = returned(Ok(()), "anna", "M1", Language::En);
        assert_eq!(
            (status, &outputs[0], &outputs[3]),
            (StatusCode::Good, &true.into(), &"".into())
        );
    }
}
