//! Finds the installed PETSc by pkg-config, refuses a build that does not fit, and generates the
//! bindings.

use std::path::{Path, PathBuf};
use std::{env, fs, process};

const CURE: &str =
    "on Debian 12: apt-get install libpetsc-real-dev libclang-dev pkg-config (or run ci/setup)";

/// Ends the build with one message instead of a panic's backtrace.
fn fail(message: &str) -> ! {
    println!("cargo::error={message}");
    process::exit(1);
}

fn main() {
    println!("cargo::rerun-if-changed=wrapper.h");
    let petsc =
        pkg_config::Config::new().range_version("3.18".."4").probe("PETSc").unwrap_or_else(|e| {
            fail(&format!("PETSc >= 3.18 was not found ({}); {CURE}", first_line(&e.to_string())))
        });
    let mpi = pkg_config::probe_library("mpi-c").unwrap_or_else(|e| {
        fail(&format!("MPI was not found ({}); {CURE}", first_line(&e.to_string())))
    });
    let includes: Vec<PathBuf> =
        petsc.include_paths.iter().chain(&mpi.include_paths).cloned().collect();
    refuse_other_builds(&includes);

    let out =
        PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("bindings.rs");
    bindgen::Builder::default()
        .header("wrapper.h")
        .clang_args(includes.iter().map(|p| format!("-I{}", p.display())))
        .allowlist_function(FUNCTIONS)
        .allowlist_var(VARIABLES)
        .allowlist_type(
            "PetscErrorType|MatOption|MatOperation|InsertMode|DMBoundaryType\
        |DMDAStencilType|DMDAInterpolationType|MatAssemblyType|KSPConvergedReason|PetscBool",
        )
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .generate_comments(false)
        .layout_tests(false)
        .generate()
        .unwrap_or_else(|e| {
            fail(&format!(
                "bindgen could not read PETSc's headers ({e}); is \
            libclang-dev there? {CURE}"
            ))
        })
        .write_to_file(&out)
        .unwrap_or_else(|e| fail(&format!("{}: {e}", out.display())));
}

const FUNCTIONS: &str = "PetscInitialize|PetscFinalize|PetscInitialized|PetscPushErrorHandler\
    |PetscPopSignalHandler\
    |PetscErrorMessage|PetscOptions(HasName|SetValue|ClearValue|LeftGet|LeftRestore|GetAll|Clear)\
    |PetscFree.*|PetscLogStage(Register|Push|Pop|GetId)|PetscGetVersionNumber\
    |PetscObject(Compose|Query)|PetscContainer(Create|SetPointer|GetPointer|Destroy)\
    |DMDACreate[23]d|DMSetUp|DMDestroy|DMDAGetCorners|DMDAGetNeighbors\
    |DMDASetInterpolationType|DMSetMatType|DMCreateMatrix\
    |DMGetLocalToGlobalMapping|ISLocalToGlobalMapping(Get|Restore)Indices|DMCreateGlobalVector\
    |VecDestroy|VecDuplicate|VecNorm|VecAYPX\
    |VecGetArray(Read|Write)?|VecRestoreArray(Read|Write)?|VecSet|MatCreateVecs|MatCreate\
    |MatSetSizes|MatSetType|MatSetUp\
    |MatSetPreallocationCOO|MatSetValuesStencil|MatAssembly(Begin|End)\
    |MatSetValuesCOO|MatSetNullSpace|MatSetOption|MatDestroy|MatMult\
    |MatCreateShell\
    |MatShell(GetContext|SetOperation|SetManageScalingShifts)|MatNullSpace(Create|Destroy|Remove)\
    |KSP(Create|SetDM|SetDMActive\
    |SetOperators|SetFromOptions|SetTolerances|GetTolerances|Solve|GetConvergedReason\
    |GetIterationNumber|GetPC\
    |Destroy|SetInitialGuessNonzero|SetReusePreconditioner|GetType|GetNormType|SetUp\
    |GetResidualNorm|SetResidualHistory|GetResidualHistory|GetInitialGuessNonzero)\
    |PC(Register|SetType|GetOperators|Reset)|PCShellSet(Apply|ApplyTranspose\
    |SetUp|Name)\
    |KSPConvergedReasons|MPI_(Allreduce|Allgatherv|Sendrecv|Isend|Irecv|Waitall|Comm_rank\
    |Comm_size|Gatherv|Bcast|Barrier|Send|Recv)";

const VARIABLES: &str = "PETSC_COMM_WORLD|PETSC_VERSION_.*|ompi_mpi_(double|float|int|byte\
    |comm_world|op_sum|op_max|op_min)\
    |petsc_(allreduce|gather|scatter|isend|send)_ct|petsc_(isend|send)_len|ompi_mpi_(comm_self\
    |comm_null)|KSPConvergedReasons|PetscTrFree";

fn first_line(text: &str) -> &str {
    text.trim().lines().next().unwrap_or("pkg-config failed")
}

/// Complex numbers or 64-bit indices would change every type below: say so instead of failing at a
/// call.
fn refuse_other_builds(includes: &[PathBuf]) {
    let conf =
        includes.iter().map(|p| p.join("petscconf.h")).find(|p| Path::exists(p)).unwrap_or_else(
            || fail(&format!("petscconf.h stands in none of PETSc's include folders; {CURE}")),
        );
    println!("cargo::rerun-if-changed={}", conf.display());
    let text =
        fs::read_to_string(&conf).unwrap_or_else(|e| fail(&format!("{}: {e}", conf.display())));
    let has = |name: &str| text.lines().any(|l| l.split_whitespace().eq(["#define", name, "1"]));
    for (name, what) in
        [("PETSC_USE_COMPLEX", "complex numbers"), ("PETSC_USE_64BIT_INDICES", "64-bit indices")]
    {
        if has(name) {
            fail(&format!(
                "{}: this PETSc was built with {what}; mics needs the real, 32-bit one; {CURE}",
                conf.display()
            ));
        }
    }
    if !has("PETSC_USE_REAL_DOUBLE") {
        fail(&format!(
            "{}: this PETSc does not compute in double precision; {CURE}",
            conf.display()
        ));
    }
}
