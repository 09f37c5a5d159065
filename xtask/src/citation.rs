//! Citations of the protocol document: `§3.1/4` is section 3.1, scenario 4. Sections that are not
//! in the document, such as the link frame, are letters: `§L/1`.

/// Most scenarios of a section; a longer range is a typing error.
const MOST_SCENARIOS: u32 = 100;

/// The sections and scenarios that a text cites, once per mention: `§3.1/1-3` and `§3.1/1,2,3` both
/// cite three. An invalid citation is returned unchanged.
pub fn citations(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, sign) in text.match_indices('§') {
        let rest = &text[at + sign.len()..];
        let section = section(rest);
        if section.is_empty() {
            continue;
        }
        let scenarios = rest[section.len()..].strip_prefix('/').map(scenarios).unwrap_or_default();
        if scenarios.is_empty() {
            found.push(format!("§{section}"));
        }
        for part in scenarios {
            expand(section, &part, &mut found);
        }
    }
    found
}

/// Whether `section` is `id` or one of its subsections or scenarios.
pub fn lies_within(section: &str, id: &str) -> bool {
    section.strip_prefix(id).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '/']))
}

/// The number at the start, such as `3.3.10`, without the full stop of a sentence, or one letter.
fn section(text: &str) -> &str {
    let mut chars = text.chars();
    let letter = chars.next().is_some_and(|c| c.is_ascii_uppercase());
    if letter && !chars.next().is_some_and(char::is_alphanumeric) {
        return &text[..1];
    }
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    text[..end].trim_end_matches('.')
}

/// The comma-separated parts of `1-3,5`, without the comma or dash of a sentence.
fn scenarios(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        let digit_next = chars.peek().is_some_and(char::is_ascii_digit);
        let last = parts.last_mut().filter(|part| c.is_ascii_digit() || !part.is_empty());
        match (c, last) {
            ('0'..='9', Some(part)) => part.push(c),
            ('-' | '–', Some(part)) if digit_next => part.push('-'),
            (',', Some(_)) if digit_next => parts.push(String::new()),
            _ => break,
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}

fn expand(section: &str, part: &str, found: &mut Vec<String>) {
    let range = part.split_once('-').and_then(|(first, last)| {
        let (first, last): (u32, u32) = (first.parse().ok()?, last.parse().ok()?);
        (first <= last && last <= MOST_SCENARIOS).then_some(first..=last)
    });
    match range {
        Some(range) => found.extend(range.map(|number| format!("§{section}/{number}"))),
        None => found.push(format!("§{section}/{part}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_section_or_scenario() {
        assert_eq!(citations("see §3.1/4, and §3.3.10."), ["§3.1/4", "§3.3.10"]);
        assert_eq!(citations("(§1) §§3.2/1; §3.2/12"), ["§1", "§3.2/1", "§3.2/12"]);
        assert_eq!(citations("§L/1-2, §P"), ["§L/1", "§L/2", "§P"]);
        assert_eq!(citations("a sign § alone, and /4, §Link"), [""; 0]);
    }

    #[test]
    fn ranges_and_lists_count_for_each() {
        assert_eq!(citations("§3.1/1-3"), ["§3.1/1", "§3.1/2", "§3.1/3"]);
        assert_eq!(citations("§3.1/1–2"), ["§3.1/1", "§3.1/2"]);
        assert_eq!(citations("§3.1/1,3"), ["§3.1/1", "§3.1/3"]);
        assert_eq!(citations("§3.1/1-2,5."), ["§3.1/1", "§3.1/2", "§3.1/5"]);
    }

    #[test]
    fn the_sentence_around_is_left_alone() {
        assert_eq!(citations("§3.1/2, 7 times"), ["§3.1/2"]);
        assert_eq!(citations("§3.1/2- that is"), ["§3.1/2"]);
        assert_eq!(citations("§3.1/or"), ["§3.1"]);
        assert_eq!(citations("§3.1/,2"), ["§3.1"]);
    }

    #[test]
    fn nonsense_stays_visible() {
        assert_eq!(citations("§3.1/3-1"), ["§3.1/3-1"]);
        assert_eq!(citations("§3.1/1-4000"), ["§3.1/1-4000"]);
        assert_eq!(citations("§3.1/1-2-3"), ["§3.1/1-2-3"]);
    }

    #[test]
    fn a_parent_holds_its_sections_only() {
        assert!(lies_within("§3.1/4", "§3.1"));
        assert!(lies_within("§3.3.1", "§3.3"));
        assert!(lies_within("§3.1", "§3.1"));
        assert!(!lies_within("§3.10", "§3.1"));
        assert!(!lies_within("§3.1", "§3.1/4"));
    }
}
