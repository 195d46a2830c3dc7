use super::*;
use crate::{Display, DisplayObserver, Engine, Finish, RenderThread};
use fbptr_command::{ErrorMode, LightCommand, MeshSource, Quality, Verb};
use fbptr_core::draw2d::{self, Blend};
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Cull, HiddenSurface, Interpolation, Material, ObliqueKind, Projection, Sampling, ShadeMode,
    ViewportRule,
};
use glam::{DMat4, DVec3};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

const RED: [u8; 4] = [255, 0, 0, 255];

/// Returns the name of a projection's verb as `Command::verb` gives it, for all of them.
fn projections() -> Vec<Projection> {
    let (window, near, far) = ([-1.0, 1.0, -1.0, 1.0], 1.0, 9.0);
    let [vrp, p, vup] = [DVec3::ZERO, DVec3::Z, DVec3::Y];
    vec![
        Camera::default().projection,
        Projection::Plane { d: 1.0, near, far },
        Projection::Frustum { window, near, far },
        Projection::Ortho { window, near, far },
        Projection::Oblique { kind: ObliqueKind::Cabinet, angle_rad: 0.5, window, near, far },
        Projection::Isometric { window, near, far },
        Projection::PseudoIsometric { window, near, far },
        Projection::Window { vrp, p, vup, center: [0.0; 2], half: [1.0; 2], dp: 1.0, near, far },
    ]
}

