//! Trajectories for controllers: ROS's `trajectory_msgs/JointTrajectory` as YAML or JSON, and CSV.
//!
//! Source: the message's definition (`joint_names`, `points[].{positions, velocities,
//! accelerations, effort, time_from_start}`). Radians, or metres for joints that slide, and
//! seconds; times count from the start and increase strictly, to the nanosecond, as controllers
//! ask. A CSV has a row a moment: the time, then for each joint its position, and after all
//! positions the velocities and the accelerations.

use std::fmt::Write;

use serde_json::json;
use sidestep::InvalidInput;
use sidestep::trajectory::timing::Moment;

/// A form of a trajectory's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrajectoryFormat {
    /// The ROS message as YAML, as `ros2 topic pub` reads it.
    Yaml,
    /// The ROS message as JSON.
    Json,
    /// A table with a line of names.
    Csv,
}

impl TrajectoryFormat {
    /// The format of a file name, by its extension (in any case).
    pub fn from_file_name(name: &str) -> Option<Self> {
        match name.rsplit_once('.')?.1.to_ascii_lowercase().as_str() {
            "yaml" | "yml" => Some(Self::Yaml),
            "json" => Some(Self::Json),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }
}

/// The text of a trajectory's file; `joints` names the numbers of each moment in order.
///
/// # Errors
/// If names are missing, empty or doubled, a moment has another number of joints, a number is not
/// finite, or two times are the same nanosecond.
pub fn write_trajectory(
    joints: &[String],
    moments: &[Moment],
    format: TrajectoryFormat,
) -> Result<String, InvalidInput> {
    check_names(joints)?;
    let nanoseconds = check_moments(joints.len(), moments)?;
    Ok(match format {
        TrajectoryFormat::Json => json_text(joints, moments, &nanoseconds),
        TrajectoryFormat::Yaml => yaml_text(joints, moments, &nanoseconds),
        TrajectoryFormat::Csv => csv_text(joints, moments),
    })
}

fn check_names(joints: &[String]) -> Result<(), InvalidInput> {
    for (i, name) in joints.iter().enumerate() {
        if name.is_empty() || joints[..i].contains(name) {
            let found = format!("{name:?}");
            return Err(InvalidInput::new(format!("joint_names[{i}]"), found, "each joint once"));
        }
    }
    if joints.is_empty() {
        return Err(InvalidInput::new("joint_names", "none", "at least one joint"));
    }
    Ok(())
}

/// The times in nanoseconds.
fn check_moments(dof: usize, moments: &[Moment]) -> Result<Vec<u64>, InvalidInput> {
    let mut nanoseconds: Vec<u64> = Vec::with_capacity(moments.len());
    for (i, moment) in moments.iter().enumerate() {
        for (field, values) in [
            ("positions", &moment.position),
            ("velocities", &moment.velocity),
            ("accelerations", &moment.acceleration),
        ] {
            let field = format!("points[{i}].{field}");
            if values.len() != dof {
                let found = format!("{} numbers", values.len());
                return Err(InvalidInput::new(field, found, format!("{dof}, one a joint")));
            }
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(InvalidInput::new(field, value, "finite numbers"));
            }
        }
        let last = nanoseconds.last().copied();
        let time = moment.time * 1e9;
        // 2^31 seconds are what the message's time can say.
        let fits = (0.0..2_147_483_648e9).contains(&time);
        let time = time.round() as u64;
        if !fits || last.is_some_and(|last| time <= last) {
            let allowed = "seconds of at least 0 that increase by a nanosecond or more";
            let field = format!("points[{i}].time_from_start");
            return Err(InvalidInput::new(field, moment.time, allowed));
        }
        nanoseconds.push(time);
    }
    Ok(nanoseconds)
}

fn parts(nanoseconds: u64) -> (u64, u64) {
    (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000)
}

