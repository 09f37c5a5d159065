//! Conditions on a site: those of [`crate::condition`] with the name of a monitor in front, and a
//! few on what belongs to no monitor.
//!
//! ```text
//! M1 Detector Found              short for `M1 Detector flags has Found`
//! not M1 Valve1 Open
//! M1 Vertical position >= 600    everything that `condition` reads; the name may be left out
//!                                where there is one monitor alone
//! fire T-1 out                   burning, out (it has burnt), unlit; also heat (0 … 1), size (m),
//!                                density (l/(s·m²)), covered (by foam, 0 … 1), heated (on its
//!                                way to catching fire, 0 … 1)
//! fires burning = 0              how many burn
//! water <= 5000                  litres out of all nozzles; `water M1 <= 2000`: out of one
//! time >= 60                     seconds
//! A and B                        both
//! ```

use lafet_proto::SubsystemId;
use lafet_proto::flags::flags_of;
use lafet_texts::{Text as _, Words, sim as text};

use crate::condition::{Condition, unknown_flag};
use crate::site::Site;

/// A condition on a site.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteCondition {
    text: String,
    parts: Vec<(Scope, Condition)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    Monitor(usize),
    Fire(usize),
    Fires,
    Water(Option<usize>),
    Time,
}

/// The names that a condition may use.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    /// Of monitors.
    pub monitors: &'a [String],
    /// Of fires.
    pub fires: &'a [String],
}

impl core::fmt::Display for SiteCondition {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.text)
    }
}

impl SiteCondition {
    /// Reads a condition.
    pub fn parse(text: &str, names: Names<'_>) -> Result<Self, Words> {
        let parts = text.split(" and ").map(|part| part_of(part, names));
        Ok(Self { text: text.trim().to_owned(), parts: parts.collect::<Result<_, Words>>()? })
    }

    /// Whether it holds, and what the values are.
    ///
    /// # Errors
    ///
    /// It makes no sense on this site.
    pub fn holds(&self, site: &mut Site) -> Result<(bool, Words), Words> {
        let (mut all, mut values) = (true, Vec::new());
        for (scope, condition) in &self.parts {
            let (holds, value) = scope.judge(condition, site)?;
            all &= holds;
            values.push(value);
        }
        let joined = |lang| values.iter().map(|it: &Words| it.of(lang)).collect::<Vec<_>>();
        Ok((all, Words::each(|lang| joined(lang).join(", "))))
    }
}

impl Scope {
    fn judge(self, condition: &Condition, site: &mut Site) -> Result<(bool, Words), Words> {
        if let Self::Monitor(index) = self
            && !site.members[index].sim.is_powered()
        {
            return Ok((false, text::NoPower.words()));
        }
        let (holds, value) = self.judge_powered(condition, site)?;
        Ok((holds, Words::same(value)))
    }

    fn judge_powered(
        self,
        condition: &Condition,
        site: &mut Site,
    ) -> Result<(bool, String), Words> {
        let last = condition.path().last().map_or("", String::as_str);
        let words = condition.path().len();
        let too_many = || text::ConditionWords { path: condition.path().join(" ") }.words();
        let expected = match self {
            Self::Monitor(_) | Self::Fire(_) => words,
            Self::Fires | Self::Water(Some(_)) => 2,
            Self::Water(None) | Self::Time => 1,
        };
        if words != expected {
            return Err(too_many());
        }
        match self {
            Self::Monitor(index) => condition.holds(&mut site.members[index].sim),
            Self::Fire(index) => {
                let fire = &site.fires[index];
                match last {
                    _ if words == 2 => {
                        let word = match () {
                            () if fire.burns() => "burning",
                            () if site.fires.has_caught(index) => "out",
                            () => "unlit",
                        };
                        condition.judge_word(word, &["burning", "out", "unlit"])
                    }
                    _ if words > 3 => Err(too_many()),
                    "heat" => condition.judge_number(fire.heat),
                    "size" => condition.judge_number(fire.size_m),
                    "density" => condition.judge_number(fire.density),
                    "covered" => condition.judge_number(fire.covered()),
                    "heated" => condition.judge_number(fire.heated()),
                    _ => Err(text::FireHas { what: last }.words()),
                }
            }
            Self::Fires => {
                let burning = site.fires.iter().filter(|fire| fire.burns()).count();
                condition.judge_number(burning as f64)
            }
            Self::Water(monitor) => {
                let members = site.members.iter().enumerate();
                let chosen = members.filter(|(index, _)| monitor.is_none_or(|m| m == *index));
                let litres: f64 = chosen.map(|(_, member)| member.litres).sum();
                condition.judge_number(libm::round(litres))
            }
            Self::Time => condition.judge_number(site.now_ms() as f64 / 1000.0),
        }
    }
}

