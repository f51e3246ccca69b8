#![doc = include_str!("ARCHITECTURE.md")]

pub mod cli;
pub mod fixtures;
pub mod gcode;
pub mod geom;
pub mod link;
pub mod mesh;
pub mod motion;
pub mod orient;
pub mod planning;
pub mod profile;
pub mod slicing;
pub mod spelling;
pub mod toolpath;
pub mod verify;
