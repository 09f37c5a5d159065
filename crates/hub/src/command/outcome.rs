//! How a monitor has answered a request, as clients get it.

use std::collections::BTreeMap;

use lafet_client::refusal::{Flags, Reason, reason_now};
use lafet_client::{AnswerBuf, Answers, Saved};
use lafet_proto::SubsystemId;
use lafet_proto::dictionary::{self, layouts};
use lafet_proto::text::AnswerText;
use lafet_texts::Text;
use serde::Serialize;
use utoipa::ToSchema;

use crate::error::{ApiError, ErrorBody, Failed};
use crate::text::Both;
use crate::words::SavedWord;

/// How a request was answered.
#[derive(Clone, Debug, Default, Serialize, ToSchema)]
pub struct Outcome {
    /// Every answer is a success.
    pub ok: bool,
    /// The request in the text form.
    pub request: String,
    /// From the request to its answer, ms.
    pub took_ms: u64,
    /// Number of the entry in the audit log; null for a reading and while the disk takes none.
    #[schema(required)]
    pub audit: Option<u64>,
    /// The answers by subsystem.
    pub answers: Vec<Answered>,
    /// Of a parameter that is saved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saved: Option<SavedWord>,
}

/// An answer of a monitor.
#[derive(Clone, Debug, Serialize, ToSchema)]
pub struct Answered {
    /// The subsystem that answers.
    pub from: String,
    /// Name of the result.
    pub status: String,
    /// Number of the result (§2/5).
    pub code: u8,
    /// Whether the result is a success.
    pub success: bool,
    /// The answer in the text form.
    pub text: String,
    /// What the result means.
    #[schema(required)]
    pub meaning: Option<Both>,
    /// What to do about it.
    #[schema(required)]
    pub remedy: Option<Both>,
    /// The data by the dictionary's names; what repeats is a list.
    pub values: BTreeMap<&'static str, FieldValue>,
}

/// The value of a field.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum FieldValue {
    /// Of one that is there once.
    One(i64),
    /// Of a field that repeats.
    Many(Vec<i64>),
}

/// What one of several monitors has answered.
#[derive(Clone, Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub enum OfOne {
    /// The monitor has answered.
    Answered(Outcome),
    /// It has refused, or was not reached.
    Failed(Box<Failed>),
    /// The request is sent and not answered yet.
    Pending(Pending),
}

/// The request is sent, no answer has confirmed it yet, and it goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Pending {
    /// Always true.
    pub pending: bool,
}

/// What several monitors have answered, by id.
pub type OfAll = BTreeMap<String, OfOne>;

impl Outcome {
    /// The answers to a request, and the flags by which a refusal is explained; an error if the one answer
    /// that there is refuses.
    pub fn new(
        request: &str,
        took_ms: u64,
        answers: &Answers,
        flags: Flags<'_>,
    ) -> Result<Self, ApiError> {
        if answers.refusal().is_some() && answers.len() == 1 {
            return Err(ApiError::refused(answers, flags));
        }
        let ok = answers.refusal().is_none();
        let (request, answers) = (request.to_owned(), answered(answers, flags));
        Ok(Self { ok, request, took_ms, audit: None, answers, saved: None })
    }

    /// The same of a value that is saved.
    #[must_use]
    pub fn saved(self, saved: Option<Saved>) -> Self {
        Self { saved: saved.map(SavedWord::from), ..self }
    }

    /// Takes the answers to a further request of the same kind.
    pub fn join(&mut self, more: Self) {
        self.ok &= more.ok;
        self.answers.extend(more.answers);
    }
}

impl OfOne {
    /// What is known of a request; `None`: nothing yet.
    pub fn new(result: Option<Result<Outcome, ApiError>>) -> Self {
        match result {
            Some(Ok(outcome)) => Self::Answered(outcome),
            Some(Err(error)) => Self::Failed(Failed { error: error.body() }.into()),
            None => Self::Pending(Pending { pending: true }),
        }
    }
}

/// A result in its two halves.
pub fn parted<T>(result: Result<T, ApiError>) -> (Option<T>, Option<ErrorBody>) {
    match result {
        Ok(value) => (Some(value), None),
        Err(error) => (None, Some(error.body())),
    }
}

/// All answers to a request.
pub fn answered(answers: &Answers, flags: Flags<'_>) -> Vec<Answered> {
    answers.iter().map(|answer| Answered::new(answers.to(), answer, flags)).collect()
}

/// `Vertical GetStatus → Ok …`
pub fn answer_text(answer: &AnswerBuf) -> String {
    AnswerText(answer.record()).to_string()
}

impl Answered {
    fn new(to: SubsystemId, answer: &AnswerBuf, flags: Flags<'_>) -> Self {
        let status = answer.status();
        let texts = match dictionary::status(status) {
            Some(texts) if status.is_success() => {
                Some((texts.meaning.words(), texts.remedy.words()))
            }
            _ if status.is_success() => None,
            _ => {
                let Reason { why, remedy, .. } =
                    reason_now(answer.request(), to, status, answer.from(), flags);
                Some((why.words(), remedy.words()))
            }
        };
        let (meaning, remedy) = texts.unzip();
        Self {
            from: answer.from().to_string(),
            status: status.to_string(),
            code: status.0,
            success: status.is_success(),
            text: answer_text(answer),
            meaning,
            remedy,
            values: values(answer),
        }
    }
}

fn values(answer: &AnswerBuf) -> BTreeMap<&'static str, FieldValue> {
    let mut all = BTreeMap::new();
    let layouts = layouts::of_answer(answer.request(), answer.from());
    let fitting = layouts.iter().find(|layout| layout.fits(answer.data()));
    let Some(layout) = fitting.filter(|_| !answer.data().is_empty()) else { return all };
    for (_, field, value) in layout.values(answer.data()) {
        let repeated = layout.repeated.iter().any(|it| it.name == field.name);
        // As parameters have them everywhere else in the API.
        let name = if repeated && field.name == "value" { "values" } else { field.name };
        match all.get_mut(name) {
            Some(FieldValue::Many(values)) => values.push(value),
            _ if repeated => _ = all.insert(name, FieldValue::Many(vec![value])),
            _ => _ = all.insert(name, FieldValue::One(value)),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use lafet_proto::flags::GeneralFlags;
    use lafet_proto::{Record, RequestId, Status};

    use super::*;

    /// §3.3.1/4 A weak supply is explained as such in the message and in the answer, by the flags.
    #[test]
    fn a_weak_supply_is_no_lockout() {
        let general = SubsystemId::GENERAL;
        let record =
            Record { request: RequestId::MOVE, device: general, status: Status::DENIED, data: &[] };
        let answers = Answers::new(SubsystemId::VERTICAL, [AnswerBuf::new(&record)]).unwrap();
        let refused = |flags: GeneralFlags| {
            let flags = |id| (id == general).then_some(flags.bits());
            let body = Outcome::new("Move Vertical 600", 1, &answers, &flags).unwrap_err().body();
            let meaning = body.details.answers.as_ref().unwrap()[0].meaning.clone().unwrap();
            assert!(body.en.contains(&meaning.en) && body.ru.contains(&meaning.ru), "{body:?}");
            meaning.en
        };
        let weak = refused(GeneralFlags::BAD_POWER);
        assert!(weak.contains("supply") && !weak.contains("locked"), "{weak}");
        let locked = refused(GeneralFlags::LOCKED_OUT | GeneralFlags::BAD_POWER);
        assert!(locked.contains("locked out") && !locked.contains("supply"), "{locked}");
    }
}
