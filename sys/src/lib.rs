//! Raw, allow-listed bindings to the installed PETSc (real, 32-bit indices) and its MPI, without
//! logic, of which `mics::petsc` is the one user; and the system's memory in huge pages.
#![allow(non_upper_case_globals, non_camel_case_types, non_snake_case, missing_docs, unsafe_code)]
#![allow(clippy::all)]

mod huge_pages;

pub use huge_pages::HugePages;

include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
