//! Nothing: a package has to have a target, and its benches are the files beside this one.
