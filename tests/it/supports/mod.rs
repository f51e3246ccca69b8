//! Supports: the graph against numbers and code of others, the flows against brute force and OR-tools, the meshes against formulas,
//! and the verb.

mod brute;
mod built;
mod outside;
mod random;
mod reference;
mod scenes;
mod verb;
