//! Mode 1: triangles that share edges and vertices with those just before them.

use super::{Input, MeshoptError, MeshoptError::Damaged, parts, push, unzigzag};

/// The last sixteen of something, the newest found at 0.
struct Recent<T> {
    items: [T; 16],
    /// How many were ever added.
    count: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { items: [T::default(); 16], count: 0 }
    }

    #[inline(always)]
    fn push(&mut self, v: T) {
        self.items[self.count & 15] = v;
        self.count += 1;
    }

    #[inline(always)]
    fn get(&self, back: usize) -> Result<T, MeshoptError> {
        if back >= self.count {
            return Err(Damaged("it refers to what did not come before"));
        }
        Ok(self.items[(self.count - 1 - back) & 15])
    }
}

/// What the decoder remembers between triangles.
struct State<'a> {
    data: Input<'a>,
    /// The lowest index that was never used.
    next: u32,
    /// The last index that was spelled out.
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

pub(super) fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, MeshoptError> {
    let (header, mut data, table) = parts(bytes, 16)?;
    if header != 0xe1 {
        return Err(Damaged("the first byte is not that of triangles"));
    }
    if table[14..] != [0, 0] || table.iter().any(|b| b & 15 == 15 || b >> 4 == 15) {
        return Err(Damaged("the table at its end is not valid"));
    }
    let codes = data.take(count / 3)?;
    let mut s = State { data, next: 0, last: 0, edges: Recent::new(), vertices: Recent::new() };
    let mut out = Vec::with_capacity(count * stride);
    for &code in codes {
        for i in s.triangle(code, table)? {
            push(&mut out, i, stride);
        }
    }
    s.data.finish()?;
    Ok(out)
}

impl State<'_> {
    #[inline(always)]
    fn fresh(&mut self) -> u32 {
        let v = self.next;
        self.next = v.wrapping_add(1);
        v
    }

    fn explicit(&mut self) -> Result<u32, MeshoptError> {
        self.last = self.last.wrapping_add(unzigzag(self.data.varint()?));
        Ok(self.last)
    }

    fn triangle(&mut self, code: u8, table: &[u8]) -> Result<[u32; 3], MeshoptError> {
        let (x, y) = (code >> 4, code & 15);
        if x < 15 { self.on_edge(x, y) } else { self.apart(y, table) }
    }

    /// A triangle on a recent edge.
    #[inline(always)]
    fn on_edge(&mut self, x: u8, y: u8) -> Result<[u32; 3], MeshoptError> {
        let [a, b] = self.edges.get(x.into())?;
        let c = match y {
            0 => self.fresh(),
            1..13 => self.vertices.get(y.into())?,
            13 | 14 => {
                self.last = if y == 13 { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                self.last
            }
            _ => self.explicit()?,
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if !(1..13).contains(&y) {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle on no recent edge: its vertices are new, recent, or spelled out.
    fn apart(&mut self, y: u8, table: &[u8]) -> Result<[u32; 3], MeshoptError> {
        let zw = if y < 14 {
            table[usize::from(y)]
        } else {
            let zw = self.data.byte()?;
            if zw == 0 {
                self.next = 0;
            }
            zw
        };
        let a = if y == 15 { self.explicit()? } else { self.fresh() };
        let b = self.vertex(zw >> 4)?;
        let c = self.vertex(zw & 15)?;
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        self.vertices.push(a);
        for (v, how) in [(b, zw >> 4), (c, zw & 15)] {
            if matches!(how, 0 | 15) {
                self.vertices.push(v);
            }
        }
        Ok([a, b, c])
    }

    /// The second or third vertex of a triangle on no recent edge; recent ones are counted from before the triangle.
    fn vertex(&mut self, how: u8) -> Result<u32, MeshoptError> {
        match how {
            0 => Ok(self.fresh()),
            15 => self.explicit(),
            n => self.vertices.get(usize::from(n) - 1),
        }
    }
}
