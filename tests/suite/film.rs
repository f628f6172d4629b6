//! `mics film`: frames and their timing read back from the animated PNG, strips, and what is
//! refused.

use crate::plots::{FALL, fall};
use crate::support::{mics, run};
use std::fs::{self, File};
use std::path::Path;

/// An animated picture as its reader finds it.
struct Film {
    size: [u32; 2],
    /// Colours as the numbers that the file has, of every frame whole.
    frames: Vec<Vec<u8>>,
    /// Seconds a frame.
    delays: Vec<f64>,
    /// Right end of what differs between a frame and the one before, of all frames (pixels).
    changed: u32,
}

fn read(path: &str) -> Film {
    let mut reader = png::Decoder::new(File::open(path).unwrap()).read_info().unwrap();
    let (size, count) =
        (reader.info().size(), reader.info().animation_control().unwrap().num_frames);
    assert_eq!(reader.info().animation_control().unwrap().num_plays, 0, "it repeats for ever");
    let (width, mut canvas) = (size.0 as usize, vec![0; (size.0 * size.1) as usize]);
    let mut film = Film { size: size.into(), frames: Vec::new(), delays: Vec::new(), changed: 0 };
    for k in 0..count {
        let mut buffer = vec![0; reader.output_buffer_size()];
        let shape = reader.next_frame(&mut buffer).unwrap();
        let control = *reader.info().frame_control().unwrap();
        for (j, row) in buffer[..shape.buffer_size()].chunks_exact(shape.line_size).enumerate() {
            let from = (control.y_offset as usize + j) * width + control.x_offset as usize;
            canvas[from..from + row.len()].copy_from_slice(row);
        }
        film.changed = if k == 0 { 0 } else { film.changed.max(control.x_offset + control.width) };
        film.frames.push(canvas.clone());
        film.delays.push(f64::from(control.delay_num) / f64::from(control.delay_den));
    }
    assert!(reader.next_frame(&mut vec![0; canvas.len()]).is_err(), "there are no more frames");
    film
}

