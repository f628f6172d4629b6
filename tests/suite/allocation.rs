//! A step allocates nothing, and ranks share the memory: a counting allocator watches.

use crate::modes::in_processes;
use crate::support::{MIXING, SHARP, box_case, case, petsc};
use mics::scene::Scene;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
    static LARGEST: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: hands every call on to the system's allocator, and counts in a thread-local that itself
// needs no allocation.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|n| n.set(n.get() + 1));
        let _ = LARGEST.try_with(|most| most.set(most.get().max(layout.size())));
        let _ = HELD.try_with(|held| held.set(held.get().wrapping_add(layout.size())));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, data: *mut u8, layout: Layout) {
        let _ = HELD.try_with(|held| held.set(held.get().wrapping_sub(layout.size())));
        unsafe { System.dealloc(data, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Allocations of this thread so far.
pub fn count() -> usize {
    COUNT.get()
}

/// The largest allocation of this thread (bytes) since the last call.
pub fn largest() -> usize {
    LARGEST.replace(0)
}

/// Allocations of this thread in five steps after the first.
fn allocations<const D: usize>(scene: &mut Scene<D>, dt: f64) -> usize {
    scene.step(dt).unwrap();
    let before = count();
    for _ in 0..5 {
        scene.step(dt).unwrap();
    }
    count() - before
}

/// Two and four ranks hold of a scene in 3D what is less by the root of their number at least. What
/// PETSc and MPI take of the system is not theirs to choose, and is not counted.
#[test]
fn bytes_of_a_rank_fall_with_the_number_of_ranks() {
    let test = "allocation::bytes_of_a_rank_fall_with_the_number_of_ranks";
    let said = in_processes(test, &[(1, ""), (2, ""), (4, "")], |session| {
        let text = "name = \"s\"\ndomain = { size = [1.0, 1.0, 1.0], cells = [32, 32, 32] }\n\
            fluid = { density = 1.0, viscosity = 0.01, gravity = [0.0, -1.0, 0.0] }\n\
            boundary = { west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\", \
            bottom = \"wall\", top = \"wall\" }\ntime.end = 1.0\n\
            swarm = [{ count = 8, diameter = 0.25, density = 2.65, \
            region = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 1.0] } }]\n";
        let before = HELD.get();
        let mut scene: Scene<3> = Scene::new(session, &case(text)).unwrap();
        scene.step(1e-3).unwrap();
        let mut held = [(HELD.get() - before) as f64];
        session.max(&mut held).unwrap();
        println!("{} bytes a rank", held[0]);
    });
    let bytes = said.iter().map(|said| {
        // The name of the test may stand before it.
        let line = said.lines().find_map(|line| line.strip_suffix(" bytes a rank"));
        let number = line.and_then(|line| line.rsplit(' ').next()?.parse::<f64>().ok());
        number.unwrap_or_else(|| panic!("{said}"))
    });
    let bytes: Vec<f64> = bytes.collect();
    println!("bytes of each of 1, 2 and 4 ranks: {bytes:?}");
    for (k, held) in bytes.iter().enumerate() {
        assert!(held * f64::sqrt(2.0).powi(k as i32) <= bytes[0], "{bytes:?}");
    }
}

#[test]
fn time_step_allocates_nothing() {
    let petsc = petsc();
    assert!(
        {
            drop(std::hint::black_box(vec![1]));
            count()
        } > 0,
        "the counter counts"
    );
    let varying = "{ inflow = { velocity = [1.0, 0.0], over_time = { time = [0.0, 1.0], factor = \
        [1.0, 2.0] } } }";
    let sides = [varying, "\"outflow\"", "\"periodic\"", "\"periodic\""];
    let moving = "density = 2.65\nviscosity = 0.0\n\
        motion = { prescribed = { velocity = [0.7, 0.4], spin = 1.0 } }";
    let swinging =
        "motion = { prescribed = { oscillation = { amplitude = [0.02, 0.01], frequency = 3.0 } } }";
    for scheme in
        ["scheme = \"rk2\"", "scheme = \"rk3\"", "scheme = \"euler\"\nadvection = \"qsi\""]
    {
        for (body, rule) in [
            ("motion = \"fixed\"", "wall = \"sharp\""),
            (moving, "wall = \"sharp\""),
            (swinging, "wall = \"sharp\""),
            (moving, "wall = \"mixing\""),
            (swinging, "wall = \"mixing\""),
        ] {
            let more = format!(
                "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [0.5, 0.9]\n\
                {body}\n\
                 [coupling]\n{rule}\n[time]\nend = 1.0\n{scheme}"
            );
            let mut scene: Scene<2> =
                petsc.scene(&box_case([2.0, 1.0], [32, 16], 0.01, sides, &more));
            assert_eq!(allocations(&mut scene, 4e-3), 0, "{scheme} {body} {rule}");
        }
    }
    let free = |x: f64, v: f64| {
        format!(
            "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\nposition = [{x:?}, 0.15]\n\
            velocity = [{v:?}, 0.0]\ndensity = 2.65\n"
        )
    };
    let law = "[contact]\nnormal_stiffness = 1.0e2\nfriction = 0.4\n";
    let walls = ["\"wall\"", "\"wall\"", "\"wall\"", "\"slip\""];
    // Viscosity asks for three stages at 0.5 Pa s.
    for (wall, viscosity) in [(SHARP, 0.01), (SHARP, 0.5), (MIXING, 0.01)] {
        let more = [&free(0.5, 0.2), &free(0.8, -0.2), law, wall].concat();
        let text = box_case([2.0, 1.0], [32, 16], viscosity, walls, &more)
            .replace("viscosity", "gravity = [0.0, -1.0]\nviscosity");
        let mut scene: Scene<2> = petsc.scene(&text);
        assert_eq!(allocations(&mut scene, 4e-3), 0, "free particles in contact: {wall}");
        assert!(scene.state.substeps > 1, "they touch: {wall}");
    }
    // Light enough, and of enough cells, that the multigrid takes it in.
    let light = "[[particle]]\nshape = { disc = { diameter = 0.3 } }\nposition = [0.5, 0.3]\n\
        density = 0.5\n";
    let text = box_case([2.0, 1.0], [64, 32], 0.01, walls, &(light.to_owned() + SHARP))
        .replace("viscosity", "gravity = [0.0, -1.0]\nviscosity");
    let mut scene: Scene<2> = petsc.scene(&text);
    assert_eq!(allocations(&mut scene, 2e-3), 0, "a light free particle");
    let mut scene: Scene<3> = petsc.scene(
        "name = \"s\"\n[domain]\nsize = [2.0, 1.0, 1.0]\ncells = [16, 8, 8]\n[fluid]\n\
        density = 1.0\nviscosity = 0.01\n\
         [boundary]\nwest = { inflow = [1.0, 0.0, 0.0] }\neast = \"outflow\"\nsouth = \"slip\"\n\
             north = \"slip\"\n\
         bottom = \"periodic\"\ntop = \"periodic\"\n[[particle]]\n\
             shape = { sphere = { diameter = 0.5 } }\n\
         position = [0.6, 0.5, 0.5]\nmotion = { prescribed = { velocity = [0.1, 0.0, 0.2] } }\n\
         [coupling]\nwall = \"sharp\"\n[time]\nend = 1.0",
    );
    assert_eq!(allocations(&mut scene, 1e-2), 0, "3D");
}
