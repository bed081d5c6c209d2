//! Formulas as straight-line programs: what a shader would execute, one operation after another.

use std::fmt;
use std::str::FromStr;

/// What an operation reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Arg {
    /// Perceptual roughness.
    Roughness,
    /// N·V.
    Cos,
    /// The result of an earlier operation.
    Node(u8),
    /// A coefficient.
    Constant(u8),
}

/// An operation that graphics processors have as one instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    Add,
    Sub,
    Mul,
    /// a · b + c.
    Fma,
    /// c − a · b.
    Fnma,
    Min,
    Max,
    /// 2 to the power of a, at a quarter of the rate.
    Exp2,
    /// Square root, at a quarter of the rate.
    Sqrt,
    /// 1 / √a, at a quarter of the rate.
    Rsqrt,
    /// 1 / a, at a quarter of the rate.
    Rcp,
}

pub const OPS: [Op; 11] =
    [Op::Add, Op::Sub, Op::Mul, Op::Fma, Op::Fnma, Op::Min, Op::Max, Op::Exp2, Op::Sqrt, Op::Rsqrt, Op::Rcp];

impl Op {
    pub fn arity(self) -> usize {
        match self {
            Self::Exp2 | Self::Sqrt | Self::Rsqrt | Self::Rcp => 1,
            Self::Fma | Self::Fnma => 3,
            _ => 2,
        }
    }

    /// Issue slots: 1, or 4 for what runs at a quarter of the rate.
    pub fn slots(self) -> usize {
        if self.arity() == 1 { 4 } else { 1 }
    }

    fn commutes(self) -> bool {
        !matches!(self, Self::Sub) && self.arity() > 1
    }

    fn name(self) -> &'static str {
        match self {
            Self::Add => "add",
            Self::Sub => "sub",
            Self::Mul => "mul",
            Self::Fma => "fma",
            Self::Fnma => "fnma",
            Self::Min => "min",
            Self::Max => "max",
            Self::Exp2 => "exp2",
            Self::Sqrt => "sqrt",
            Self::Rsqrt => "rsqrt",
            Self::Rcp => "rcp",
        }
    }
}

/// An operation and its operands; those beyond its arity repeat the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Node {
    pub op: Op,
    pub args: [Arg; 3],
}

/// Operations in order, coefficients, and which results are the scale and the bias.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    pub nodes: Vec<Node>,
    pub constants: Vec<f64>,
    pub out: [u8; 2],
}

/// Most operations of a program.
pub const MOST_NODES: usize = 48;
/// Most coefficients.
pub const MOST_CONSTANTS: usize = 40;

impl Program {
    /// Operations, each counted once.
    pub fn operations(&self) -> usize {
        self.nodes.len()
    }

    /// Issue slots of all operations.
    pub fn slots(&self) -> usize {
        self.nodes.iter().map(|n| n.op.slots()).sum()
    }

    /// Drops what no output needs, joins what is the same, folds what is constant and fuses products into sums. `None` if nothing is left of an
    /// output, or it is too long.
    pub fn tidy(mut self) -> Option<Self> {
        for _ in 0..4 {
            let before = self.nodes.len();
            self.fuse();
            self = self.rebuilt()?;
            if self.nodes.len() == before {
                break;
            }
        }
        (self.nodes.len() <= MOST_NODES && self.constants.len() <= MOST_CONSTANTS).then_some(self)
    }

    fn uses(&self) -> Vec<u32> {
        let mut uses = vec![0; self.nodes.len()];
        for n in &self.nodes {
            for a in &n.args[..n.op.arity()] {
                if let Arg::Node(k) = a {
                    uses[*k as usize] += 1;
                }
            }
        }
        self.out.iter().for_each(|o| uses[*o as usize] += 1);
        uses
    }

    /// A sum of a product that nothing else needs is one operation.
    fn fuse(&mut self) {
        let uses = self.uses();
        for i in 0..self.nodes.len() {
            let n = self.nodes[i];
            let product = |a: Arg| match a {
                Arg::Node(k) if uses[k as usize] == 1 && self.nodes[k as usize].op == Op::Mul => {
                    Some(self.nodes[k as usize].args)
                }
                _ => None,
            };
            let fused = match n.op {
                Op::Add => product(n.args[0])
                    .map(|p| (Op::Fma, p, n.args[1]))
                    .or_else(|| product(n.args[1]).map(|p| (Op::Fma, p, n.args[0]))),
                Op::Sub => product(n.args[1]).map(|p| (Op::Fnma, p, n.args[0])),
                _ => None,
            };
            if let Some((op, p, c)) = fused {
                self.nodes[i] = Node { op, args: [p[0], p[1], c] };
            }
        }
    }