/// The files that `mics film` lists.
fn filmed(words: &[&str]) -> Vec<String> {
    let output = mics(&[&["film"], words].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// The files of a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn film_has_one_frame_per_snapshot_and_strip_a_selection() {
    let dir = tempfile::tempdir().unwrap();
    let a = fall(dir.path(), "a", &[]);
    let path = filmed(&[&a]);
    assert_eq!(path, [format!("{a}/figures/vorticity_film.png")]);
    let film = read(&path[0]);
    assert_eq!((film.frames.len(), film.delays), (7, vec![0.1; 7]));
    assert!(
        film.frames.windows(2).all(|pair| pair[0] != pair[1]) && film.frames[0] != film.frames[6]
    );
    // The flow is 400 x 600; right of it is the bar, which does not change.
    let [width, height] = film.size;
    assert!((500..700).contains(&width) && (650..800).contains(&height), "{width} x {height}");
    assert!(film.changed + 80 < width, "{} of {width}", film.changed);

    // In a folder that is not there yet.
    let part = dir.path().join("films/part.apng");
    let out = part.to_str().unwrap();
    let words =
        ["--from", "0.1", "--to", "0.2", "--fps", "12.5", "--size", "200", "--field", "speed"];
    assert_eq!(
        filmed(&[&[&a[..]], &words[..], &["--bodies", "speed", "--out", out]].concat()),
        [out]
    );
    let film = read(out);
    assert_eq!((film.frames.len(), film.delays), (3, vec![0.08; 3]));
    assert!(film.size[1] < height / 2 + 10);

    let out = dir.path().join("strip.png");
    let strip = filmed(&[
        &a,
        "--strip",
        "3",
        "--field",
        "pressure",
        "--size",
        "800",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(strip, ["png", "svg"].map(|end| format!("{}/strip.{end}", dir.path().display())));
    let reader = png::Decoder::new(File::open(&strip[0]).unwrap()).read_info().unwrap();
    assert!(reader.info().animation_control().is_none());
    let (width, height) = reader.info().size();
    assert!((900..1150).contains(&width) && (480..640).contains(&height), "{width} x {height}");
    let svg = fs::read_to_string(&strip[1]).unwrap();
    let said = ["(a) t = 0.0", "(b) t = 0.1", "(c) t = 0.3", "fall: pressure", "pressure (Pa)"];
    said.iter().for_each(|label| assert!(svg.contains(label), "{label}"));
    assert!(!svg.contains("(d)"));

    refusals(&a, dir.path());
    damage(&a);
}

/// Nothing is written where a film is refused.
fn refusals(a: &str, dir: &Path) {
    let before = names(&Path::new(a).join("figures"));
    let [gif, webp] =
        ["film.gif", "film.webp"].map(|name| dir.join(name).to_str().unwrap().to_owned());
    let (gif, webp) = (&gif[..], &webp[..]);
    for (words, said) in [
        (&["--field", "vortices"][..], &["'vortices'", "vorticity", "pressure"][..]),
        (&["--bodies", "colour"], &["'colour'", "material"]),
        (&["--from", "3"], &["--from 3", "0 of the 7 snapshots", "from 0 to 0.3", "every_time = "]),
        (&["--to", "-1"], &["--to -1", "0 of the 7 snapshots"]),
        (
            &["--from", "0.11", "--to", "0.12"],
            &["--from 0.11", "--to 0.12", "1 of the 7 snapshots", "needs two"],
        ),
        (&["--from", "0.2", "--to", "0.1"], &["--from 0.2 --to 0.1", "ends after it begins"]),
        (&["--from", "nan"], &["--from NaN", "number of seconds"]),
        (&["--fps", "0"], &["--fps 0", "0.1 to 100"]),
        (&["--strip", "1"], &["--strip 1", "mics plot --figure field"]),
        (&["--strip", "9"], &["--strip 9", "7 snapshots", "every_time = 0.01"]),
        (&["--strip", "3", "--fps", "5"], &["--strip", "--fps"]),
        (&["--out", webp], &["film.webp", "animated PNG or GIF", "film.png"]),
        (&["--strip", "3", "--out", gif], &["film.gif", "strips PNG"]),
        (&["--plane", "z=0.1"], &["--plane z=0.1", "in 2D"]),
        (&["--window", "2,3,2,3"], &["--window", "0.1 m x 0.15 m"]),
        (&["--range", "1"], &["--range [1.0]", "the lower one first"]),
        (&["--size", "20000"], &["--size 20000", "60 to 4000"]),
    ] {
        let output = mics(&[&["film", a], words].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
        assert!(said.iter().all(|part| message.contains(part)), "{words:?}: {message}");
    }
    assert_eq!(names(&Path::new(a).join("figures")), before);
    assert!(!Path::new(gif).exists() && !Path::new(webp).exists());
}

#[test]
fn film_as_gif_has_the_same_frames() {
    let dir = tempfile::tempdir().unwrap();
    let a = fall(dir.path(), "a", &[]);
    let out = dir.path().join("film.gif");
    let out = out.to_str().unwrap();
    assert_eq!(filmed(&[&a, "--fps", "12.5", "--size", "200", "--out", out]), [out]);
    let as_png = dir.path().join("film.png");
    filmed(&[&a, "--size", "200", "--out", as_png.to_str().unwrap()]);
    let film = read(as_png.to_str().unwrap());
    let mut reader = gif::DecodeOptions::new().read_info(File::open(out).unwrap()).unwrap();
    let size = [reader.width(), reader.height()].map(u32::from);
    assert_eq!((size, reader.repeat()), (film.size, gif::Repeat::Infinite));
    let (width, mut canvas, mut count) =
        (size[0] as usize, vec![0; (size[0] * size[1]) as usize], 0);
    while let Some(frame) = reader.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 8, "hundredths of a second");
        for (j, row) in frame.buffer.chunks_exact(usize::from(frame.width)).enumerate() {
            let from = (usize::from(frame.top) + j) * width + usize::from(frame.left);
            canvas[from..from + row.len()].copy_from_slice(row);
        }
        assert!(canvas == film.frames[count], "frame {count}");
        count += 1;
    }
    assert_eq!(count, 7);
}

/// A film that fails on its way leaves no half of it, and the one before as it was; one snapshot is
/// no film.
fn damage(a: &str) {
    let (figures, fields) = (Path::new(a).join("figures"), Path::new(a).join("fields"));
    let film = fs::read(figures.join("vorticity_film.png")).unwrap();
    let snapshots: Vec<String> =
        names(&fields).into_iter().filter(|name| name.ends_with(".vti")).collect();
    let bytes = fs::read(fields.join(&snapshots[3])).unwrap();
    fs::write(fields.join(&snapshots[3]), &bytes[..bytes.len() / 2]).unwrap();
    // With its range it does not look at all frames before it begins.
    let output = mics(&["film", a, "--range=-20,20"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(2) && message.contains("not a snapshot that mics wrote"),
        "{message}"
    );
    assert_eq!(names(&figures), ["vorticity_film.png"]);
    assert!(fs::read(figures.join("vorticity_film.png")).unwrap() == film);

    snapshots[1..].iter().for_each(|name| fs::remove_file(fields.join(name)).unwrap());
    let output = mics(&["film", a]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    let cure = "output.fields = { every_time = 0.01 }, about 30 frames of its 0.3 s, as in --set \
        output.fields.every_time=0.01";
    assert!(message.contains("one snapshot only") && message.contains(cure), "{message}");
}

#[test]
fn film_in_3d_shows_figure_planes_and_given_planes() {
    let dir = tempfile::tempdir().unwrap();
    let case = FALL
        .replace(
            "size = [0.1, 0.15], cells = [40, 60]",
            "size = [0.06, 0.09, 0.06], cells = [12, 18, 12]",
        )
        .replace("gravity = [0.0, -9.81]", "gravity = [0.0, -9.81, 0.0]")
        .replace("north = \"slip\"", "north = \"slip\", bottom = \"wall\", top = \"wall\"")
        .replace("disc = ", "sphere = ")
        .replace("position = [0.015, 0.1]", "position = [0.02, 0.05, 0.03]")
        .replace("end = 0.3", "end = 0.1")
        .replace("figures = false", "figures = false, planes = [{ z = 0.03 }, { x = 0.02 }]");
    let (file, out) = (dir.path().join("fall.toml"), dir.path().join("run"));
    fs::write(&file, case).unwrap();
    run(&file, &out, &[]);
    let folder = out.to_str().unwrap();
    let paths = filmed(&[folder, "--size", "200"]);
    assert_eq!(
        paths,
        ["_2", ""].map(|number| format!("{folder}/figures/vorticity_film{number}.png"))
    );
    let films = [read(&paths[0]), read(&paths[1])];
    assert!(films.iter().all(|film| film.frames.len() == 3 && film.frames[0] != film.frames[2]));
    let one = filmed(&[
        folder, "--plane", "y=0.04", "--field", "speed", "--size", "200", "--bodies", "material",
    ]);
    assert_eq!(one, [format!("{folder}/figures/speed_film.png")]);
    // The bodies' places are in files of their own.
    fs::remove_file(out.join("fields/bodies.pvd")).unwrap();
    let output = mics(&["film", folder]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("fields/bodies.pvd is missing"));
}
