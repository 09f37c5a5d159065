//! Writes the catalogues as Rust: a structure a text, its fields the arguments.

use std::fmt::Write;

use crate::catalogue::{Catalogue, FIRST, Message, Piece, type_name};

/// The generated part of the crate.
pub fn module(catalogue: &Catalogue) -> String {
    let mut out = languages(&catalogue.languages);
    for (area, messages) in &catalogue.areas {
        out += &format!("\n/// Texts of `{area}.ftl`.\npub mod {} {{\n", area.replace('-', "_"));
        out += "    use std::fmt;\n\n    use crate::{Argument, Fixed, Lang, Text};\n";
        out += &by_key(messages);
        for message in messages {
            out += &structure(message, &catalogue.languages);
        }
        out += "}\n";
    }
    out
}

/// `en` as a variant.
fn variant(language: &str) -> String {
    type_name(language)
}

fn languages(all: &[String]) -> String {
    let mut variants = String::new();
    let mut fields = String::new();
    let mut codes = String::new();
    let mut of = String::new();
    let mut each = String::new();
    let mut fixed = String::new();
    let mut fixed_of = String::new();
    let mut fixed_same = String::new();
    for language in all {
        let (name, first) = (variant(language), language == FIRST);
        let default = if first { "#[default] " } else { "" };
        variants += &format!("    /// `{language}`.\n    {default}{name},\n");
        fields += &format!("    /// In `{language}`.\n    pub {language}: String,\n");
        codes += &format!("            Self::{name} => {language:?},\n");
        of += &format!("            Lang::{name} => &self.{language},\n");
        each += &format!("            {language}: form(Lang::{name}),\n");
        fixed += &format!("    /// In `{language}`.\n    pub {language}: &'static str,\n");
        fixed_of += &format!("            Lang::{name} => self.{language},\n");
        fixed_same += &format!("            {language}: text,\n");
    }
    let names: Vec<String> = all.iter().map(|it| format!("Self::{}", variant(it))).collect();
    let (count, names) = (all.len(), names.join(", "));
    format!(
        "/// A language.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Lang {{
{variants}}}

impl Lang {{
    /// All languages that there are texts in.
    pub const ALL: [Self; {count}] = [{names}];

    /// Its code, as in the name of its folder.
    pub const fn code(self) -> &'static str {{
        match self {{
{codes}        }}
    }}
}}

/// The words of a text in every language.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = \"serde\", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = \"serde\", serde(deny_unknown_fields))]
#[cfg_attr(feature = \"schema\", derive(utoipa::ToSchema), schema(as = Both))]
pub struct Words {{
{fields}}}

impl Words {{
    /// The words in a language.
    pub fn of(&self, lang: Lang) -> &str {{
        match lang {{
{of}        }}
    }}

    /// The same in every language, as names and requests are.
    pub fn same(text: impl Into<String>) -> Self {{
        let text = text.into();
        Self::each(|_| text.clone())
    }}

    /// From the form in each language.
    pub fn each(form: impl Fn(Lang) -> String) -> Self {{
        Self {{
{each}        }}
    }}
}}

/// A text without arguments in every language, for tables and constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fixed {{
{fixed}}}

impl Fixed {{
    /// In a language.
    pub const fn str(self, lang: Lang) -> &'static str {{
        match lang {{
{fixed_of}        }}
    }}

    /// The same in every language.
    pub const fn same(text: &'static str) -> Self {{
        Self {{
{fixed_same}        }}
    }}
}}
"
    )
}