    fn rebuilt(self) -> Option<Self> {
        let mut needed = vec![false; self.nodes.len()];
        self.out.iter().for_each(|o| needed[*o as usize] = true);
        for i in (0..self.nodes.len()).rev() {
            if needed[i] {
                let n = &self.nodes[i];
                for a in &n.args[..n.op.arity()] {
                    if let Arg::Node(k) = a {
                        needed[*k as usize] = true;
                    }
                }
            }
        }
        let mut out = Self { nodes: Vec::new(), constants: Vec::new(), out: [0; 2] };
        // What each old node has become.
        let mut new: Vec<Arg> = Vec::with_capacity(self.nodes.len());
        // Values of folded constants, by their place in `out.constants` before they are used.
        let mut folded: Vec<f64> = Vec::new();
        for (i, n) in self.nodes.iter().enumerate() {
            if !needed[i] {
                new.push(Arg::Roughness);
                continue;
            }
            let arity = n.op.arity();
            let mut value = [0.0; 3];
            let mut args = [Arg::Roughness; 3];
            let mut constant = 0;
            for k in 0..arity {
                args[k] = match n.args[k] {
                    Arg::Node(j) => new[j as usize],
                    Arg::Constant(c) => {
                        folded.push(self.constants[c as usize]);
                        Arg::Constant(100 + (folded.len() - 1) as u8)
                    }
                    a => a,
                };
                if let Arg::Constant(c) = args[k] {
                    value[k] = *folded.get(c as usize - 100)?;
                    constant += 1;
                }
                if folded.len() > 100 {
                    return None;
                }
            }
            if constant == arity {
                folded.push(apply(n.op, value));
                new.push(Arg::Constant(100 + (folded.len() - 1) as u8));
                continue;
            }
            // Own coefficients for each use: joined ones would have to agree.
            for k in 0..arity {
                if let Arg::Constant(_) = args[k] {
                    out.constants.push(value[k]);
                    args[k] = Arg::Constant((out.constants.len() - 1) as u8);
                }
            }
            let mut op = n.op;
            if let (Op::Fma | Op::Fnma, [Arg::Constant(a), Arg::Constant(b), x]) = (op, args) {
                // A product of coefficients is one.
                let product = out.constants[a as usize] * out.constants[b as usize];
                out.constants.truncate(out.constants.len() - 2);
                out.constants.push(if op == Op::Fma { product } else { -product });
                (op, args) = (Op::Add, [Arg::Constant((out.constants.len() - 1) as u8), x, x]);
            }
            for k in op.arity()..3 {
                args[k] = args[0];
            }
            let node = Node { op, args };
            let free = constant > 0;
            let same = (!free).then(|| out.nodes.iter().position(|m| same(m, &node))).flatten();
            new.push(Arg::Node(same.unwrap_or_else(|| {
                out.nodes.push(node);
                out.nodes.len() - 1
            }) as u8));
        }
        for k in 0..2 {
            out.out[k] = match new[self.out[k] as usize] {
                Arg::Node(n) => n,
                _ => return None,
            };
        }
        Some(out)
    }

    /// All intermediate values at points of roughness `r` and cosine `m`, a row of them for each operation.
    pub fn evaluate(&self, r: &[f64], m: &[f64], values: &mut Vec<f64>) {
        let n = r.len();
        values.resize(n * self.nodes.len(), 0.0);
        for (i, node) in self.nodes.iter().enumerate() {
            let (before, rest) = values.split_at_mut(i * n);
            let target = &mut rest[..n];
            let operand = |k: usize| self.operand(node.args[k], r, m, before, n);
            match node.op.arity() {
                1 => each(target, [operand(0)], |[a]| apply(node.op, [a, 0.0, 0.0])),
                2 => match node.op {
                    Op::Add => each(target, [operand(0), operand(1)], |[a, b]| a + b),
                    Op::Sub => each(target, [operand(0), operand(1)], |[a, b]| a - b),
                    Op::Mul => each(target, [operand(0), operand(1)], |[a, b]| a * b),
                    op => each(target, [operand(0), operand(1)], |[a, b]| apply(op, [a, b, 0.0])),
                },
                _ if node.op == Op::Fma => {
                    each(target, [operand(0), operand(1), operand(2)], |[a, b, c]| a * b + c);
                }
                _ => each(target, [operand(0), operand(1), operand(2)], |[a, b, c]| c - a * b),
            }
        }
    }

