//! Packing held against brute force, published instances and other programs.

mod boxes;
mod brute;
mod generator;
mod height;
mod models;
mod mpv;
mod outside;
mod shapes;
mod verb;