fn json_text(joints: &[String], moments: &[Moment], nanoseconds: &[u64]) -> String {
    let point = |(moment, &time): (&Moment, &u64)| {
        let (sec, nanosec) = parts(time);
        json!({
            "positions": moment.position,
            "velocities": moment.velocity,
            "accelerations": moment.acceleration,
            "effort": [],
            "time_from_start": {"sec": sec, "nanosec": nanosec},
        })
    };
    let points: Vec<_> = moments.iter().zip(nanoseconds).map(point).collect();
    let header = json!({"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""});
    let document = json!({"header": header, "joint_names": joints, "points": points});
    format!("{document:#}\n")
}

/// JSON's names and lists are YAML's too.
fn yaml_text(joints: &[String], moments: &[Moment], nanoseconds: &[u64]) -> String {
    let names = json!(joints);
    let mut text = format!(
        "header:\n  stamp: {{sec: 0, nanosec: 0}}\n  frame_id: ''\njoint_names: {names}\npoints:\n"
    );
    for (moment, &time) in moments.iter().zip(nanoseconds) {
        let (sec, nanosec) = parts(time);
        let lists = [&moment.position, &moment.velocity, &moment.acceleration].map(|v| json!(v));
        let [positions, velocities, accelerations] = lists;
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "- positions: {positions}\n  velocities: {velocities}\n  \
             accelerations: {accelerations}\n  effort: []\n  \
             time_from_start: {{sec: {sec}, nanosec: {nanosec}}}\n"
        );
    }
    text
}

fn csv_text(joints: &[String], moments: &[Moment]) -> String {
    let mut text = "time".to_owned();
    for kind in ["", "_velocity", "_acceleration"] {
        for name in joints {
            let plain = !name.contains([',', '"', '\n', '\r']);
            let column = format!("{name}{kind}");
            let quoted =
                if plain { column } else { format!("\"{}\"", column.replace('"', "\"\"")) };
            text.extend([",", &quoted]);
        }
    }
    text.push('\n');
    for moment in moments {
        text.push_str(&moment.time.to_string());
        for value in
            [&moment.position, &moment.velocity, &moment.acceleration].into_iter().flatten()
        {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(time: f64) -> Moment {
        let numbers = vec![0.5, -1e-7];
        Moment { time, position: numbers.clone(), velocity: numbers.clone(), acceleration: numbers }
    }

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn all_formats_say_the_same() {
        let joints = names(&["shoulder", "el\"bow, left"]);
        let moments = [moment(0.0), moment(1.25)];
        let write = |format| write_trajectory(&joints, &moments, format).unwrap();
        let json: serde_json::Value = serde_json::from_str(&write(TrajectoryFormat::Json)).unwrap();
        let yaml: serde_json::Value =
            serde_saphyr::from_str(&write(TrajectoryFormat::Yaml)).unwrap();
        assert_eq!(json, yaml);
        assert_eq!(json["joint_names"], json!(joints));
        assert_eq!(json["points"][1]["positions"], json!([0.5, -1e-7]));
        assert_eq!(json["points"][1]["time_from_start"], json!({"sec": 1, "nanosec": 250_000_000}));
        let csv = write(TrajectoryFormat::Csv);
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines[0].starts_with("time,shoulder,\"el\"\"bow, left\",shoulder_velocity,"));
        assert_eq!(lines[2], "1.25,0.5,-0.0000001,0.5,-0.0000001,0.5,-0.0000001");
    }

    #[test]
    fn refuses_what_controllers_refuse() {
        let two = || names(&["a", "b"]);
        let mut nan = moment(1.0);
        nan.velocity[1] = f64::NAN;
        for (joints, moments, field) in [
            (names(&["a", "a"]), vec![], "joint_names[1]"),
            (names(&["", "a"]), vec![], "joint_names[0]"),
            (names(&[]), vec![], "joint_names"),
            (names(&["a"]), vec![moment(0.0)], "points[0].positions"),
            (two(), vec![moment(0.0), moment(0.0)], "points[1].time_from_start"),
            (two(), vec![moment(0.0), moment(1e-10)], "points[1].time_from_start"),
            (two(), vec![moment(-1.0)], "points[0].time_from_start"),
            (two(), vec![moment(f64::NAN)], "points[0].time_from_start"),
            (two(), vec![nan], "points[0].velocities"),
        ] {
            let error = write_trajectory(&joints, &moments, TrajectoryFormat::Yaml).unwrap_err();
            assert_eq!(error.field, field);
        }
    }
}
