//! The instructions of a function that compute values, one at a time.

use spirq::spirv::{Decoration, GLOp, Op};

use super::arithmetic::{double, f, function, ones, operation};
use super::builder::{Builder, Value, part_of};
use super::code::{Act, Decoded, Function, OfTwo};

/// One more than the operands of any computation.
const MOST_OPERANDS: usize = 5;
/// Most numbers of one operand: those of a matrix.
const MOST_NUMBERS: usize = 16;

impl Builder<'_> {
    /// Decodes an instruction that neither ends a block nor calls a function.
    pub(super) fn instruction(&mut self, op: Op, operands: &[u32]) -> Decoded<()> {
        self.begin(format!("Op{op:?}"));
        if self.memory_instruction(op, operands)? || self.group_instruction(op, operands)? {
            return Ok(());
        }
        let (ty, id, of) = match (op, operands) {
            (Op::Nop | Op::SelectionMerge | Op::ModuleProcessed, _) => return Ok(()),
            (_, [ty, id, of @ ..]) => (*ty, *id, of),
            _ => return Err(format!("it has Op{op:?}")),
        };
        self.contracts = self.may_contract && self.types.decoration(id, Decoration::NoContraction).is_none();
        match op {
            Op::ExtInst => self.extended(ty, id, of),
            _ => {
                let numbers = self.computed(op, ty, of)?;
                self.set(id, Value::Numbers(ty, numbers));
                Ok(())
            }
        }
    }

    /// The registers of the result of an instruction, or of an expression of constants.
    pub(super) fn computed(&mut self, op: Op, ty: u32, of: &[u32]) -> Decoded<Vec<u32>> {
        self.renamed(op, ty, of)?.map_or_else(|| self.arithmetic(op, ty, of), Ok)
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
                let all = self.numbers(*matrix)?;
                let (columns, rows) = self.sides(*matrix)?;
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
    fn sides(&self, id: u32) -> Decoded<(usize, usize)> {
        let (ty, _) = self.typed(id)?;
        let (column, _) = self.types.part(ty, 0)?;
        let rows = self.types.count(column)?;
        let columns = self.types.count(ty)?.checked_div(rows).ok_or("it has a matrix without rows")?;
        Ok((columns as usize, rows as usize))
    }

    /// The registers of a value that is computed.
    fn arithmetic(&mut self, op: Op, ty: u32, of: &[u32]) -> Decoded<Vec<u32>> {
        let all = of.iter().take(MOST_OPERANDS).map(|id| self.numbers(*id)).collect::<Decoded<Vec<_>>>()?;
        if all.iter().any(Vec::is_empty) {
            return Err(format!("it has Op{op:?} of nothing"));
        }
        if all.iter().any(|list| list.len() > MOST_NUMBERS && op != Op::Select) {
            return Err(format!("it has Op{op:?} of more than a matrix"));
        }
        Ok(match (op, &all[..]) {
            (Op::VectorTimesScalar | Op::MatrixTimesScalar, [a, b]) => self.scaled(a, b[0]),
            (Op::Dot, [a, b]) => vec![self.dot(a, b)],
            (Op::MatrixTimesVector, [a, b]) => self.times(self.sides(of[0])?, a, b),
            (Op::MatrixTimesMatrix, [a, b]) => {
                let (sides, (_, rows)) = (self.sides(of[0])?, self.sides(of[1])?);
                b.chunks(rows).flat_map(|column| self.times(sides, a, column)).collect()
            }
            (Op::VectorTimesMatrix, [a, b]) => b.chunks(a.len()).map(|column| self.dot(a, column)).collect(),
            (Op::OuterProduct, [a, b]) => b.iter().flat_map(|y| self.scaled(a, *y)).collect(),
            (Op::Any, [a]) => vec![self.fold(Op::LogicalOr, a)],
            (Op::All, [a]) => vec![self.fold(Op::LogicalAnd, a)],
            (Op::Select, [on, yes, no]) => {
                let on = on.iter().copied().chain(std::iter::repeat(on[0]));
                on.zip(yes.iter().zip(no)).map(|(on, (yes, no))| self.select(on, *yes, *no)).collect()
            }
            (Op::VectorExtractDynamic, [a, index]) => vec![self.pick(a, index[0])],
            (Op::VectorInsertDynamic, [a, new, index]) => {
                let insert = |(k, old): (u32, &u32)| {
                    let on = self.is(index[0], k);
                    self.select(on, new[0], *old)
                };
                (0..).zip(a).map(insert).collect()
            }
            (Op::BitFieldInsert, [base, insert, first, count]) => self.inserted(base, insert, (first[0], count[0])),
            (_, [a, b]) if double(op).is_some() => {
                let results =
                    double(op).into_iter().flatten().flat_map(|f| a.iter().zip(b).map(move |(a, b)| (f, *a, *b)));
                results.map(|(f, a, b)| self.compute(Function::Two(f), [a, b, 0])).collect()
            }
            _ => {
                let f = operation(op).filter(|f| f.depends() == all.len()).ok_or_else(|| format!("it has Op{op:?}"))?;
                self.by_component(ty, &all, |own, of| own.operate(op, f, of))?
            }
        })
    }

    /// What is computed number by number, from one, two or three numbers. A field's place is one for all components.
    fn by_component(
        &mut self,
        ty: u32,
        all: &[Vec<u32>],
        compute: impl Fn(&mut Self, [u32; 3]) -> u32,
    ) -> Decoded<Vec<u32>> {
        let own = |list: &Vec<u32>, k: usize| list.get(k).or(list.first()).copied().unwrap_or_default();
        let of = |k: usize| [0, 1, 2].map(|n| all.get(n).map_or(0, |list| own(list, k)));
        Ok((0..self.types.count(ty)? as usize).map(|k| compute(self, of(k))).collect())
    }

    /// A function of GLSL.std.450.
    fn extended(&mut self, ty: u32, id: u32, of: &[u32]) -> Decoded<()> {
        let [set, number, of @ ..] = of else { return Err("it has OpExtInst without a function".into()) };
        if self.silent.contains(set) {
            return Ok(());
        }
        let what = GLOp::from_u32(*number).filter(|_| *set == self.glsl);
        let what = what.ok_or_else(|| format!("it has function {number} of set %{set}"))?;
        self.begin(format!("{what:?}"));
        let all = of.iter().take(MOST_OPERANDS).map(|id| self.numbers(*id)).collect::<Decoded<Vec<_>>>()?;
        let numbers = match (what, &all[..]) {
            (GLOp::Length, [a]) => vec![self.length(a)],
            (GLOp::Distance, [a, b]) => {
                let between = self.pairs(Op::FSub, a, b);
                vec![self.length(&between)]
            }
            (GLOp::Normalize, [a]) => {
                let length = self.length(a);
                a.iter().map(|x| self.two(Op::FDiv, *x, length)).collect()
            }
            (GLOp::Cross, [a, b]) => self.cross(a, b),
            (GLOp::Reflect, [i, n]) => {
                // i - 2 (n . i) n
                let (along, twice) = (self.dot(n, i), self.number(2f32.to_bits()));
                let twice = self.two(Op::FMul, twice, along);
                let part = self.scaled(n, twice);
                self.pairs(Op::FSub, i, &part)
            }
            _ => {
                let f = function(what).filter(|f| f.depends() == all.len());
                let f = f.ok_or_else(|| format!("it has the function {what:?}"))?;
                self.by_component(ty, &all, |own, of| own.compute(f, of))?
            }
        };
        self.set(id, Value::Numbers(ty, numbers));
        Ok(())
    }

    /// The register of a function of these registers. Outside of functions all numbers are known, and so is its value.
    pub(super) fn compute(&mut self, f: Function, of: [u32; 3]) -> u32 {
        if self.local.is_empty() {
            return self.number(f.value(of.map(|register| self.constant(register).unwrap_or_default())));
        }
        let d = self.registers(1);
        self.act(Act::Compute(f, d, of));
        d
    }

    /// The register of an operation. A sum takes a product in one step where it may.
    fn operate(&mut self, op: Op, function: Function, of: [u32; 3]) -> u32 {
        let [a, b, _] = of;
        let product = |d: u32| self.products.get(&d).filter(|_| self.contracts).copied();
        let plus = Function::Three(|x, y, c| f(x).mul_add(f(y), f(c)).to_bits());
        let (function, of) = match (op, product(a), product(b)) {
            (Op::FAdd, Some((x, y)), _) => (plus, [x, y, b]),
            (Op::FAdd, _, Some((x, y))) => (plus, [x, y, a]),
            (Op::FSub, Some((x, y)), _) => (Function::Three(|x, y, c| f(x).mul_add(f(y), -f(c)).to_bits()), [x, y, b]),
            (Op::FSub, _, Some((x, y))) => {
                (Function::Three(|x, y, c| (-f(x)).mul_add(f(y), f(c)).to_bits()), [x, y, a])
            }
            _ => (function, of),
        };
        let d = self.compute(function, of);
        if op == Op::FMul && self.contracts {
            self.products.insert(d, (a, b));
        }
        d
    }

    fn two(&mut self, op: Op, a: u32, b: u32) -> u32 {
        self.operate(op, operation(op).unwrap_or(Function::Two(|_, _| 0)), [a, b, 0])
    }

    fn select(&mut self, on: u32, yes: u32, no: u32) -> u32 {
        self.compute(Function::Select, [on, yes, no])
    }

    /// Whether an index is this number.
    fn is(&mut self, index: u32, number: u32) -> u32 {
        let number = self.number(number);
        self.two(Op::IEqual, index, number)
    }

    fn pairs(&mut self, op: Op, a: &[u32], b: &[u32]) -> Vec<u32> {
        a.iter().zip(b).map(|(a, b)| self.two(op, *a, *b)).collect()
    }

    fn scaled(&mut self, a: &[u32], by: u32) -> Vec<u32> {
        a.iter().map(|x| self.two(Op::FMul, *x, by)).collect()
    }

    fn fold(&mut self, op: Op, list: &[u32]) -> u32 {
        list.iter().copied().reduce(|sum, x| self.two(op, sum, x)).unwrap_or_default()
    }

    /// A scalar product: products, and then their sum from the first to the last.
    fn dot(&mut self, a: &[u32], b: &[u32]) -> u32 {
        let products = self.pairs(Op::FMul, a, b);
        self.fold(Op::FAdd, &products)
    }

    fn length(&mut self, a: &[u32]) -> u32 {
        let square = self.dot(a, a);
        self.compute(Function::One(|a| f(a).sqrt().to_bits()), [square, 0, 0])
    }

    fn cross(&mut self, a: &[u32], b: &[u32]) -> Vec<u32> {
        let at = |list: &[u32], k: usize| list.get(k % 3).copied().unwrap_or_default();
        let component = |k: usize| {
            let plus = self.two(Op::FMul, at(a, k + 1), at(b, k + 2));
            let minus = self.two(Op::FMul, at(a, k + 2), at(b, k + 1));
            self.two(Op::FSub, plus, minus)
        };
        (0..3).map(component).collect()
    }

    /// A matrix of so many columns and rows times a vector.
    fn times(&mut self, (_, rows): (usize, usize), matrix: &[u32], vector: &[u32]) -> Vec<u32> {
        let row = |row: usize| {
            let own: Vec<u32> = matrix.iter().skip(row).step_by(rows).copied().collect();
            self.dot(&own, vector)
        };
        (0..rows).map(row).collect()
    }

    /// The component of a vector at an index.
    fn pick(&mut self, vector: &[u32], index: u32) -> u32 {
        let last = vector.last().copied().unwrap_or_default();
        (0..vector.len() as u32).zip(vector).rev().skip(1).fold(last, |rest, (k, own)| {
            let on = self.is(index, k);
            self.select(on, *own, rest)
        })
    }

    /// Numbers with others in a field of bits: its first bit, and its length.
    fn inserted(&mut self, base: &[u32], insert: &[u32], (first, count): (u32, u32)) -> Vec<u32> {
        let mask: OfTwo = |first, count| ones(count).checked_shl(first).unwrap_or(0);
        let mask = self.compute(Function::Two(mask), [first, count, 0]);
        let one = |(base, insert): (&u32, &u32)| {
            let moved = self.two(Op::ShiftLeftLogical, *insert, first);
            self.compute(Function::Three(|base, moved, mask| base & !mask | moved & mask), [*base, moved, mask])
        };
        base.iter().zip(insert).map(one).collect()
    }
}
