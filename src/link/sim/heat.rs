//! A heater: up at a steady rate, down towards the room as Newton has it.

use std::time::Duration;

use super::Time;

const ROOM_C: f64 = 20.0;
/// Seconds in which the difference to the room falls to 1/e, at factor 1.
const COOLING_S: f64 = 300.0;
/// A temperature counts as reached within this.
const NEAR_C: f64 = 1.0;
/// Who waits longer waits for ever, s: a host may ask for any temperature.
const LONGEST_S: f64 = 1e6;

/// One heater; temperatures in degrees Celsius.
#[derive(Clone, Debug)]
pub(super) struct HeatedMass {
    rate: f64,
    target: f64,
    from: f64,
    since: Time,
}

impl HeatedMass {
    /// Heats `rate` degrees a second.
    pub(super) fn new(rate: f64) -> Self {
        Self { rate, target: 0.0, from: ROOM_C, since: Time::ZERO }
    }

    pub(super) fn target(&self) -> f64 {
        self.target
    }

    pub(super) fn set(&mut self, now: Time, target: f64) {
        self.from = self.at(now);
        self.since = now;
        self.target = target;
    }

    pub(super) fn at(&self, now: Time) -> f64 {
        let t = now.saturating_sub(self.since).as_secs_f64();
        if self.target > self.from {
            return (self.from + self.rate * t).min(self.target);
        }
        let floor = self.target.max(ROOM_C);
        (ROOM_C + (self.from - ROOM_C) * (-t * self.rate / COOLING_S).exp()).max(floor.min(self.from))
    }

    /// When it is within a degree of its target; at once where it only cools.
    pub(super) fn reached(&self, now: Time) -> Time {
        let missing = self.target - NEAR_C - self.at(now);
        if missing <= 0.0 { now } else { now + Duration::from_secs_f64((missing / self.rate).min(LONGEST_S)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heats_steadily_and_cools_towards_the_room() {
        let mut heater = HeatedMass::new(3.0);
        heater.set(Time::ZERO, 200.0);
        assert_eq!(heater.at(Duration::from_secs(30)), 110.0);
        assert!((heater.reached(Duration::from_secs(30)).as_secs_f64() - (30.0 + 89.0 / 3.0)).abs() < 1e-9);
        heater.set(Duration::from_secs(100), 0.0);
        let later = heater.at(Duration::from_secs(200));
        assert!((later - (20.0 + 180.0 * (-1.0_f64).exp())).abs() < 1e-9, "{later}");
        assert!(heater.at(Duration::from_secs(100_000)) >= ROOM_C);
    }

    #[test]
    fn any_temperature_that_a_host_asks_for_has_its_time() {
        let mut heater = HeatedMass::new(3.0);
        for target in [1e25, f64::MAX, f64::INFINITY] {
            heater.set(Time::ZERO, target);
            assert_eq!(heater.reached(Duration::from_secs(1)), Duration::from_secs(1_000_001));
        }
    }
}
