//! Supports: the graph against numbers and code of others, the flows against brute force and OR-tools, the meshes against formulas, what is
//! laid beside what other slicers lay, and the verb.

mod beside;
mod braced;
mod brute;
mod built;
mod judge;
mod outside;
mod printed;
mod random;
mod reference;
mod rivals;
mod scenes;
mod sheets;
mod verb;
