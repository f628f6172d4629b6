//! Raw, allow-listed bindings to the installed PETSc (real, 32-bit indices) and its MPI; no logic.
//! `mics::petsc` is the one user.
#![allow(non_upper_case_globals, non_camel_case_types, non_snake_case, missing_docs, unsafe_code)]
#![allow(clippy::all)]

include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
