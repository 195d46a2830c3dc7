//! The allowed imports between the parts of a crate, and between those of `pipeline` and `eye`.
//! Cargo keeps the order of the crates.

/// The parts that a part may import.
pub type Edges = &'static [(&'static str, &'static [&'static str])];

/// Every place whose parts have a list: a crate, or a module of one.
pub const PLACES: &[(&[&str], Edges)] = &[
    (&["core"], CORE),
    (&["core", "pipeline"], PIPELINE),
    (&["core", "eye"], EYE),
    (&["formats"], FORMATS),
    (&["engine"], ENGINE),
    (&["server"], SERVER),
    (&["desktop"], DESKTOP),
];

/// Imports between the parts of `fbptr-core`.
const CORE: Edges = &[
    ("executor", &["cancel"]),
    ("memory", &["error", "simd"]),
    ("scene", &["error", "math"]),
    ("draw2d", &["error", "executor", "math", "memory", "simd"]),
    ("eye", &["error", "executor", "math", "memory", "scene"]),
    ("pipeline", &["cancel", "error", "executor", "math", "memory", "scene", "simd"]),
];

/// Imports between the parts of `fbptr-formats`.
const FORMATS: Edges = &[("load", &["save"]), ("animation", &["load"]), ("models", &["animation", "load"])];

/// Imports between the parts of `fbptr-desktop`.
const DESKTOP: Edges = &[("window", &["viewer"])];

/// Imports between the parts of `fbptr-engine`.
const ENGINE: Edges = &[
    ("budget", &["clock"]),
    ("resources", &["limits"]),
    ("surfaces", &["engine_frame", "limits", "resources"]),
    ("session", &["limits", "read_files", "resources", "stats", "surfaces"]),
    (
        "engine",
        &[
            "budget",
            "clock",
            "engine_frame",
            "limits",
            "read_files",
            "resources",
            "session",
            "snapshot_names",
            "stats",
            "workers",
        ],
    ),
    ("stream", &["budget", "clock", "engine", "session"]),
];

/// Imports between the parts of `fbptr-server`.
const SERVER: Edges = &[
    ("message", &["buffer_pool", "reply_queue"]),
    ("jobs", &["message"]),
    ("client", &["message"]),
    ("transport", &["admission", "buffer_pool", "message", "reply_queue"]),
    ("display", &["events"]),
    ("metrics", &["admission", "http"]),
    ("web", &["admission", "display", "http", "message", "metrics", "transport"]),
    ("replay", &["record"]),
    ("playback", &["record", "replay"]),
    ("player", &["message", "record", "thread", "transport"]),
    ("snapshots", &["message", "thread"]),
    (
        "thread",
        &[
            "admission",
            "buffer_pool",
            "client",
            "display",
            "events",
            "jobs",
            "message",
            "metrics",
            "record",
            "replay",
            "reply_queue",
            "shared_file",
            "sniff",
            "transport",
            "web",
        ],
    ),
    ("serve", &["admission", "client", "message", "metrics", "thread", "transport", "web"]),
];

/// Imports between the parts of the eye.
const EYE: Edges = &[
    ("validate", &["error"]),
    ("pose", &["error", "validate"]),
    ("scene", &["error", "pose", "validate"]),
    ("shapes", &["error", "pose", "scene", "validate"]),
    // Scenes of the unit tests, compiled for them alone.
    ("test_scenes", &["pose", "scene"]),
    ("json", &["error", "pose", "scene"]),
    ("picture", &["error", "json", "scene"]),
    ("blit", &["picture"]),
    ("eye_space", &["scene"]),
    ("bounds", &["eye_space"]),
    ("method", &["eye_space"]),
    ("frame_light", &["eye_space", "scene"]),
    ("occluder", &["frame_light"]),
    ("lights", &["frame_light", "occluder"]),
    ("bvh", &["occluder"]),
    ("frame", &["bounds", "eye_space", "frame_light", "method", "occluder", "scene"]),
    ("fibre", &["eye_space", "frame", "method"]),
    ("tile", &["bounds", "bvh", "fibre", "frame", "lights", "method", "occluder", "scene"]),
    ("plan", &["method", "scene", "tile"]),
    ("render", &["error", "fibre", "frame", "method", "picture", "plan", "scene", "tile"]),
];

