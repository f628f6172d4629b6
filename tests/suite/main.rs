//! The integration tests: the solver against exact and published solutions, and the program as a stranger meets it.

mod allocation;
mod bad_command;
mod bad_input;
mod balance;
mod boundaries;
mod cavity;
mod convergence;
mod cylinder;
mod folder;
mod fuzz;
mod live;
mod modes;
mod motion;
mod multigrid;
mod plots;
mod poisson;
mod program;
mod ranks;
mod report;
mod restart;
mod rolling;
mod scenes;
mod sharp;
mod study;
mod support;
mod time_order;
