//! DXF: sections, layers, blocks. An own reader, because what is needed of the format is little, and every
//! count in it has to be bounded.

mod entity;
mod expand;
mod tags;
mod words;

use std::collections::HashMap;

use lafet_texts::drawing as text;

use crate::matrix::Vector;
use crate::shape::{Builder, Drawing, Format};
use crate::{Limits, Problem, Unit};
use entity::{Entity, Fields, Kind, Vertex};
use tags::{Tag, Tags};
use words::Decoder;

/// A block: what is drawn when it is inserted.
#[derive(Debug, Default)]
pub struct Block {
    base: Vector,
    entities: Vec<Entity>,
    /// In another file.
    elsewhere: bool,
}

pub fn read(bytes: &[u8], limits: &Limits) -> Result<Drawing, Problem> {
    let mut reader = Reader {
        tags: Tags::new(bytes),
        decoder: Decoder::default(),
        builder: Builder::new(Format::Dxf, limits),
        blocks: HashMap::new(),
        entities: Vec::new(),
        read: 0,
        limits,
    };
    reader.file()?;
    let Reader { builder, blocks, entities, .. } = reader;
    expand::expanded(builder, &blocks, &entities, limits)
}

struct Reader<'a> {
    tags: Tags<'a>,
    decoder: Decoder,
    builder: Builder<'a>,
    blocks: HashMap<String, Block>,
    entities: Vec<Entity>,
    /// Vertices and entities so far, in blocks too.
    read: usize,
    limits: &'a Limits,
}

impl<'a> Reader<'a> {
    fn file(&mut self) -> Result<(), Problem> {
        let mut sections = 0;
        loop {
            let tag = self.tags.next()?;
            if tag.is(0, "EOF") {
                break;
            }
            if !tag.is(0, "SECTION") {
                // Between sections there is nothing; what is there all the same is passed over.
                continue;
            }
            sections += 1;
            let name = self.tags.next()?;
            match name {
                it if it.is(2, "HEADER") => self.header()?,
                it if it.is(2, "TABLES") => self.tables()?,
                it if it.is(2, "BLOCKS") => self.blocks()?,
                it if it.is(2, "ENTITIES") => self.entities = self.entities()?,
                _ => self.pass()?,
            }
        }
        if sections == 0 {
            return Err(Problem::new(text::NoSections, text::BrokenRemedy));
        }
        Ok(())
    }

    /// Passes over the rest of a section.
    fn pass(&mut self) -> Result<(), Problem> {
        while !self.tags.next()?.is(0, "ENDSEC") {}
        Ok(())
    }

    fn header(&mut self) -> Result<(), Problem> {
        let mut variable: &[u8] = b"";
        loop {
            let tag = self.tags.next()?;
            if tag.is(0, "ENDSEC") {
                return Ok(());
            }
            if tag.code == 9 {
                variable = tag.bytes().trim_ascii();
                continue;
            }
            match variable {
                b"$INSUNITS" if tag.code == 70 => {
                    self.builder.drawing.proposed = Unit::of_insunits(tag.whole()?);
                }
                b"$DWGCODEPAGE" if tag.code == 3 => self.decoder = Decoder::of_page(tag.bytes()),
                _ => {}
            }
        }
    }

    /// Of the tables, layers alone.
    fn tables(&mut self) -> Result<(), Problem> {
        loop {
            let tag = self.tags.next()?;
            if tag.is(0, "ENDSEC") {
                return Ok(());
            }
            if tag.is(0, "LAYER") {
                let fields = self.fields(tag)?;
                let name = self.decoder.text(fields.bytes(2));
                let layer = self.builder.layer(&name)?;
                if fields.whole(70, 0)? & 1 != 0 || fields.whole(62, 7)? < 0 {
                    self.builder.hide(layer);
                }
            }
        }
    }

    fn blocks(&mut self) -> Result<(), Problem> {
        loop {
            let tag = self.tags.next()?;
            if tag.is(0, "ENDSEC") {
                return Ok(());
            }
            if !tag.is(0, "BLOCK") {
                continue;
            }
            let fields = self.fields(tag)?;
            let name = self.decoder.text(fields.bytes(2)).to_lowercase();
            let (base, flags) = (fields.place(10)?, fields.whole(70, 0)?);
            // 4 and 8: an external reference, of this drawing or overlaid.
            let elsewhere = flags & 0b1100 != 0;
            self.counted(1, tag.line)?;
            let entities = self.entities()?;
            self.blocks.insert(name, Block { base, entities, elsewhere });
        }
    }