/// Calls every method that queues a command.
fn send_all(client: &Client) {
    let name = "a";
    client.clear(RED);
    client.put_pixel(0, 0, RED);
    client.binary_pixel(0, 0, RED);
    client.pixel_run(0, 0, vec![0; 4]);
    client.offset(0, 0);
    client.poke(0, vec![0]);
    client.blit([0, 0, 1, 1], vec![0; 4]);
    client.copy([0, 0, 1, 1], [1, 1]);
    client.points(vec![0; 8]);
    client.line([0, 0], [1, 1], [RED; 2]);
    client.line_aa([0.0; 2], [1.0; 2], RED);
    client.triangle([[0, 0], [1, 0], [0, 1]], RED);
    client.fill([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [RED; 3]);
    client.rect([0, 0, 1, 1], RED);
    client.fill_rect([0.5, 0.0, 1.0, 1.0], RED);
    client.circle([0, 0], 1, RED);
    client.fill_circle([0.0; 2], 1.0, RED);
    client.poly(vec![[0, 0], [1, 1]], RED);
    client.fill_poly(vec![[0.0; 2], [1.0; 2]], RED);
    client.text([0, 0], "a", RED);
    client.blend(Blend::Replace);
    send_surfaces_and_curves(client, name);
    client.mesh(name, MeshSource::Sphere(1.0));
    client.texture(name, Vec::new());
    client.scene(Vec::new());
    client.eye(name, Vec::new());
    client.load_mesh(name, "a.obj");
    client.free(name);
    client.draw(name);
    client.draw_scene(0.0, false);
    client.draw_eye(name, [0, 0, 1, 1]);
    client.look_at([0.0, 0.0, 5.0], [0.0; 3], DVec3::Y);
    projections().into_iter().for_each(|projection| client.projection(projection));
    client.viewport([0, 0, 8, 6], ViewportRule::Corners);
    client.identity();
    client.push();
    client.pop();
    client.translate([1.0, 0.0, 0.0]);
    client.rotate(DVec3::Z, 1.0);
    client.scale([1.0; 3]);
    client.shear([0.0; 6]);
    client.matrix(DMat4::IDENTITY);
    client.ambient([1.0; 3]);
    client.light(0, LightCommand::Off);
    client.material(Material::default());
    client.use_texture(None, Sampling::default());
    client.shade(ShadeMode::Flat);
    client.cull(Cull::None);
    client.hide(HiddenSurface::ZBuffer);
    client.depth_format(DepthFormat::U16);
    client.interpolation(Interpolation::Affine);
    client.quality(Quality::Exact);
    client.auto(true);
    client.subscribe(true);
    client.error_mode(ErrorMode::Count);
}

/// Calls the methods of curves, text, canvases and the window.
fn send_surfaces_and_curves(client: &Client, name: &str) {
    client.print([0, 0], "a", RED);
    client.text_size(2);
    client.wide_line([0.0; 2], [1.0; 2], 1.0, RED);
    client.ellipse([0.0; 2], [1.0; 2], RED);
    client.fill_ellipse([0.0; 2], [1.0; 2], RED);
    client.arc(draw2d::Arc { center: [0.0; 2], radii: [0.0, 1.0], angles: [0.0, 1.0] }, RED);
    client.bezier([[0.0; 2]; 4], 1.0, RED);
    client.image([0, 0], Vec::new());
    client.clip(None);
    client.canvas(name, 1, 1);
    client.target(None);
    client.stamp(name, [0, 0], None);
    client.title(name);
    client.pause(0.0);
}

/// Calls every method that waits for a reply, and returns how many returned one.
fn ask_all(client: &Client) -> usize {
    [
        client.size().is_ok(),
        client.get_pixel(0, 0).is_ok(),
        client.peek(0, 4).is_ok(),
        client.read([0, 0, 1, 1]).is_ok(),
        client.crc().is_ok(),
        client.depth_at(0, 0).is_ok(),
        client.pick(0, 0).is_ok(),
        client.help().is_ok(),
        client.stats().is_ok(),
        client.hello().is_ok(),
        client.version().is_ok(),
        client.snap_png().is_ok(),
        client.present().is_ok(),
        client.sync().is_ok(),
    ]
    .map(usize::from)
    .iter()
    .sum()
}

#[test]
fn every_verb_has_a_method() {
    let (messages, received) = crossbeam_channel::unbounded();
    let inbox = Arc::new(Inbox::default());
    let client = Client::new(1, messages, inbox.clone());
    let caller = std::thread::spawn(move || {
        send_all(&client);
        assert_eq!(ask_all(&client), 0, "there is no render thread");
        client.quit();
    });
    let (mut verbs, mut items) = (BTreeSet::new(), Vec::new());
    while let Ok(message) = received.recv() {
        if matches!(message, Message::Mail(_) | Message::End(..)) {
            inbox.take(&mut items);
        }
        for item in items.drain(..) {
            if let Item::Command(command) | Item::Ask(command, _) = item {
                verbs.insert(command.verb());
            }
        }
    }
    caller.join().expect("no method panics");
    verbs.extend(super::verbs::made_methods());
    let table: BTreeSet<_> = Verb::all().iter().map(|verb| verb.name).collect();
    let missing: Vec<_> = table.difference(&verbs).collect();
    assert!(missing.is_empty(), "verbs without a method: {missing:?}");
}

#[test]
fn a_pause_holds_its_own_connection_where_there_is_a_display() {
    let display = Display::new(8, 6);
    let mut engine = Engine::new(8, 6).unwrap();
    engine.attach(DisplayObserver::new(display.clone()));
    let thread = RenderThread::start(engine).unwrap();
    let (slow, other) = (thread.client(), thread.client());
    let begun = Instant::now();
    slow.title("a title");
    slow.pause(0.3);
    slow.put_pixel(1, 1, RED);
    slow.sync().unwrap();
    assert!(begun.elapsed() >= Duration::from_millis(300));
    assert_eq!(display.take_title().as_deref(), Some("a title"));
    slow.put_pixel(2, 2, RED);
    slow.pause(60.0);
    slow.put_pixel(3, 3, RED);
    while other.get_pixel(2, 2).unwrap() != RED {}
    assert_eq!(other.get_pixel(3, 3).unwrap(), [0, 0, 0, 255], "it pauses, and others go on");
    thread.finish(Finish::Now);
}

#[test]
fn nobody_pauses_without_a_display() {
    let thread = RenderThread::start(Engine::new(8, 6).unwrap()).unwrap();
    let client = thread.client();
    (0..60).for_each(|_| client.pause(60.0));
    client.put_pixel(1, 1, RED);
    assert_eq!(client.get_pixel(1, 1).unwrap(), RED);
    thread.finish(Finish::Now);
}

#[test]
fn replies_are_values() {
    let thread = RenderThread::start(Engine::new(8, 6).unwrap()).unwrap();
    let client = thread.client();
    client.clear([1, 2, 3, 4]);
    client.put_pixel(5, 4, [9, 8, 7, 6]);
    assert_eq!(client.size().unwrap(), [8, 6]);
    assert_eq!(client.get_pixel(5, 4).unwrap(), [9, 8, 7, 255]);
    assert_eq!(client.read([4, 4, 2, 1]).unwrap(), [1, 2, 3, 4, 9, 8, 7, 6]);
    assert_eq!(client.peek((8 * 4 + 5) * 4, 5).unwrap(), [9, 8, 7, 6, 1]);
    assert_eq!(client.crc().unwrap(), fbptr_formats::save::crc32(&client.snapshot().unwrap()));
    assert_eq!(client.crc_of([5, 4, 1, 1]).unwrap(), crc32fast::hash(&[9, 8, 7, 6]));
    assert_eq!((client.depth_at(5, 4).unwrap(), client.pick(5, 4).unwrap()), (1.0, None));
    client.mesh("cube", MeshSource::Box(DVec3::splat(4.0)));
    client.draw("cube");
    assert!(client.depth_at(4, 3).unwrap() < 1.0);
    let picked = client.pick(4, 3).unwrap();
    assert_eq!(picked.map(|(name, _)| name).as_deref(), Some("cube"));
    assert!(client.help().unwrap().contains("LINE x0 y0"));
    assert!(client.stats().unwrap().starts_with("STATS "));
    assert_eq!(client.hello().unwrap(), "HELLO fbptr 1 8 6 32 rgba");
    assert_eq!(client.version().unwrap(), env!("CARGO_PKG_VERSION"));
    assert!(client.snap_png().unwrap().starts_with(b"\x89PNG"));
    assert_eq!(client.get_pixel(8, 0).unwrap_err().code, Code::Range);
    assert_eq!(client.snap("a.png").unwrap_err().code, Code::Perm);
    assert_eq!((client.present().unwrap(), client.present().unwrap()), (1, 2));
    thread.finish(Finish::Now);
}