/// Imports between the parts of the pipeline. The reference imports nothing of the tile renderer.
const PIPELINE: Edges = &[
    // Neutral modules, used by both paths.
    ("vertex", &["viewport"]),
    ("wide_vertex", &["vertex"]),
    ("plane_equation", &["vertex", "viewport", "wide_vertex"]),
    ("far_face", &["plane_equation", "vertex", "wide_vertex"]),
    ("shading_space", &["vertex"]),
    ("assemble", &["draw_call", "far_face", "plane_equation", "vertex", "viewport"]),
    ("materials", &["assemble", "draw_call", "light"]),
    ("surface_maps", &["draw_call", "light", "sampler"]),
    ("shade", &["draw_call", "light", "sampler", "surface_maps"]),
    ("pixel", &["assemble", "draw_call", "light", "plane_equation", "sampler", "shade", "viewport"]),
    ("target_rows", &["draw_call", "plan"]),
    ("preemption", &["draw_call"]),
    ("backdrop", &["draw_call", "preemption", "viewport"]),
    ("occlusion_history", &["draw_call"]),
    ("mesh_extent", &["ndc_box"]),
    ("geometry_cache", &["draw_call", "indexed_mesh", "mesh_extent", "normals", "occlusion_history"]),
    ("empty_draw", &["draw_call"]),
    ("planner", &["draw_call", "geometry_cache", "light", "plan", "vertex", "working"]),
    (
        "prepared_draw",
        &[
            "assemble",
            "draw_call",
            "geometry_cache",
            "light",
            "normals",
            "pixel",
            "plan",
            "planner",
            "preemption",
            "shade",
            "shading_space",
            "surface_maps",
            "target_rows",
            "vertex",
            "viewport",
        ],
    ),
    ("depth_sort", &["prepared_draw"]),
    ("scene", &["depth_sort", "draw_call", "geometry_cache", "planner", "prepared_draw"]),
    // The two paths.
    (
        "reference",
        &[
            "assemble",
            "clip",
            "depth_sort",
            "draw_call",
            "light",
            "pixel",
            "plan",
            "plane_equation",
            "prepared_draw",
            "shade",
            "target_rows",
            "vertex",
            "wide_vertex",
        ],
    ),
    (
        "tile",
        &[
            "assemble",
            "depth_sort",
            "draw_call",
            "indexed_mesh",
            "light",
            "plane_equation",
            "preemption",
            "sampler",
            "shading_space",
            "viewport",
        ],
    ),
    (
        "tile_frontend",
        &[
            "assemble",
            "depth_sort",
            "draw_call",
            "indexed_mesh",
            "light",
            "plan",
            "preemption",
            "prepared_draw",
            "sampler",
            "shade",
            "shading_space",
            "target_rows",
            "tile",
            "vertex",
            "working",
        ],
    ),
    // Modules that choose between them.
    (
        "ordered",
        &[
            "assemble",
            "depth_sort",
            "draw_call",
            "plan",
            "preemption",
            "prepared_draw",
            "reference",
            "shade",
            "target_rows",
            "tile",
            "tile_frontend",
            "working",
        ],
    ),
    (
        "worst_case",
        &["draw_call", "ordered", "plan", "reference", "tile", "tile_frontend", "vertex", "working"],
    ),
    (
        "path_plan",
        &[
            "draw_call",
            "geometry_cache",
            "occlusion_history",
            "ordered",
            "plan",
            "planner",
            "prepared_draw",
            "scene",
            "tile",
            "tile_frontend",
            "worst_case",
        ],
    ),
    (
        "scene_plan",
        &[
            "draw_call",
            "geometry_cache",
            "light",
            "ordered",
            "path_plan",
            "plan",
            "planner",
            "prepared_draw",
            "scene",
            "tile",
            "tile_frontend",
            "vertex",
            "working",
            "worst_case",
        ],
    ),
    (
        "renderer",
        &[
            "backdrop",
            "depth_sort",
            "draw_call",
            "geometry_cache",
            "light",
            "mesh_extent",
            "ndc_box",
            "ordered",
            "path_plan",
            "plan",
            "preemption",
            "prepared_draw",
            "scene",
            "scene_plan",
            "tile",
            "tile_frontend",
            "vertex",
            "working",
            "worst_case",
        ],
    ),
    ("quality", &["draw_call", "ndc_box", "normals"]),
    (
        "trace",
        &[
            "assemble",
            "clip",
            "draw_call",
            "light",
            "path_plan",
            "pixel",
            "plan",
            "plane_equation",
            "prepared_draw",
            "renderer",
            "sampler",
            "scene",
            "shade",
            "tile",
        ],
    ),
];

