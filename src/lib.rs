#![doc = include_str!("ARCHITECTURE.md")]

pub mod geom;
pub mod mesh;
pub mod slicing;
