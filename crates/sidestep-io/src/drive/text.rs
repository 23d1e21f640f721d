//! Driven paths as text.

use std::fmt::Write;

use sidestep::trajectory::driving::Pose;

/// A table `x,y,yaw,t,v,kappa`, one point a line.
pub fn to_csv(poses: &[Pose]) -> String {
    let mut text = String::from("x,y,yaw,t,v,kappa\n");
    for Pose { position: [x, y], yaw, time, speed, curvature } in poses {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{x},{y},{yaw},{time},{speed},{curvature}");
    }
    text
}

/// A `nav_msgs/msg/Path` as `ros2 topic pub` and `ros2 topic echo` write it; each pose is stamped with its time since the start.
pub fn to_nav_path(poses: &[Pose], frame: &str) -> String {
    let frame = serde_json::Value::from(frame);
    let mut text = format!("header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: {frame}\n");
    text += if poses.is_empty() { "poses: []\n" } else { "poses:\n" };
    for pose in poses {
        let ([sec, nanosec], [x, y], [z, w]) =
            (super::ros::stamp(pose.time), pose.position, super::ros::quaternion(pose.yaw));
        let _ = write!(
            text,
            "- header:\n    stamp:\n      sec: {sec}\n      nanosec: {nanosec}\n    frame_id: {frame}\n  pose:\n    \
             position:\n      x: {x:?}\n      y: {y:?}\n      z: 0.0\n    orientation:\n      x: 0.0\n      y: 0.0\n      \
             z: {z:?}\n      w: {w:?}\n"
        );
    }
    text
}

/// A GeoJSON feature: a line in the map's own coordinates, with yaw, time, speed and curvature of each point as properties.
pub fn to_geojson(poses: &[Pose]) -> String {
    let list = |value: fn(&Pose) -> f64| poses.iter().map(value).collect::<Vec<_>>();
    let feature = serde_json::json!({
        "type": "Feature",
        "geometry": {
            "type": "LineString",
            "coordinates": poses.iter().map(|pose| pose.position).collect::<Vec<_>>(),
        },
        "properties": {
            "yaw": list(|pose| pose.yaw),
            "t": list(|pose| pose.time),
            "v": list(|pose| pose.speed),
            "kappa": list(|pose| pose.curvature),
        },
    });
    format!("{feature:#}\n")
}