    fn operand<'a>(&self, a: Arg, r: &'a [f64], m: &'a [f64], before: &'a [f64], n: usize) -> Operand<'a> {
        match a {
            Arg::Roughness => Operand::Row(r),
            Arg::Cos => Operand::Row(m),
            Arg::Node(k) => Operand::Row(&before[k as usize * n..(k as usize + 1) * n]),
            Arg::Constant(c) => Operand::One(self.constants[c as usize]),
        }
    }

    /// The derivatives of output `which` by each coefficient, a row for each, from the values of [`Program::evaluate`]: reverse mode.
    pub fn derivatives(
        &self,
        which: usize,
        r: &[f64],
        m: &[f64],
        values: &[f64],
        adjoint: &mut Vec<f64>,
        out: &mut Vec<f64>,
    ) {
        let n = r.len();
        adjoint.clear();
        adjoint.resize(n * self.nodes.len(), 0.0);
        out.clear();
        out.resize(n * self.constants.len(), 0.0);
        let last = self.out[which] as usize;
        adjoint[last * n..(last + 1) * n].fill(1.0);
        for i in (0..=last).rev() {
            let node = &self.nodes[i];
            let (before, rest) = adjoint.split_at_mut(i * n);
            let a = &rest[..n];
            let result = &values[i * n..(i + 1) * n];
            let operand = |k: usize| self.operand(node.args[k], r, m, values, n);
            let (x, y) = (operand(0), operand(1));
            for k in 0..node.op.arity() {
                let target = match node.args[k] {
                    Arg::Node(j) => &mut before[j as usize * n..(j as usize + 1) * n],
                    Arg::Constant(c) => &mut out[c as usize * n..(c as usize + 1) * n],
                    _ => continue,
                };
                let other = if k == 0 { &y } else { &x };
                const LN2: f64 = std::f64::consts::LN_2;
                match (node.op, k) {
                    (Op::Add, _) | (Op::Sub, 0) | (Op::Fma | Op::Fnma, 2) => add(target, a, |_| 1.0),
                    (Op::Sub, _) => add(target, a, |_| -1.0),
                    (Op::Mul | Op::Fma, _) => add(target, a, |p| other.at(p)),
                    (Op::Fnma, _) => add(target, a, |p| -other.at(p)),
                    (Op::Min, 0) => add(target, a, |p| if x.at(p) <= y.at(p) { 1.0 } else { 0.0 }),
                    (Op::Min, _) => add(target, a, |p| if x.at(p) <= y.at(p) { 0.0 } else { 1.0 }),
                    (Op::Max, 0) => add(target, a, |p| if x.at(p) >= y.at(p) { 1.0 } else { 0.0 }),
                    (Op::Max, _) => add(target, a, |p| if x.at(p) >= y.at(p) { 0.0 } else { 1.0 }),
                    (Op::Exp2, _) => add(target, a, |p| LN2 * result[p]),
                    (Op::Sqrt, _) => add(target, a, |p| 0.5 / result[p].max(1e-6)),
                    (Op::Rsqrt, _) => add(target, a, |p| -0.5 * result[p].powi(3)),
                    (Op::Rcp, _) => add(target, a, |p| -result[p] * result[p]),
                }
            }
        }
    }
}

/// A row of values, or one for all.
enum Operand<'a> {
    Row(&'a [f64]),
    One(f64),
}

impl Operand<'_> {
    #[inline(always)]
    fn at(&self, p: usize) -> f64 {
        match self {
            Self::Row(r) => r[p],
            Self::One(v) => *v,
        }
    }
}

#[inline(always)]
fn each<const K: usize>(target: &mut [f64], operands: [Operand; K], f: impl Fn([f64; K]) -> f64) {
    for (p, t) in target.iter_mut().enumerate() {
        *t = f(std::array::from_fn(|k| operands[k].at(p)));
    }
}

#[inline(always)]
fn add(target: &mut [f64], a: &[f64], f: impl Fn(usize) -> f64) {
    for (p, (t, a)) in target.iter_mut().zip(a).enumerate() {
        *t += a * f(p);
    }
}