fn structure(message: &Message, languages: &[String]) -> String {
    let name = type_name(&message.key);
    let mut out = String::from("\n");
    for (language, form) in languages.iter().zip(&message.forms) {
        _ = writeln!(out, "    /// `{language}`:\n    /// ```text");
        for line in shown(form).lines() {
            _ = writeln!(out, "    /// {line}");
        }
        _ = writeln!(out, "    /// ```");
    }
    let types: Vec<String> = (0..message.arguments.len()).map(|it| format!("A{it}")).collect();
    let (generics, bounded) = if types.is_empty() {
        (String::new(), String::new())
    } else {
        (format!("<{}>", types.join(", ")), format!("<{}: Argument>", types.join(": Argument, ")))
    };
    out += "    #[derive(Clone, Copy, Debug)]\n";
    if types.is_empty() {
        _ = writeln!(out, "    pub struct {name};");
    } else {
        _ = writeln!(out, "    pub struct {name}{generics} {{");
        for (argument, of) in message.arguments.iter().zip(&types) {
            _ = writeln!(out, "        /// `{{ ${argument} }}`.\n        pub {argument}: {of},");
        }
        out += "    }\n";
    }
    if types.is_empty() {
        out += &fixed(message, languages);
    }
    _ = writeln!(out, "\n    impl{bounded} Argument for {name}{generics} {{");
    out += "        fn write(&self, lang: Lang, out: &mut dyn fmt::Write) -> fmt::Result {\n";
    if types.is_empty() {
        out += "            out.write_str(self.str(lang))\n";
    } else {
        out += "            use crate::Piece;\n            let pieces: &[Piece] = match lang {\n";
        for (language, form) in languages.iter().zip(&message.forms) {
            let pieces: Vec<String> = form.iter().map(|piece| literal(piece, message)).collect();
            let (name, pieces) = (variant(language), pieces.join(", "));
            _ = writeln!(out, "                Lang::{name} => &[{pieces}],");
        }
        let arguments = message.arguments.iter().map(|it| format!("&self.{it}"));
        let arguments = arguments.collect::<Vec<_>>().join(", ");
        _ = writeln!(
            out,
            "            }};\n            crate::put(pieces, &[{arguments}], lang, out)"
        );
    }
    _ = writeln!(out, "        }}\n    }}\n\n    impl{bounded} Text for {name}{generics} {{}}");
    out
}

/// The texts of a file that have no arguments, for programs that find them by names of their own.
fn by_key(messages: &[Message]) -> String {
    let mut out = String::from("\n    /// The texts without arguments, by key.\n");
    out += "    pub const BY_KEY: &[(&str, Fixed)] = &[\n";
    for Message { key, .. } in messages.iter().filter(|it| it.arguments.is_empty()) {
        _ = writeln!(out, "        ({key:?}, {}.fixed()),", type_name(key));
    }
    out + "    ];\n"
}

/// What a text without arguments has more: it need not be put together.
fn fixed(message: &Message, languages: &[String]) -> String {
    let mut out = format!("\n    impl {} {{\n", type_name(&message.key));
    out += "        /// In a language.\n";
    out +=
        "        pub const fn str(self, lang: Lang) -> &'static str {\n            match lang {\n";
    for (language, form) in languages.iter().zip(&message.forms) {
        _ = writeln!(out, "                Lang::{} => {:?},", variant(language), shown(form));
    }
    out += "            }\n        }\n\n";
    out += "        /// In every language.\n        pub const fn fixed(self) -> Fixed {\n";
    out += "            Fixed {\n";
    for (language, form) in languages.iter().zip(&message.forms) {
        _ = writeln!(out, "                {language}: {:?},", shown(form));
    }
    out + "            }\n        }\n    }\n"
}

/// A text as in the catalogue.
fn shown(form: &[Piece]) -> String {
    let one = |piece: &Piece| match piece {
        Piece::Text(text) => text.clone(),
        Piece::Argument(name) => format!("{{ ${name} }}"),
    };
    form.iter().map(one).collect()
}

fn literal(piece: &Piece, message: &Message) -> String {
    match piece {
        Piece::Text(text) => format!("Piece::Text({text:?})"),
        Piece::Argument(name) => {
            let index = message.arguments.iter().position(|known| known == name);
            format!("Piece::Argument({})", index.unwrap_or_default())
        }
    }
}
