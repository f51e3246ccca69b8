//! The one integration binary: every module is linked once, which is what takes the time on two cores.

mod architecture;
mod cura;
mod kinematics;
mod linuxcnc;
mod rust_source;
mod support;
