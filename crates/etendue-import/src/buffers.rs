//! The bytes behind the document's buffers and buffer views.

use crate::document::{Compressed, Document, get};
use crate::error::Fault;
use crate::limits::Budget;
use crate::meshopt;
use crate::source::Source;
use crate::warning::Warnings;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};

/// The loaded buffers.
pub(crate) struct Buffers<'a> {
    /// Distinct blocks of bytes; several buffers may name one file.
    blocks: Vec<Cow<'a, [u8]>>,
    /// Per buffer: its block, if it has data and something refers to it.
    of_buffer: Vec<Option<usize>>,
    /// Bytes read from files beside the model.
    pub external: u64,
    /// Elements of accessors whose primitives are compressed.
    pub decoded_attributes: Vec<Vec<u8>>,
    /// The content of compressed views.
    decoded: HashMap<u32, Vec<u8>>,
    /// Per accessor: whether its sparse indices have been found good.
    checked: Vec<AtomicBool>,
}

impl<'a> Buffers<'a> {
    /// Loads every buffer that a buffer view has its content in; fallbacks of compressed views are not needed.
    pub fn load(
        doc: &Document<'_>,
        binary: Option<&'a [u8]>,
        source: &Source<'_>,
        warnings: &mut Warnings,
    ) -> Result<Self, Fault> {
        let mut out = Self {
            blocks: Vec::new(),
            of_buffer: vec![None; doc.buffers.len()],
            external: 0,
            decoded_attributes: Vec::new(),
            decoded: HashMap::new(),
            checked: doc.accessors.iter().map(|_| AtomicBool::new(false)).collect(),
        };
        let mut wanted = vec![false; doc.buffers.len()];
        for (i, v) in doc.buffer_views.iter().enumerate() {
            get(&doc.buffers, v.buffer, "buffer", || format!("/bufferViews/{i}/buffer"))?;
            let buffer = match v.compressed.as_deref() {
                Some(c) => {
                    get(&doc.buffers, c.buffer, "buffer", || format!("{}/buffer", place(i, c)))?;
                    c.buffer
                }
                None => v.buffer,
            };
            wanted[buffer as usize] = true;
        }
        let mut by_uri: HashMap<&str, usize> = HashMap::new();
        for (i, b) in doc.buffers.iter().enumerate().filter(|&(i, _)| wanted[i]) {
            let pointer = format!("/buffers/{i}");
            let block = match b.uri {
                Some(uri) => match by_uri.get(uri) {
                    Some(&known) => known,
                    None => {
                        let bytes = source.read(uri, "buffer", &pointer)?;
                        if !uri.starts_with("data:") {
                            out.external += bytes.len() as u64;
                        }
                        out.blocks.push(Cow::Owned(bytes));
                        by_uri.insert(uri, out.blocks.len() - 1);
                        out.blocks.len() - 1
                    }
                },
                None => match binary {
                    Some(bytes) if i == 0 => {
                        out.blocks.push(Cow::Borrowed(bytes));
                        out.blocks.len() - 1
                    }
                    // It may be that nothing uses it; views into it say so when they are used.
                    _ => continue,
                },
            };
            let have = out.blocks[block].len() as u64;
            if have < b.byte_length {
                return Err(Fault::invalid(
                    format!("{pointer}/byteLength"),
                    format!("{} bytes announced, {have} present: the data are cut off", b.byte_length),
                ));
            }
            // A GLB chunk is padded to a multiple of four.
            if have - b.byte_length > 3 {
                warnings.add(
                    format!("{pointer}/byteLength"),
                    "the buffer has more data than announced; the rest is ignored",
                );
            }
            out.of_buffer[i] = Some(block);
        }
        Ok(out)
    }

    /// Decodes the compressed views, in parallel, after their size is booked.
    pub fn decompress(&mut self, doc: &Document<'_>, budget: &mut Budget) -> Result<(), Fault> {
        let mut jobs = Vec::new();
        for (i, v) in doc.buffer_views.iter().enumerate() {
            let Some(c) = v.compressed.as_deref() else { continue };
            let size = c.layout.count.saturating_mul(c.layout.stride);
            if size != v.byte_length {
                return Err(Fault::invalid(
                    place(i, c),
                    format!("decodes to {size} bytes, but its view has {}", v.byte_length),
                ));
            }
            budget.bytes(size, || place(i, c))?;
            let pointer = || place(i, c);
            jobs.push((i as u32, c, self.range(doc, c.buffer, c.byte_offset, c.byte_length, pointer)?));
        }
        let decoded: Result<HashMap<u32, Vec<u8>>, Fault> = jobs
            .into_par_iter()
            .map(|(i, c, bytes)| {
                let content = meshopt::decode(bytes, &c.layout);
                content.map(|b| (i, b)).map_err(|e| Fault::invalid(place(i as usize, c), e.to_string()))
            })
            .collect();
        self.decoded = decoded?;
        Ok(())
    }

    /// `crc`, continued over the blocks of bytes that were read from elsewhere than the model itself.
    pub fn digest(&self, crc: u32) -> u32 {
        let mut h = crc32fast::Hasher::new_with_initial(crc);
        for block in &self.blocks {
            if let Cow::Owned(bytes) = block {
                h.update(bytes);
            }
        }
        h.finalize()
    }

    /// Runs a check of accessor `index`'s data unless it has passed before: an accessor may be used any number of times.
    pub fn once(&self, index: u32, check: impl FnOnce() -> Result<(), Fault>) -> Result<(), Fault> {
        let Some(done) = self.checked.get(index as usize) else { return check() };
        if !done.load(Ordering::Relaxed) {
            check()?;
            done.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    /// The content of buffer view `index`, which `from` refers to.
    pub fn view(&self, doc: &Document<'_>, index: u32, from: impl Fn() -> String) -> Result<&[u8], Fault> {
        let v = get(&doc.buffer_views, index, "buffer view", &from)?;
        match self.decoded.get(&index) {
            Some(content) => Ok(content),
            None => {
                self.range(doc, v.buffer, v.byte_offset, v.byte_length, || format!("/bufferViews/{index}"))
            }
        }
    }

    /// Bytes of a buffer, for what stands at `pointer`.
    fn range(
        &self,
        doc: &Document<'_>,
        index: u32,
        offset: u64,
        length: u64,
        pointer: impl Fn() -> String,
    ) -> Result<&[u8], Fault> {
        let buffer = get(&doc.buffers, index, "buffer", || format!("{}/buffer", pointer()))?;
        let Some(block) = self.of_buffer[index as usize] else {
            return Err(Fault::invalid(
                format!("/buffers/{index}"),
                "has no `uri` and there is no binary chunk for it",
            ));
        };
        let Some(end) = offset.checked_add(length).filter(|&e| e <= buffer.byte_length) else {
            return Err(Fault::invalid(
                pointer(),
                format!(
                    "{length} bytes from byte {offset} reach beyond buffer {index} of {} bytes",
                    buffer.byte_length
                ),
            ));
        };
        // Within byte_length, which `load` found to be within the block.
        Ok(&self.blocks[block][offset as usize..end as usize])
    }
}

/// JSON pointer to the compressed form of view `index`.
fn place(index: usize, c: &Compressed) -> String {
    format!("/bufferViews/{index}/extensions/{}", c.extension)
}
