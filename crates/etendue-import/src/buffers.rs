//! The bytes behind the document's buffers and buffer views.

use crate::document::{Document, get};
use crate::error::Fault;
use crate::source::Source;
use crate::warning::Warnings;
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
    /// Per accessor: whether its sparse indices have been found good.
    checked: Vec<AtomicBool>,
}

impl<'a> Buffers<'a> {
    /// Loads every buffer that a buffer view refers to.
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
            checked: doc.accessors.iter().map(|_| AtomicBool::new(false)).collect(),
        };
        let mut wanted = vec![false; doc.buffers.len()];
        for (i, v) in doc.buffer_views.iter().enumerate() {
            get(&doc.buffers, v.buffer, "buffer", || format!("/bufferViews/{i}/buffer"))?;
            wanted[v.buffer as usize] = true;
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
                    // A fallback buffer that need not exist; views into it say so when they are used.
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

    /// Runs a check of accessor `index`'s data unless it has passed before: an accessor may be used any number of times.
    pub fn once(&self, index: u32, check: impl FnOnce() -> Result<(), Fault>) -> Result<(), Fault> {
        let Some(done) = self.checked.get(index as usize) else { return check() };
        if !done.load(Ordering::Relaxed) {
            check()?;
            done.store(true, Ordering::Relaxed);
        }
        Ok(())
    }

    /// The bytes of buffer view `index`, which `from` refers to.
    pub fn view(&self, doc: &Document<'_>, index: u32, from: impl Fn() -> String) -> Result<&[u8], Fault> {
        let v = get(&doc.buffer_views, index, "buffer view", &from)?;
        let pointer = || format!("/bufferViews/{index}");
        let buffer = get(&doc.buffers, v.buffer, "buffer", || format!("{}/buffer", pointer()))?;
        let Some(block) = self.of_buffer[v.buffer as usize] else {
            return Err(if v.meshopt {
                Fault::Unsupported {
                    pointer: pointer(),
                    what: "EXT_meshopt_compression (its fallback buffer has no data)".into(),
                    hint: "; export the model without mesh compression".into(),
                }
            } else {
                Fault::invalid(
                    format!("/buffers/{}", v.buffer),
                    "has no `uri` and there is no binary chunk for it",
                )
            });
        };
        let end = v.byte_offset.checked_add(v.byte_length).filter(|&e| e <= buffer.byte_length);
        let Some(end) = end else {
            return Err(Fault::invalid(
                pointer(),
                format!(
                    "{} bytes from byte {} reach beyond buffer {} of {} bytes",
                    v.byte_length, v.byte_offset, v.buffer, buffer.byte_length
                ),
            ));
        };
        // Within byte_length, which `load` found to be within the block.
        Ok(&self.blocks[block][v.byte_offset as usize..end as usize])
    }
}
