//! Sets of numbers that are joined one after the other, and asked for their root (union-find).

/// Numbers from 0, each at first in a set of its own.
#[derive(Clone, Debug)]
pub struct Sets(Vec<u32>);

impl Sets {
    /// `count` sets of one number.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The number that stands for the set of `at`.
    pub fn root(&mut self, mut at: u32) -> u32 {
        while self.0[at as usize] != at {
            self.0[at as usize] = self.0[self.0[at as usize] as usize];
            at = self.0[at as usize];
        }
        at
    }

    /// The root of both from now on: the one with the lower number.
    pub fn join(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.root(a), self.root(b));
        let (root, other) = (a.min(b), a.max(b));
        self.0[other as usize] = root;
        root
    }

    /// Every number by itself again.
    pub fn reset(&mut self) {
        self.0.iter_mut().enumerate().for_each(|(i, root)| *root = i as u32);
    }
}
