//! The ROS 2 messages of a plan: `nav_msgs/msg/Path` and `nav_msgs/msg/OccupancyGrid`.

use sidestep::plane::world::Grid;
use sidestep::trajectory::driving::Pose;

use super::cdr::Cdr;

/// The definition of a message, with all that it is made of, as MCAP's encoding `ros2msg` wants it.
pub const PATH: &str = "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n";
pub const OCCUPANCY_GRID: &str = "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n";
const LINE: &str =
    "================================================================================\n";
const PARTS: [(&str, &str); 7] = [
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"),
    (
        "nav_msgs/MapMetaData",
        "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\n\
         geometry_msgs/Pose origin\n",
    ),
];

/// A message's definition followed by those of its parts.
pub fn definition(message: &str) -> String {
    let part = |(name, text): &(&str, &str)| format!("{LINE}MSG: {name}\n{text}");
    let is_used =
        |(name, _): &&(&str, &str)| *name != "nav_msgs/MapMetaData" || message == OCCUPANCY_GRID;
    std::iter::once(message.to_owned()).chain(PARTS.iter().filter(is_used).map(part)).collect()
}

/// Seconds and nanoseconds of a time.
pub fn stamp(time: f64) -> [u32; 2] {
    let nanoseconds = (time.max(0.0) * 1e9).min(4e18) as u64;
    [(nanoseconds / 1_000_000_000) as u32, (nanoseconds % 1_000_000_000) as u32]
}

/// z and w of the quaternion of a heading.
pub fn quaternion(yaw: f64) -> [f64; 2] {
    [(0.5 * yaw).sin(), (0.5 * yaw).cos()]
}

fn header(cdr: &mut Cdr, time: f64, frame: &str) {
    let [seconds, nanoseconds] = stamp(time);
    cdr.i32(seconds as i32);
    cdr.u32(nanoseconds);
    cdr.string(frame);
}

fn pose(cdr: &mut Cdr, [x, y]: [f64; 2], yaw: f64) {
    let [z, w] = quaternion(yaw);
    [x, y, 0.0, 0.0, 0.0, z, w].into_iter().for_each(|value| cdr.f64(value));
}

/// A `nav_msgs/msg/Path`; each pose is stamped with its time since the start.
pub fn path(poses: &[Pose], frame: &str) -> Vec<u8> {
    let mut cdr = Cdr::new();
    header(&mut cdr, 0.0, frame);
    cdr.u32(poses.len() as u32);
    for at in poses {
        header(&mut cdr, at.time, frame);
        pose(&mut cdr, at.position, at.yaw);
    }
    cdr.bytes()
}

/// A `nav_msgs/msg/OccupancyGrid`: 100 occupied, 0 free.
pub fn occupancy_grid(grid: &Grid, frame: &str) -> Vec<u8> {
    let mut cdr = Cdr::new();
    header(&mut cdr, 0.0, frame);
    cdr.i32(0);
    cdr.u32(0);
    cdr.f32(grid.resolution() as f32);
    cdr.u32(grid.width() as u32);
    cdr.u32(grid.height() as u32);
    pose(&mut cdr, grid.origin(), 0.0);
    cdr.octets(grid.cells().iter().map(|&occupied| if occupied { 100 } else { 0 }));
    cdr.bytes()
}
