//! The instructions of a function that compute values, one at a time.

use spirq::spirv::{Decoration, GLOp, Op};

use super::arithmetic::{double, f, glsl_one, glsl_three, glsl_two, one, ones, three, two};
use super::builder::{Builder, Value, part_of};
use super::code::{Act, Decoded, Three, Two};

/// One more than the operands of any computation.
const MOST_OPERANDS: usize = 5;
/// Most numbers of one operand: those of a matrix.
const MOST_NUMBERS: usize = 16;

impl Builder<'_> {
    /// Decodes an instruction that neither ends a block nor calls a function.
    pub(super) fn instruction(&mut self, op: Op, operands: &[u32]) -> Decoded<()> {
        let site = self.site(format!("Op{op:?}"));
        if self.memory_instruction(op, operands, site)? || self.group_instruction(op, operands, site)? {
            return Ok(());
        }
        let (ty, id, of) = match (op, operands) {
            (Op::Nop | Op::SelectionMerge | Op::ModuleProcessed, _) => return Ok(()),
            (_, [ty, id, of @ ..]) => (*ty, *id, of),
            _ => return Err(format!("it has Op{op:?}")),
        };
        self.contracts = self.may_contract && self.types.decoration(id, Decoration::NoContraction).is_none();
        let numbers = match op {
            Op::ExtInst => return self.extended(ty, id, of),
            _ => match self.renamed(op, ty, of)? {
                Some(numbers) => numbers,
                None => self.arithmetic(op, ty, of, site)?,
            },
        };
        self.set(id, Value::Numbers(ty, numbers));
        Ok(())
    }

    /// The registers of a value that is made of others without computing anything.
    fn renamed(&mut self, op: Op, ty: u32, of: &[u32]) -> Decoded<Option<Vec<u32>>> {
        Ok(Some(match (op, of) {
            (Op::Undef, _) => self.undefined(ty)?,
            (Op::CopyObject | Op::CopyLogical | Op::Bitcast, [value]) => self.numbers(*value)?,
            (Op::CompositeConstruct, parts) => self.whole(ty, parts)?,
            (Op::CompositeExtract, [value, path @ ..]) => {
                let (of, all) = self.typed(*value)?;
                let (of, first) = self.follow(of, path)?;
                part_of(&all, first, self.types.count(of)?)?
            }
            (Op::CompositeInsert, [part, value, path @ ..]) => {
                let (of, mut all) = self.typed(*value)?;
                let (_, first) = self.follow(of, path)?;
                let part = self.numbers(*part)?;
                part_of(&all, first, part.len() as u32)?;
                all[first..first + part.len()].copy_from_slice(&part);
                all
            }
            (Op::VectorShuffle, [a, b, components @ ..]) => {
                let both = [self.numbers(*a)?, self.numbers(*b)?].concat();
                let undefined = self.number(super::memory::UNDEFINED);
                let pick = |k: &u32| both.get(*k as usize).copied().unwrap_or(undefined);
                components.iter().map(pick).collect()
            }
            (Op::Transpose, [matrix]) => {
                let (of, all) = self.typed(*matrix)?;
                let (columns, rows) = self.sides(of)?;
                let places = (0..rows).flat_map(|row| (0..columns).map(move |column| column * rows + row));
                places.filter_map(|k| all.get(k).copied()).collect()
            }
            _ => return Ok(None),
        }))
    }

    /// Follows indices into a value: the part's type, and its first number.
    fn follow(&self, mut ty: u32, path: &[u32]) -> Decoded<(u32, usize)> {
        let mut first = 0;
        for index in path {
            let (part, before) = self.types.part(ty, *index)?;
            (ty, first) = (part, first + before as usize);
        }
        Ok((ty, first))
    }

    /// How many columns and rows a matrix has.
    fn sides(&self, ty: u32) -> Decoded<(usize, usize)> {
        let (column, _) = self.types.part(ty, 0)?;
        let rows = self.types.count(column)?;
        let columns = self.types.count(ty)?.checked_div(rows).ok_or("it has a matrix without rows")?;
        Ok((columns as usize, rows as usize))
    }

    /// The registers of a value that is computed.
    fn arithmetic(&mut self, op: Op, ty: u32, of: &[u32], site: u32) -> Decoded<Vec<u32>> {
        let all = of.iter().take(MOST_OPERANDS).map(|id| self.typed(*id)).collect::<Decoded<Vec<_>>>()?;
        let list = |k: usize| all.get(k).map(|(_, list)| list.as_slice()).unwrap_or_default();
        let (a, b) = (list(0), list(1));
        if all.iter().any(|(_, list)| list.is_empty()) {
            return Err(format!("it has Op{op:?} of nothing"));
        }
        if all.iter().any(|(_, list)| list.len() > MOST_NUMBERS && op != Op::Select) {
            return Err(format!("it has Op{op:?} of more than a matrix"));
        }
        match (op, all.len()) {
            (Op::VectorTimesScalar | Op::MatrixTimesScalar, 2) => {
                Ok(a.iter().map(|x| self.two(Op::FMul, *x, b[0], site)).collect())
            }
            (Op::Dot, 2) => Ok(vec![self.dot(a, b, site)]),
            (Op::MatrixTimesVector, 2) => Ok(self.times(all[0].0, a, b, site)?),
            (Op::MatrixTimesMatrix, 2) => {
                let (_, rows) = self.sides(all[1].0)?;
                let columns = b.chunks(rows).map(|column| self.times(all[0].0, a, column, site));
                Ok(columns.collect::<Decoded<Vec<_>>>()?.concat())
            }
            (Op::VectorTimesMatrix, 2) => Ok(b.chunks(a.len()).map(|column| self.dot(a, column, site)).collect()),
            (Op::OuterProduct, 2) => {
                let mut products = Vec::new();
                for y in b {
                    products.extend(a.iter().map(|x| self.two(Op::FMul, *x, *y, site)));
                }
                Ok(products)
            }
            (Op::Any, 1) => Ok(vec![self.fold(Op::LogicalOr, a, site)]),
            (Op::All, 1) => Ok(vec![self.fold(Op::LogicalAnd, a, site)]),
            (Op::Select, 3) => {
                let pairs = b.iter().zip(list(2)).enumerate();
                let select = |(k, (yes, no)): (usize, (&u32, &u32))| {
                    let (d, on) = (self.registers(1), a.get(k).unwrap_or(&a[0]));
                    self.act(Act::Select { d, on: *on, yes: *yes, no: *no }, site);
                    d
                };
                Ok(pairs.map(select).collect())
            }
            (Op::VectorExtractDynamic, 2) => Ok(vec![self.pick(a, b[0], site)]),
            (Op::VectorInsertDynamic, 3) => {
                let index = list(2)[0];
                let insert = |(k, old): (u32, &u32)| {
                    let here = self.number(k);
                    let (on, d) = (self.two(Op::IEqual, index, here, site), self.registers(1));
                    self.act(Act::Select { d, on, yes: b[0], no: *old }, site);
                    d
                };
                Ok((0..).zip(a).map(insert).collect())
            }
            (Op::BitFieldInsert, 4) => Ok(self.inserted(a, b, (list(2)[0], list(3)[0]), site)),
            _ => self.by_component(op, ty, &all, site),
        }
    }

    /// What is computed number by number, from one, two or three numbers, with one or two results.
    fn by_component(&mut self, op: Op, ty: u32, all: &[(u32, Vec<u32>)], site: u32) -> Decoded<Vec<u32>> {
        let lists: Vec<&[u32]> = all.iter().map(|(_, list)| list.as_slice()).collect();
        if let (Some(both), [a, b]) = (double(op), &lists[..]) {
            let pairs = || a.iter().zip(*b);
            let results = both.into_iter().flat_map(|f| pairs().map(move |(a, b)| (f, *a, *b)));
            return Ok(results
                .collect::<Vec<_>>()
                .into_iter()
                .map(|(f, a, b)| self.function_of_two(f, a, b, site))
                .collect());
        }
        let count = self.types.count(ty)? as usize;
        // A field's place is one for all components.
        let own = |list: &[u32], k: usize| list.get(k).or(list.first()).copied().unwrap_or_default();
        let mut found = Vec::with_capacity(count);
        for k in 0..count {
            if let (Some(_), [a, b]) = (two(op), &lists[..]) {
                found.push(self.two(op, own(a, k), own(b, k), site));
                continue;
            }
            let d = self.registers(1);
            let act = match (one(op), three(op), &lists[..]) {
                (Some(f), _, [a]) => Act::One { f, d, a: own(a, k) },
                (_, Some(f), [a, b, c]) => Act::Three { f, d, a: own(a, k), b: own(b, k), c: own(c, k) },
                _ => return Err(format!("it has Op{op:?}")),
            };
            self.act(act, site);
            found.push(d);
        }
        Ok(found)
    }

    /// A function of GLSL.std.450.
    fn extended(&mut self, ty: u32, id: u32, of: &[u32]) -> Decoded<()> {
        let [set, number, of @ ..] = of else { return Err("it has OpExtInst without a function".into()) };
        if self.silent.contains(set) {
            return Ok(());
        }
        let function = GLOp::from_u32(*number).filter(|_| *set == self.glsl);
        let function = function.ok_or_else(|| format!("it has function {number} of set %{set}"))?;
        let site = self.site(format!("{function:?}"));
        let all = of.iter().take(MOST_OPERANDS).map(|id| self.numbers(*id)).collect::<Decoded<Vec<_>>>()?;
        let numbers = match (function, &all[..]) {
            (GLOp::Length, [a]) => vec![self.length(a, site)],
            (GLOp::Distance, [a, b]) => {
                let between = self.pairs(Op::FSub, a, b, site);
                vec![self.length(&between, site)]
            }
            (GLOp::Normalize, [a]) => {
                let length = self.length(a, site);
                a.iter().map(|x| self.two(Op::FDiv, *x, length, site)).collect()
            }
            (GLOp::Cross, [a, b]) => self.cross(a, b, site),
            (GLOp::Reflect, [i, n]) => {
                // i - 2 (n . i) n
                let (along, twice) = (self.dot(n, i, site), self.number(2f32.to_bits()));
                let twice = self.two(Op::FMul, twice, along, site);
                let part: Vec<u32> = n.iter().map(|n| self.two(Op::FMul, twice, *n, site)).collect();
                self.pairs(Op::FSub, i, &part, site)
            }
            _ => self.functions_of_numbers(function, ty, &all, site)?,
        };
        self.set(id, Value::Numbers(ty, numbers));
        Ok(())
    }

    fn functions_of_numbers(&mut self, function: GLOp, ty: u32, all: &[Vec<u32>], site: u32) -> Decoded<Vec<u32>> {
        let mut found = Vec::new();
        for k in 0..self.types.count(ty)? as usize {
            let d = self.registers(1);
            let own = |list: &Vec<u32>| list.get(k).copied().ok_or_else(|| format!("{function:?} lacks a component"));
            let act = match (glsl_one(function), glsl_two(function), glsl_three(function), all) {
                (Some(f), _, _, [a]) => Act::One { f, d, a: own(a)? },
                (_, Some(f), _, [a, b]) => Act::Two { f, d, a: own(a)?, b: own(b)? },
                (_, _, Some(f), [a, b, c]) => Act::Three { f, d, a: own(a)?, b: own(b)?, c: own(c)? },
                _ => return Err(format!("it has the function {function:?}")),
            };
            self.act(act, site);
            found.push(d);
        }
        Ok(found)
    }

    /// The register of an operation of two numbers. A sum takes a product in one step where it may.
    fn two(&mut self, op: Op, a: u32, b: u32, site: u32) -> u32 {
        let product = |d: u32| self.products.get(&d).filter(|_| self.contracts).copied();
        let fused: Option<(Three, (u32, u32), u32)> = match (op, product(a), product(b)) {
            (Op::FAdd, Some(of), _) => Some((|x, y, c| f(x).mul_add(f(y), f(c)).to_bits(), of, b)),
            (Op::FAdd, _, Some(of)) => Some((|x, y, c| f(x).mul_add(f(y), f(c)).to_bits(), of, a)),
            (Op::FSub, Some(of), _) => Some((|x, y, c| f(x).mul_add(f(y), -f(c)).to_bits(), of, b)),
            (Op::FSub, _, Some(of)) => Some((|x, y, c| (-f(x)).mul_add(f(y), f(c)).to_bits(), of, a)),
            _ => None,
        };
        let d = match fused {
            Some((f, (a, b), c)) => {
                let d = self.registers(1);
                self.act(Act::Three { f, d, a, b, c }, site);
                d
            }
            None => self.function_of_two(two(op).unwrap_or(|_, _| 0), a, b, site),
        };
        if op == Op::FMul && self.contracts {
            self.products.insert(d, (a, b));
        }
        d
    }

    /// The register of a function of two numbers.
    fn function_of_two(&mut self, f: Two, a: u32, b: u32, site: u32) -> u32 {
        let d = self.registers(1);
        self.act(Act::Two { f, d, a, b }, site);
        d
    }

    fn pairs(&mut self, op: Op, a: &[u32], b: &[u32], site: u32) -> Vec<u32> {
        a.iter().zip(b).map(|(a, b)| self.two(op, *a, *b, site)).collect()
    }

    fn fold(&mut self, op: Op, list: &[u32], site: u32) -> u32 {
        let mut list = list.iter().copied();
        let first = list.next().unwrap_or_default();
        list.fold(first, |sum, x| self.two(op, sum, x, site))
    }

    /// A scalar product: products, and then their sum from the first to the last.
    fn dot(&mut self, a: &[u32], b: &[u32], site: u32) -> u32 {
        let products = self.pairs(Op::FMul, a, b, site);
        self.fold(Op::FAdd, &products, site)
    }

    fn length(&mut self, a: &[u32], site: u32) -> u32 {
        let (square, d) = (self.dot(a, a, site), self.registers(1));
        let f = |a: u32| f32::from_bits(a).sqrt().to_bits();
        self.act(Act::One { f, d, a: square }, site);
        d
    }

    fn cross(&mut self, a: &[u32], b: &[u32], site: u32) -> Vec<u32> {
        let at = |list: &[u32], k: usize| list.get(k % 3).copied().unwrap_or_default();
        let component = |k: usize| {
            let plus = self.two(Op::FMul, at(a, k + 1), at(b, k + 2), site);
            let minus = self.two(Op::FMul, at(a, k + 2), at(b, k + 1), site);
            self.two(Op::FSub, plus, minus, site)
        };
        (0..3).map(component).collect()
    }

    /// A matrix times a vector.
    fn times(&mut self, ty: u32, matrix: &[u32], vector: &[u32], site: u32) -> Decoded<Vec<u32>> {
        let (_, rows) = self.sides(ty)?;
        let row = |row: usize| {
            let own: Vec<u32> = matrix.iter().skip(row).step_by(rows).copied().collect();
            self.dot(&own, vector, site)
        };
        Ok((0..rows).map(row).collect())
    }

    /// The component of a vector at an index.
    fn pick(&mut self, vector: &[u32], index: u32, site: u32) -> u32 {
        let last = vector.last().copied().unwrap_or_default();
        vector.iter().enumerate().rev().skip(1).fold(last, |rest, (k, own)| {
            let here = self.number(k as u32);
            let (on, d) = (self.two(Op::IEqual, index, here, site), self.registers(1));
            self.act(Act::Select { d, on, yes: *own, no: rest }, site);
            d
        })
    }

    /// Numbers with others in a field of bits: its first bit, and its length.
    fn inserted(&mut self, base: &[u32], insert: &[u32], (first, count): (u32, u32), site: u32) -> Vec<u32> {
        let mask = self.function_of_two(|first, count| ones(count).checked_shl(first).unwrap_or(0), first, count, site);
        let one = |(base, insert): (&u32, &u32)| {
            let moved = self.two(Op::ShiftLeftLogical, *insert, first, site);
            let d = self.registers(1);
            let f = |base: u32, moved: u32, mask: u32| base & !mask | moved & mask;
            self.act(Act::Three { f, d, a: *base, b: moved, c: mask }, site);
            d
        };
        base.iter().zip(insert).map(one).collect()
    }
}
