//! What invocations of a subgroup exchange: of those that are at the instruction, in their order.

use super::code::{Among, Exchange, Team};
use super::memory::is_undefined;
use super::run::Group;

impl Group<'_, '_, '_> {
    /// Executes an operation of subgroups for these invocations of the group.
    pub(super) fn exchange(&mut self, team: &Team, at: u32, lanes: &[u16]) {
        let size = self.launch.asked.subgroup as u16;
        let mut rest = lanes;
        while let Some(first) = rest.first() {
            let number = first / size;
            let count = rest.iter().take_while(|lane| *lane / size == number).count();
            let (own, after) = rest.split_at(count);
            self.in_subgroup(team, at, own, number * size);
            rest = after;
        }
    }

    /// The same for those of one subgroup, whose first invocation has this number in the group.
    fn in_subgroup(&mut self, team: &Team, at: u32, lanes: &[u16], first: u16) {
        let size = self.launch.asked.subgroup as u16;
        let whole = lanes.len() == usize::from(size.min(self.lanes as u16 - first));
        if !whole && !matches!(team.kind, Exchange::Take(_)) {
            let does = "is at an operation of its subgroup without others";
            self.watch.iter_mut().for_each(|watch| watch.diverges(lanes[0], at, |_| does.into()));
        }
        let results: Vec<[u32; 4]> = lanes.iter().map(|lane| self.result(team, at, *lane, (lanes, first))).collect();
        for (lane, result) in lanes.iter().zip(results) {
            for (d, word) in team.d.iter().zip(result) {
                self.set(*d, *lane, word);
            }
        }
    }

    /// What an invocation gets.
    fn result(&mut self, team: &Team, at: u32, lane: u16, (lanes, first): (&[u16], u16)) -> [u32; 4] {
        let size = self.launch.asked.subgroup;
        let own = u32::from(lane - first);
        let operand = team.b.map(|register| self.get(register, lane));
        if let Exchange::Take(from) = team.kind {
            let from = from(own, operand.unwrap_or_default());
            let there = u16::try_from(from).ok().and_then(|from| first.checked_add(from));
            let there = there.filter(|there| from < size && lanes.binary_search(there).is_ok());
            if there.is_none() {
                let does = format!("takes a value from lane {from} of its subgroup, which is not there");
                self.watch.iter_mut().for_each(|watch| watch.diverges(lane, at, |_| does.clone()));
            }
            return [self.get(team.a[0], there.unwrap_or(lane)), 0, 0, 0];
        }
        let value = |lane: &u16| team.a.first().map_or(0, |register| self.get(*register, *lane));
        let ballot = [0, 1, 2, 3].map(|k| team.a.get(k).map_or(0, |register| self.get(*register, lane)));
        let one = match team.kind {
            Exchange::Take(_) | Exchange::First => value(&lanes[0]),
            Exchange::Elect => u32::from(lane == lanes[0]),
            Exchange::All => lanes.iter().all(|lane| value(lane) != 0).into(),
            Exchange::Any => lanes.iter().any(|lane| value(lane) != 0).into(),
            Exchange::Equal => {
                let same = |lane: &u16| team.a.iter().all(|r| self.get(*r, *lane) == self.get(*r, lanes[0]));
                lanes.iter().all(same).into()
            }
            Exchange::Ballot => {
                let mut all = [0; 4];
                for lane in lanes.iter().filter(|lane| value(lane) != 0) {
                    let bit = usize::from(lane - first);
                    all[bit / 32 % 4] |= 1 << (bit % 32);
                }
                return all;
            }
            Exchange::Bit => {
                let bit = operand.unwrap_or(own);
                ballot[bit as usize / 32 % 4] >> (bit % 32) & 1
            }
            Exchange::Count(among) => bits(ballot, size).filter(|bit| counts(among, own, *bit)).count() as u32,
            Exchange::Lowest => bits(ballot, size).next().unwrap_or(u32::MAX),
            Exchange::Highest => bits(ballot, size).last().unwrap_or(u32::MAX),
            Exchange::Fold(f, start, among) => {
                let others = lanes.iter().filter(|other| counts(among, own, u32::from(*other - first)));
                let watched = self.watch.is_some();
                others.map(value).fold(start, |sum, value| match [sum, value].into_iter().find(|v| is_undefined(*v)) {
                    Some(none) if watched => none,
                    _ => f(sum, value),
                })
            }
        };
        [one, 0, 0, 0]
    }
}

/// Whether an invocation's value counts for another one.
fn counts(among: Among, own: u32, other: u32) -> bool {
    match among {
        Among::All => true,
        Among::UpToOwn => other <= own,
        Among::BeforeOwn => other < own,
        Among::Run(size) => other / size == own / size,
    }
}

/// The bits of a ballot that are set, for a subgroup of this size.
fn bits(ballot: [u32; 4], size: u32) -> impl DoubleEndedIterator<Item = u32> {
    (0..size.min(128)).filter(move |bit| ballot[*bit as usize / 32] >> (bit % 32) & 1 == 1)
}
