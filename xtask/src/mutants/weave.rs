//! Weaves all mutants of a file into it, each behind a switch: built once, tried one by one.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use quote::ToTokens;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

use super::list::{Genre, Mutant};

/// A file with its mutants woven in.
pub struct Woven {
    pub text: String,
    /// Places of the mutants in the text: narrow ones, and the whole expressions around them.
    pub places: Vec<Place>,
    /// Mutants that cannot be switched, in code evaluated by the compiler.
    pub left_out: Vec<usize>,
}

/// A part of the woven text that depends on these mutants.
pub struct Place {
    pub range: Range<usize>,
    pub ids: Vec<usize>,
}

/// `mutants` are those of this file, by number. Functions named in `constant` stay const.
pub fn weave(
    source: &str,
    mutants: &BTreeMap<usize, Mutant>,
    constant: &BTreeSet<String>,
) -> Result<Woven, String> {
    let syntax = syn::parse_file(source).map_err(|e| e.to_string())?;
    let lines = line_starts(source);
    let spans = mutants.iter().map(|(id, mutant)| {
        let at = |(line, column): (usize, usize)| offset(source, &lines, line, column);
        (*id, at(mutant.start)..at(mutant.end))
    });
    let mut finder = Finder {
        mutants,
        spans: spans.collect(),
        constant,
        in_constant: 0,
        edits: Vec::new(),
        found: BTreeSet::new(),
    };
    finder.visit_file(&syntax);
    let Finder { mut edits, found, .. } = finder;
    edits.sort_by_key(|edit| (edit.range.start, std::cmp::Reverse(edit.range.end), edit.order()));
    let mut printer = Printer { source, mutants, edits, text: String::new(), places: Vec::new() };
    printer.print(0..source.len(), 0);
    let left_out = mutants.keys().copied().filter(|id| !found.contains(id)).collect();
    Ok(Woven { text: printer.text, places: printer.places, left_out })
}

fn line_starts(source: &str) -> Vec<usize> {
    let ends = source.match_indices('\n').map(|(at, _)| at + 1);
    std::iter::once(0).chain(ends).collect()
}

/// Byte offset of a position. Lines and columns count from 1, columns in characters.
fn offset(source: &str, lines: &[usize], line: usize, column: usize) -> usize {
    let start = lines.get(line.saturating_sub(1)).copied().unwrap_or(source.len());
    let rest = &source[start..];
    start + rest.char_indices().nth(column.saturating_sub(1)).map_or(rest.len(), |(at, _)| at)
}

/// A change to the source that adds mutants.
struct Edit {
    range: Range<usize>,
    kind: Kind,
}

enum Kind {
    /// An expression and its variants: what each replaces.
    Choice(Vec<(usize, Range<usize>)>),
    /// At the start of a body: values to return.
    Body(Vec<usize>),
    /// The condition of an arm: numbers of the mutants true, false, and deletion of the arm.
    Guard(Vec<usize>),
    /// After the pattern of an arm without a condition.
    Arm(usize),
    /// The scrutinee of a match, with the arms that may be deleted: all may be needed for
    /// exhaustiveness.
    Matched(Vec<usize>),
    /// `const`, which a function with switches cannot be.
    Const,
}

impl Edit {
    /// Order of two edits at the same place: the outer one first.
    fn order(&self) -> usize {
        match &self.kind {
            Kind::Choice(variants) => variants.len(),
            _ => 0,
        }
    }
}

struct Finder<'a> {
    mutants: &'a BTreeMap<usize, Mutant>,
    spans: BTreeMap<usize, Range<usize>>,
    constant: &'a BTreeSet<String>,
    in_constant: usize,
    edits: Vec<Edit>,
    found: BTreeSet<usize>,
}