/// Files that import each other in a circle, and why they may.
pub const CIRCLES: &[(&[&str], &str)] = &[
    (
        &[
            "command::arguments",
            "command::codec",
            "command::commands",
            "command::encode",
            "command::plain_line",
            "command::table",
            "command::verb",
        ],
        "a row of the table makes the enums, their codec and parsers out of the arguments, and `verb` and `encode` look rows up",
    ),
    (
        &["command::decoder", "command::long_line"],
        "a long line is a state of the decoder and counts its payload as framing does",
    ),
    (
        &[
            "core::math::coverage::edge_walk",
            "core::math::coverage::exact_int",
            "core::math::coverage::far_edge_walk",
        ],
        "the type of the integers chooses the walk, and both walks are generic over it",
    ),
    (
        &["desktop::fbdev::device", "desktop::fbdev::sysfs"],
        "a device owns the thread of its files in sysfs, which reads and sets its words",
    ),
    (
        &["engine::engine::dispatch", "engine::engine::job"],
        "the door hands jobs out, and a job is guarded against defects as the door guards requests",
    ),
    (
        &["formats::load::gltf::mesh", "formats::load::gltf::pose"],
        "a primitive keeps its pose, and a pose reads attributes as primitives do",
    ),
    (
        &[
            "formats::load::mesh",
            "formats::load::obj",
            "formats::load::ply",
            "formats::load::side_files",
            "formats::load::stl",
        ],
        "a mesh file is read by its format's reader, and the readers share the types of `mesh` and OBJ's opener of side files",
    ),
    (
        &["formats::load::x3d::appearance", "formats::load::x3d::stages"],
        "a texture is a stage of a multi-texture, and a stage maps its own texture",
    ),
    (
        &[
            "formats::load::x3d::build",
            "formats::load::x3d::external_refs",
            "formats::load::x3d::instance",
            "formats::load::x3d::names",
            "formats::load::x3d::proto",
            "formats::load::x3d::remarks",
            "formats::load::x3d::texture",
            "formats::load::x3d::unusable",
            "formats::load::x3d::validate",
        ],
        "building is recursive: a prototype's instance or a file of Inline is built as a document is, and each part leaves remarks",
    ),
    (
        &[
            "formats::load::x3d::graph",
            "formats::load::x3d::interpolate",
            "formats::load::x3d::route",
            "formats::load::x3d::time",
        ],
        "the graph keeps its routes, and what routes run reads the graph",
    ),
    (
        &["lab::bench::check", "lab::bench::frame"],
        "a frame is checked before it is timed, against a picture of the same background",
    ),
    (
        &["lab::coverage", "lab::coverage_drawn"],
        "two halves of one experiment: the corners of the one are drawn by the other",
    ),
    (
        &["lab::decide", "lab::report", "lab::stages"],
        "the report runs the decisions and experiments, and each is a section of it",
    ),
    (
        &["server::transport::inline_reader", "server::transport::poll"],
        "two threads read one set of sockets, and each knows the other's marks",
    ),
    (
        &["server::transport::listen", "server::transport::unix"],
        "a listener opens a socket file, which is a kind of listener",
    ),
    (
        &["server::web::commands", "server::web::socket"],
        "a socket sends commands on, and their replies come back to it",
    ),
    (
        &["truth::face", "truth::fragment", "truth::lines", "truth::picture", "truth::render"],
        "a picture is drawn face by face into fragments that it keeps; they share its types",
    ),
];