    /// Entities up to the end of the section or block.
    fn entities(&mut self) -> Result<Vec<Entity>, Problem> {
        let mut entities = Vec::new();
        loop {
            let tag = self.tags.next()?;
            if tag.is(0, "ENDBLK") {
                return Ok(entities);
            }
            if tag.is(0, "ENDSEC") {
                // Blocks that end without a word of it end with their section.
                self.tags.back(tag);
                return Ok(entities);
            }
            if tag.is(0, "EOF") {
                return Err(Problem::at(tag.line, text::Cut, text::CutRemedy));
            }
            if tag.code == 0
                && let Some(entity) = self.entity(tag)?
            {
                self.counted(1 + entity.vertices(), tag.line)?;
                entities.push(entity);
            }
        }
    }

    fn counted(&mut self, count: usize, line: usize) -> Result<(), Problem> {
        self.read += count;
        self.within(self.read, line)
    }

    fn within(&self, count: usize, line: usize) -> Result<(), Problem> {
        let Limits { shapes, points, .. } = *self.limits;
        if count <= points {
            return Ok(());
        }
        Err(Problem::at(line, text::TooMuch { shapes, points }, text::TooMuchRemedy))
    }

    fn entity(&mut self, start: Tag<'a>) -> Result<Option<Entity>, Problem> {
        let name = String::from_utf8_lossy(start.bytes().trim_ascii()).to_ascii_uppercase();
        let fields = self.fields(start)?;
        let layer = self.decoder.text(fields.bytes(8));
        let layer = self.builder.layer(&layer)?;
        let kind = fields.kind(&name, self.decoder)?;
        let kind = match kind {
            Some(Kind::Path { closed, spatial, thickness, .. }) if name == "POLYLINE" => {
                let vertices = self.vertices(spatial)?;
                Some(Kind::Path { vertices, closed, spatial, thickness })
            }
            Some(Kind::Insert(mut insert)) if fields.whole(66, 0)? == 1 => {
                insert.name = self.attributes()?;
                Some(Kind::Insert(insert))
            }
            kind => kind,
        };
        // Of paper, not of the site; or not visible.
        let aside = fields.whole(67, 0)? == 1;
        let invisible = fields.whole(60, 0)? == 1;
        let Some(kind) = kind.filter(|_| !aside && !invisible) else {
            if !matches!(name.as_str(), "SEQEND" | "VERTEX" | "ATTRIB" | "ATTDEF" | "VIEWPORT") {
                self.builder.skip(&name);
            }
            return Ok(None);
        };
        Ok(Some(Entity { layer, normal: fields.normal()?, kind, line: start.line }))
    }

    /// The vertices of a POLYLINE, up to its SEQEND.
    fn vertices(&mut self, spatial: bool) -> Result<Vec<Vertex>, Problem> {
        let mut vertices = Vec::new();
        loop {
            let tag = self.tags.next()?;
            if tag.code != 0 {
                continue;
            }
            if !tag.is(0, "VERTEX") {
                if !tag.is(0, "SEQEND") {
                    self.tags.back(tag);
                }
                return Ok(vertices);
            }
            let fields = self.fields(tag)?;
            // 16: a point of the frame of a spline, through which the line does not pass.
            if fields.whole(70, 0)? & 16 == 0 {
                let bulge = if spatial { 0.0 } else { fields.real(42, 0.0)? };
                self.counted(1, tag.line)?;
                vertices.push(Vertex { at: fields.place(10)?, bulge });
            }
        }
    }

    /// The name in the attributes of an INSERT, up to its SEQEND: that which is called so, else the first.
    fn attributes(&mut self) -> Result<Option<String>, Problem> {
        const CALLED: [&str; 4] = ["NAME", "ID", "TAG", "TITLE"];
        let mut found: Option<(usize, String)> = None;
        loop {
            let tag = self.tags.next()?;
            if tag.code != 0 {
                continue;
            }
            if !tag.is(0, "ATTRIB") {
                if !tag.is(0, "SEQEND") {
                    self.tags.back(tag);
                }
                return Ok(found.map(|(_, name)| name));
            }
            let fields = self.fields(tag)?;
            let called = fields.bytes(2).trim_ascii();
            let rank = CALLED.iter().position(|it| called.eq_ignore_ascii_case(it.as_bytes()));
            let rank = rank.unwrap_or(CALLED.len());
            let value = crate::shape::name(&self.decoder.text(fields.bytes(1)));
            if !value.is_empty() && found.as_ref().is_none_or(|(known, _)| rank < *known) {
                found = Some((rank, value));
            }
        }
    }

    /// The pairs of an entity, up to the next one.
    fn fields(&mut self, start: Tag<'a>) -> Result<Fields<'a>, Problem> {
        let mut tags = Vec::new();
        loop {
            let tag = self.tags.next()?;
            if tag.code == 0 {
                self.tags.back(tag);
                return Ok(Fields::new(start.line, tags));
            }
            // Data of other programs are not needed.
            if tag.code < 1000 {
                tags.push(tag);
            }
            // A vertex has four pairs at most.
            self.within(tags.len() / 4, tag.line)?;
        }
    }
}
