//! What invocations of a subgroup exchange: of those that are at the instruction, in their order.

use super::code::{Among, Exchange, Team};
use super::run::Group;

impl Group<'_, '_, '_> {
    /// Executes an operation of subgroups for these invocations of the group.
    pub(super) fn exchange(&mut self, team: &Team, at: u32, lanes: &[u16]) {
        let size = self.launch.subgroup as u16;
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
        let size = self.launch.subgroup as u16;
        let whole = lanes.len() == usize::from(size.min(self.lanes as u16 - first));
        if !whole && !matches!(team.kind, Exchange::Take(_)) {
            self.watch.iter_mut().for_each(|watch| watch.parted(lanes[0], at));
        }
        let value = |group: &Self, lane: u16| group.get(team.a[0], lane);
        let ballot = |group: &Self, lane: u16| [0, 1, 2, 3].map(|k| team.a.get(k).map_or(0, |r| group.get(*r, lane)));
        let results: Vec<[u32; 4]> = lanes
            .iter()
            .enumerate()
            .map(|(k, lane)| {
                let operand = team.b.map(|register| self.get(register, *lane));
                let own = u32::from(lane - first);
                let one = |value: u32| [value, 0, 0, 0];
                match team.kind {
                    Exchange::Take(from) => {
                        let from = from(own, operand.unwrap_or_default());
                        let there = u16::try_from(from).ok().and_then(|from| first.checked_add(from));
                        let there = there.filter(|there| from < u32::from(size) && lanes.binary_search(there).is_ok());
                        if there.is_none() {
                            self.watch.iter_mut().for_each(|watch| watch.absent(*lane, from, at));
                        }
                        one(value(self, there.unwrap_or(*lane)))
                    }
                    Exchange::First => one(value(self, lanes[0])),
                    Exchange::Elect => one(u32::from(k == 0)),
                    Exchange::All => one(lanes.iter().all(|lane| value(self, *lane) != 0).into()),
                    Exchange::Any => one(lanes.iter().any(|lane| value(self, *lane) != 0).into()),
                    Exchange::Equal => {
                        let same = |lane: &u16| team.a.iter().all(|r| self.get(*r, *lane) == self.get(*r, lanes[0]));
                        one(lanes.iter().all(same).into())
                    }
                    Exchange::Ballot => {
                        lanes.iter().filter(|lane| value(self, **lane) != 0).fold([0; 4], |mut all, lane| {
                            let bit = usize::from(lane - first);
                            all[bit / 32 % 4] |= 1 << (bit % 32);
                            all
                        })
                    }
                    Exchange::Bit => {
                        let bit = operand.unwrap_or(own);
                        one(ballot(self, *lane)[bit as usize / 32 % 4] >> (bit % 32) & 1)
                    }
                    Exchange::Count(among) => {
                        let bits = bits(ballot(self, *lane), u32::from(size));
                        one(bits.filter(|bit| counts(among, own, *bit)).count() as u32)
                    }
                    Exchange::Lowest => one(bits(ballot(self, *lane), u32::from(size)).next().unwrap_or(u32::MAX)),
                    Exchange::Highest => one(bits(ballot(self, *lane), u32::from(size)).last().unwrap_or(u32::MAX)),
                    Exchange::Fold(f, start, among) => {
                        let others = lanes.iter().filter(|other| counts(among, own, u32::from(*other - first)));
                        one(others.fold(start, |sum, other| f(sum, value(self, *other))))
                    }
                }
            })
            .collect();
        for (lane, result) in lanes.iter().zip(results) {
            for (d, word) in team.d.iter().zip(result) {
                self.set(*d, *lane, word);
            }
        }
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