impl Finder<'_> {
    fn at(&self, genre: Genre, matches: impl Fn(&Range<usize>) -> bool) -> Vec<usize> {
        if self.in_constant > 0 {
            return Vec::new();
        }
        let mut ids = Vec::new();
        for (id, span) in &self.spans {
            if self.mutants.get(id).is_some_and(|m| m.genre == genre) && matches(span) {
                ids.push(*id);
            }
        }
        ids
    }

    fn edit(&mut self, range: Range<usize>, ids: &[usize], kind: Kind) {
        if !ids.is_empty() {
            self.found.extend(ids);
            self.edits.push(Edit { range, kind });
        }
    }

    fn choice(&mut self, range: Range<usize>, ids: &[usize]) {
        let variants = ids.iter().filter_map(|id| Some((*id, self.spans.get(id)?.clone())));
        let variants = variants.collect();
        self.edit(range, ids, Kind::Choice(variants));
    }

    fn function(&mut self, signature: &syn::Signature, block: &syn::Block) -> bool {
        let constant = self.constant.contains(&signature.ident.to_string());
        if let Some(token) = &signature.constness
            && !constant
        {
            self.edits.push(Edit { range: token.span().byte_range(), kind: Kind::Const });
        }
        let constant = signature.constness.is_some() && constant;
        self.in_constant += usize::from(constant);
        if let Some(first) = block.stmts.first() {
            let start = first.span().byte_range().start;
            let hidden = signature.output.to_token_stream().to_string().contains("impl ");
            // An `impl Trait` return is one type, which the values of the mutants may not have.
            let ids = self.at(Genre::FnValue, |span| span.start == start && !hidden);
            let brace = block.brace_token.span.open().byte_range().end;
            self.edit(brace..brace, &ids.clone(), Kind::Body(ids));
        }
        constant
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        let constant = self.function(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
        self.in_constant -= usize::from(constant);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        let constant = self.function(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
        self.in_constant -= usize::from(constant);
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.in_constant += 1;
        visit::visit_item_const(self, item);
        self.in_constant -= 1;
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.in_constant += 1;
        visit::visit_impl_item_const(self, item);
        self.in_constant -= 1;
    }

    fn visit_item_static(&mut self, item: &'ast syn::ItemStatic) {
        self.in_constant += 1;
        visit::visit_item_static(self, item);
        self.in_constant -= 1;
    }

    fn visit_type(&mut self, item: &'ast syn::Type) {
        self.in_constant += 1;
        visit::visit_type(self, item);
        self.in_constant -= 1;
    }

    fn visit_expr_binary(&mut self, binary: &'ast syn::ExprBinary) {
        let operator = binary.op.span().byte_range();
        // `let` is an expression only in a condition, and cannot be moved into a branch of one.
        if !has_let(&binary.left) && !has_let(&binary.right) {
            let ids = self.at(Genre::BinaryOperator, |span| *span == operator);
            self.choice(binary.span().byte_range(), &ids);
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_unary(&mut self, unary: &'ast syn::ExprUnary) {
        let operator = unary.op.span().byte_range();
        let ids = self.at(Genre::UnaryOperator, |span| *span == operator);
        self.choice(unary.span().byte_range(), &ids);
        visit::visit_expr_unary(self, unary);
    }

    fn visit_expr_struct(&mut self, item: &'ast syn::ExprStruct) {
        let starts: Vec<usize> =
            item.fields.iter().map(|field| field.span().byte_range().start).collect();
        let ids = self.at(Genre::StructField, |span| starts.contains(&span.start));
        self.choice(item.span().byte_range(), &ids);
        visit::visit_expr_struct(self, item);
    }

    fn visit_expr_match(&mut self, item: &'ast syn::ExprMatch) {
        let arms = item.arms.iter().filter(|arm| arm.guard.is_none());
        let starts: Vec<usize> = arms.map(|arm| arm.span().byte_range().start).collect();
        let ids = self.at(Genre::MatchArm, |span| starts.contains(&span.start));
        if !ids.is_empty() {
            let range = item.expr.span().byte_range();
            self.edits.push(Edit { range, kind: Kind::Matched(ids) });
        }
        visit::visit_expr_match(self, item);
    }

    fn visit_arm(&mut self, arm: &'ast syn::Arm) {
        let (pattern, start) = (arm.pat.span().byte_range(), arm.span().byte_range().start);
        let deleted = self.at(Genre::MatchArm, |span| span.start == start);
        match &arm.guard {
            Some((_, guard)) => {
                let range = guard.span().byte_range();
                let mut ids = self.at(Genre::MatchArmGuard, |span| *span == range);
                ids.extend(deleted);
                self.edit(range, &ids.clone(), Kind::Guard(ids));
            }
            None => {
                for id in deleted {
                    self.edit(pattern.end..pattern.end, &[id], Kind::Arm(id));
                }
            }
        }
        visit::visit_arm(self, arm);
    }
}

fn has_let(expression: &syn::Expr) -> bool {
    match expression {
        syn::Expr::Let(_) => true,
        syn::Expr::Binary(binary) => has_let(&binary.left) || has_let(&binary.right),
        syn::Expr::Paren(inner) => has_let(&inner.expr),
        _ => false,
    }
}

struct Printer<'a> {
    source: &'a str,
    mutants: &'a BTreeMap<usize, Mutant>,
    edits: Vec<Edit>,
    text: String,
    places: Vec<Place>,
}

impl Printer<'_> {
    /// Prints a range with the edits in it, starting with edit `next`; returns the next edit after
    /// it.
    fn print(&mut self, range: Range<usize>, mut next: usize) -> usize {
        let mut at = range.start;
        while let Some(edit) = self
            .edits
            .get(next)
            .filter(|edit| edit.range.start >= range.start && edit.range.end <= range.end)
        {
            let inner = edit.range.clone();
            self.text += &self.source[at..inner.start];
            at = inner.end;
            next = self.print_edit(inner, next);
        }
        self.text += &self.source[at..range.end];
        next
    }

    fn print_edit(&mut self, range: Range<usize>, number: usize) -> usize {
        let start = self.text.len();
        let (ids, next) = match &self.edits[number].kind {
            Kind::Const => return number + 1,
            Kind::Choice(variants) => {
                let variants = variants.clone();
                self.text += "(";
                for (id, span) in &variants {
                    let (source, with) = (self.source, self.replacement(*id));
                    let before = &source[range.start..span.start];
                    let mutant = format!("{before}{with}{}", &source[span.end..range.end]);
                    self.variant(*id, &format!("if crate::woven({id}) {{ "), &mutant, " } else ");
                }
                self.text += "{ ";
                let next = self.print(range, number + 1);
                self.text += " })";
                (variants.into_iter().map(|(id, _)| id).collect(), next)
            }
            Kind::Body(ids) => {
                let ids = ids.clone();
                for id in &ids {
                    let with = self.replacement(*id);
                    let condition = format!(" if crate::woven({id}) {{ return ");
                    self.variant(*id, &condition, &with, "; }");
                }
                (ids, number + 1)
            }
            Kind::Guard(ids) => {
                let ids = ids.clone();
                let all = |value: &str| -> Vec<usize> {
                    ids.iter().copied().filter(|id| self.replacement(*id) == value).collect()
                };
                let calls = |ids: Vec<usize>, not: &str, join: &str| -> String {
                    ids.iter().map(|id| format!("{not}crate::woven({id}) {join} ")).collect()
                };
                let (always, never) =
                    (calls(all("true"), "", "||"), calls(all("false"), "!", "&&"));
                let deleted = calls(all(""), "!", "&&");
                self.text += &format!("{deleted}({always}{never}(");
                let next = self.print(range, number + 1);
                self.text += "))";
                (ids, next)
            }
            Kind::Matched(ids) => {
                let ids = ids.clone();
                (ids, self.print(range, number + 1))
            }
            Kind::Arm(id) => {
                let id = *id;
                self.text += &format!(" if !crate::woven({id})");
                (vec![id], number + 1)
            }
        };
        self.places.push(Place { range: start..self.text.len(), ids });
        next
    }

    fn variant(&mut self, id: usize, before: &str, mutant: &str, after: &str) {
        self.text += before;
        let start = self.text.len();
        self.text += mutant;
        self.places.push(Place { range: start..self.text.len(), ids: vec![id] });
        self.text += after;
    }

    fn replacement(&self, id: usize) -> String {
        self.mutants.get(&id).map(|mutant| mutant.replacement.clone()).unwrap_or_default()
    }
}

/// The source with one mutant in place of what it replaces.
pub fn replace(source: &str, mutant: &Mutant) -> String {
    let lines = line_starts(source);
    let at = |(line, column): (usize, usize)| offset(source, &lines, line, column);
    let (start, end) = (at(mutant.start), at(mutant.end));
    format!("{}{}{}", &source[..start], mutant.replacement, &source[end..])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mutant(genre: Genre, start: usize, end: usize, replacement: &str) -> Mutant {
        Mutant {
            file: "x.rs".into(),
            name: String::new(),
            line: String::new(),
            genre,
            start: (1, start + 1),
            end: (1, end + 1),
            replacement: replacement.into(),
        }
    }

    #[test]
    fn operators_bodies_and_arms() {
        let source = "const fn f(a: i32) -> bool { match a { 1 => !g(), n if n > 2 => a + 1 == n, _ => false } }";
        let at = |part: &str| source.find(part).unwrap();
        let mutants = [
            mutant(Genre::FnValue, at("match"), source.len() - 2, "true"),
            mutant(Genre::MatchArm, at("1 =>"), at("1 =>") + 9, ""),
            mutant(Genre::UnaryOperator, at("!g"), at("!g") + 1, ""),
            mutant(Genre::MatchArmGuard, at("n > 2"), at("n > 2") + 5, "true"),
            mutant(Genre::BinaryOperator, at("=="), at("==") + 2, "!="),
            mutant(Genre::BinaryOperator, at("+ 1"), at("+ 1") + 1, "-"),
        ];
        let mutants = mutants.into_iter().enumerate().collect();
        let woven = weave(source, &mutants, &BTreeSet::new()).unwrap();
        assert_eq!(
            woven.text,
            " fn f(a: i32) -> bool { if crate::woven(0) { return true; } match a { \
             1 if !crate::woven(1) => (if crate::woven(2) { g() } else { !g() }), \
             n if (crate::woven(3) || (n > 2)) => \
             (if crate::woven(4) { a + 1 != n } else { \
             (if crate::woven(5) { a - 1 } else { a + 1 }) == n }), _ => false } }"
        );
        assert!(woven.left_out.is_empty());
        let constant = BTreeSet::from(["f".to_owned()]);
        let kept = weave(source, &mutants, &constant).unwrap();
        assert_eq!((kept.text.as_str(), kept.left_out.len()), (source, 6));
        assert!(replace(source, &mutants[&4]).contains("a + 1 != n"));
    }
}
