//! Packing held against brute force, published instances and other programs.

mod bounds;
mod boxes;
mod brute;
mod generator;
mod height;
mod loading;
mod models;
mod mpv;
mod outside;
mod ratcliff;
mod shapes;
mod verb;