fn part_of(text: &str, names: Names<'_>) -> Result<(Scope, Condition), Words> {
    let mut words: Vec<&str> = text.split_whitespace().collect();
    let negated = words.first() == Some(&"not");
    if negated {
        words.remove(0);
    }
    let monitor = |name: &str| names.monitors.iter().position(|known| known == name);
    let unknown = |name: &str| {
        let known = names.monitors.join(", ");
        text::MonitorUnknown { condition: text, name, known }.words()
    };
    let (scope, rest) = match words.as_slice() {
        ["fire", name, ..] => {
            let index = names.fires.iter().position(|known| known == name);
            let index = index.ok_or_else(|| {
                let known = names.fires.join(", ");
                text::FireUnknown { condition: text, name, known }.words()
            })?;
            (Scope::Fire(index), words.clone())
        }
        ["fires", "burning", ..] => (Scope::Fires, words.clone()),
        ["water", name, _, _] => {
            let index = monitor(name).ok_or_else(|| unknown(name))?;
            (Scope::Water(Some(index)), words.clone())
        }
        ["water", _, _] => (Scope::Water(None), words.clone()),
        ["time", _, _] => (Scope::Time, words.clone()),
        [name, rest @ ..] if monitor(name).is_some() => {
            (Scope::Monitor(monitor(name).unwrap_or(0)), flags_in_full(rest)?)
        }
        _ if names.monitors.len() == 1 => (Scope::Monitor(0), flags_in_full(&words)?),
        [name, ..] => return Err(unknown(name)),
        [] => return Err(text::ConditionMissing.words()),
    };
    let rest = format!("{}{}", if negated { "not " } else { "" }, rest.join(" "));
    Condition::parse(&rest)
        .map(|condition| (scope, condition))
        .map_err(|error| not_understood(&error))
}

/// What to say of a condition that makes no sense.
pub fn not_understood(error: &Words) -> Words {
    text::ConditionNotUnderstood { error }.words()
}

/// Numbers that a state has beside its flags, and the count of the detector's: no flag is meant.
const FIELDS: [&str; 14] = [
    "flags",
    "position",
    "current",
    "speed",
    "voltage",
    "pressure",
    "flow",
    "horizontal",
    "vertical",
    "nozzle",
    "deployer",
    "housing",
    "humidity",
    "hotbeds",
];

/// `Detector Found` is short for `Detector flags has Found`.
fn flags_in_full<'a>(words: &[&'a str]) -> Result<Vec<&'a str>, Words> {
    let Some((subsystem, flags)) = words.split_first() else { return Ok(Vec::new()) };
    let Some(id) = SubsystemId::from_name(subsystem) else { return Ok(words.to_vec()) };
    if flags.first().is_none_or(|first| FIELDS.contains(first)) {
        return Ok(words.to_vec());
    }
    let class = flags_of(id);
    let known = |flag: &&&str| {
        let name = flag.split('=').next().unwrap_or(flag);
        class.flags.iter().any(|info| info.name == name)
    };
    if let Some(unknown) = flags.iter().find(|flag| !known(flag)) {
        return Err(not_understood(&unknown_flag(unknown, subsystem, class)));
    }
    let mut full = vec![*subsystem, "flags", "has"];
    full.extend(flags);
    Ok(full)
}
