#![doc = include_str!("ARCHITECTURE.md")]

pub mod fixtures;
pub mod geom;
pub mod mesh;
pub mod slicing;