pub fn apply(op: Op, [a, b, c]: [f64; 3]) -> f64 {
    match op {
        Op::Add => a + b,
        Op::Sub => a - b,
        Op::Mul => a * b,
        Op::Fma => a * b + c,
        Op::Fnma => c - a * b,
        Op::Min => a.min(b),
        Op::Max => a.max(b),
        Op::Exp2 => exp2(a),
        Op::Sqrt => a.sqrt(),
        Op::Rsqrt => 1.0 / a.sqrt(),
        Op::Rcp => 1.0 / a,
    }
}

/// 2ˣ to about 1e-10, in a form that compilers turn into vectors; x is kept within ±60.
#[inline(always)]
fn exp2(x: f64) -> f64 {
    // Above 1.5 · 2⁵² the last bits of a sum are the nearest integer.
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let x = x.clamp(-60.0, 60.0);
    let shifted = x + MAGIC;
    let t = (x - (shifted - MAGIC)) * std::f64::consts::LN_2;
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
    let p = 1.0 / 40320.0;
    let p = p * t + 1.0 / 5040.0;
    let p = p * t + 1.0 / 720.0;
    let p = p * t + 1.0 / 120.0;
    let p = p * t + 1.0 / 24.0;
    let p = p * t + 1.0 / 6.0;
    (((p * t + 0.5) * t + 1.0) * t + 1.0) * scale
}

fn same(a: &Node, b: &Node) -> bool {
    if a.op != b.op || a.args.iter().any(|a| matches!(a, Arg::Constant(_))) {
        return false;
    }
    let n = a.op.arity();
    let direct = a.args[..n] == b.args[..n];
    let swapped =
        a.op.commutes() && [a.args[1], a.args[0]] == b.args[..2] && (n < 3 || a.args[2] == b.args[2]);
    direct || swapped
}

impl fmt::Display for Program {
    /// One line: `a=fma(r,m,0.5) … -> scale bias`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, n) in self.nodes.iter().enumerate() {
            write!(f, "t{i}={}(", n.op.name())?;
            for (k, a) in n.args[..n.op.arity()].iter().enumerate() {
                if k > 0 {
                    f.write_str(",")?;
                }
                match a {
                    Arg::Roughness => f.write_str("r")?,
                    Arg::Cos => f.write_str("m")?,
                    Arg::Node(j) => write!(f, "t{j}")?,
                    Arg::Constant(c) => write!(f, "{:.8}", self.constants[*c as usize])?,
                }
            }
            f.write_str(") ")?;
        }
        write!(f, "-> t{} t{}", self.out[0], self.out[1])
    }
}

impl FromStr for Program {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let mut p = Self { nodes: Vec::new(), constants: Vec::new(), out: [0; 2] };
        let (body, out) = s.split_once("->").ok_or("no outputs")?;
        let node = |w: &str, most: usize| {
            let k: u8 = w.strip_prefix('t').and_then(|w| w.parse().ok()).ok_or(format!("{w}?"))?;
            if (k as usize) < most { Ok(k) } else { Err(format!("{w} is not there yet")) }
        };
        for word in body.split_whitespace() {
            let call = word.split_once('=').ok_or(format!("{word}?"))?.1;
            let (name, rest) = call.split_once('(').ok_or(format!("{word}?"))?;
            let op = OPS.into_iter().find(|o| o.name() == name).ok_or(format!("{name}?"))?;
            let mut args = Vec::new();
            for a in rest.trim_end_matches(')').split(',') {
                args.push(match a {
                    "r" => Arg::Roughness,
                    "m" => Arg::Cos,
                    a if a.starts_with('t') => Arg::Node(node(a, p.nodes.len())?),
                    a => {
                        p.constants.push(a.parse().map_err(|_| format!("{a}?"))?);
                        Arg::Constant((p.constants.len() - 1) as u8)
                    }
                });
            }
            if args.len() != op.arity() {
                return Err(format!("{word} has {} operands", args.len()));
            }
            args.resize(3, args[0]);
            p.nodes.push(Node { op, args: [args[0], args[1], args[2]] });
        }
        let mut outs = out.split_whitespace();
        for o in &mut p.out {
            *o = node(outs.next().ok_or("two outputs")?, p.nodes.len())?;
        }
        Ok(p)
    }
}
