//! The time limit of a packing: it begins with the job, so that reading counts, and keeps back what the exact test takes.

use std::cell::{Cell, RefCell};
use std::time::Duration;

use super::BadPacking;
use crate::pack::{Lift, PackSolid, Put, Room, apart, lift};
use crate::world::World;

/// How much longer than the last test the next one may take.
const LONGER: f64 = 1.25;
/// Tests on the way, at most: of the first packing, and of the first better one.
const REHEARSALS: usize = 2;

/// What the exact test says of a packing: the least distance, and how each run is emptied.
pub(super) type Proof = Result<(Option<f64>, Vec<Lift>), BadPacking>;

/// The clock of a packing.
pub(super) struct Limit<'a> {
    world: &'a World<'a>,
    start: Duration,
    limit: Option<Duration>,
    reserve: Cell<Duration>,
    tests: Cell<usize>,
    /// What tests have taken that were of use.
    tested: Cell<Duration>,
    known: RefCell<Option<(Vec<Put>, Proof)>>,
}

impl<'a> Limit<'a> {
    /// From now on.
    pub(super) fn begin(seconds: Option<f64>, world: &'a World<'a>) -> Self {
        Self {
            world,
            start: world.clock.now(),
            limit: seconds.map(Duration::from_secs_f64),
            reserve: Cell::default(),
            tests: Cell::default(),
            tested: Cell::default(),
            known: RefCell::default(),
        }
    }

    /// Whether there is a limit at all.
    pub(super) fn is_set(&self) -> bool {
        self.limit.is_some()
    }

    pub(super) fn spent(&self) -> Duration {
        self.world.clock.now() - self.start
    }

    /// The share of the time for the search that is spent; 1 and more where it is over. `None` without a limit.
    pub(super) fn share(&self) -> Option<f64> {
        let limit = self.limit?;
        let own = limit.saturating_sub(self.reserve.get());
        Some(self.spent().as_secs_f64() / own.as_secs_f64().max(f64::MIN_POSITIVE))
    }

    /// Tests a packing that was found on the way, to know how long that takes, if there is time left to do so and once more.
    pub(super) fn rehearse(&self, solids: &[PackSolid], room: &Room, put: &[Put]) {
        let twice = self.spent() + 2 * self.reserve.get();
        if self.tests.get() < REHEARSALS && self.limit.is_some_and(|limit| twice < limit) {
            self.proof(solids, room, put);
        }
    }

    /// What the test says of a packing; of the one that was tested last, what it said.
    pub(super) fn proof(&self, solids: &[PackSolid], room: &Room, put: &[Put]) {
        if self.known.borrow().as_ref().is_some_and(|(known, _)| known == put) {
            return;
        }
        let before = self.world.clock.now();
        let clearance = apart(solids, room, put).map_err(|clash| BadPacking::Unproved(clash.to_string()));
        let proof = clearance.map(|clearance| (clearance, lift(solids, room, put)));
        let taken = self.world.clock.now() - before;
        self.tests.set(self.tests.get() + 1);
        self.tested.set(taken);
        self.reserve.set(self.reserve.get().max(taken.mul_f64(LONGER)));
        self.known.replace(Some((put.to_vec(), proof)));
    }

    /// What [`Limit::proof`] said of a packing, and how long the test of it took.
    pub(super) fn proved(&self, solids: &[PackSolid], room: &Room, put: &[Put]) -> (Proof, Duration) {
        self.proof(solids, room, put);
        let known = self.known.take();
        let proof = known.map_or_else(|| Err(BadPacking::Unproved("no packing".to_owned())), |(_, proof)| proof);
        (proof, self.tested.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::solid_box;
    use crate::geom::{Mat3, Vec3};
    use crate::pack::Turns;
    use crate::world::{Clock, Silent};

    /// Each look at it is later by what comes next.
    struct Told(RefCell<Vec<u64>>);

    impl Clock for Told {
        fn now(&self) -> Duration {
            Duration::from_secs(self.0.borrow_mut().remove(0))
        }

        fn sleep(&self, _: Duration) {}

        fn boot(&self) -> String {
            String::new()
        }
    }

    /// A test that takes 4 s of 20 leaves 15 for the search, is not made twice for the same packing, and not where there is no time for it.
    #[test]
    fn the_test_is_kept_back_from_the_time_of_the_search() {
        let solids = [PackSolid::of([&solid_box(Vec3::zeros(), Vec3::repeat(10.0))], 1.0, 1)];
        let room = Room { space_mm: [40.0; 3], gap_mm: 1.0, turns: Turns::None, liftable: false };
        let at = |x| [Put { run: 0, model: 0, copy: 0, turn: Mat3::identity(), shift: Vec3::x() * x }];
        // Begin; share; rehearsal with its test of 4 s; the same again; two shares; a rehearsal that is too late; the last test.
        let clock = Told(RefCell::new(vec![0, 5, 6, 6, 10, 10, 12, 15, 15, 16, 20]));
        let world = World { clock: &clock, ..World::here(&Silent) };
        let limit = Limit::begin(Some(20.0), &world);
        assert_eq!(limit.share(), Some(0.25));
        limit.rehearse(&solids, &room, &at(0.0));
        assert_eq!(limit.reserve.get(), Duration::from_secs(5));
        limit.rehearse(&solids, &room, &at(0.0));
        assert_eq!([limit.share(), limit.share()], [Some(0.8), Some(1.0)]);
        limit.rehearse(&solids, &room, &at(1.0));
        assert_eq!(limit.tests.get(), 1);
        let (proof, taken) = limit.proved(&solids, &room, &at(2.0));
        assert!(proof.is_ok_and(|(clearance, lifts)| clearance.is_none() && lifts.len() == 1));
        assert_eq!((taken, limit.tests.get()), (Duration::from_secs(4), 2));
        assert!(clock.0.borrow().is_empty());
    }

    #[test]
    fn what_is_wrong_is_said_of_the_packing_that_is_asked_for() {
        let solids = [PackSolid::of([&solid_box(Vec3::zeros(), Vec3::repeat(10.0))], 1.0, 1)];
        let room = Room { space_mm: [40.0; 3], gap_mm: 1.0, turns: Turns::None, liftable: false };
        let at = |x| [Put { run: 0, model: 0, copy: 0, turn: Mat3::identity(), shift: Vec3::x() * x }];
        let world = World::here(&Silent);
        let limit = Limit::begin(None, &world);
        assert_eq!((limit.share(), limit.is_set()), (None, false));
        limit.proof(&solids, &room, &at(0.0));
        assert!(limit.proved(&solids, &room, &at(35.0)).0.is_err());
    }
}
