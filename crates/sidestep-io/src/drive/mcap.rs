//! A plan as an MCAP file (<https://mcap.dev/spec>, version 0) with ROS 2 messages: `/map`, `/iterates` and `/plan`.
//!
//! One chunk without compression, with the indexes that readers seek by. Checksums are 0: not there.

use sidestep::plane::world::{Grid, World};
use sidestep::trajectory::driving::Pose;

use super::ros;

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
/// Nanoseconds between two iterates.
const ITERATE: u64 = 50_000_000;
/// Cells along the larger side of the picture of a world of shapes.
const CELLS: usize = 256;

/// What is recorded.
#[derive(Debug, Clone, Copy)]
pub struct Recording<'a> {
    /// The world, as an occupancy grid; shapes are drawn into its cells, or into 256 along the larger side.
    pub world: &'a World,
    /// The driven plan.
    pub poses: &'a [Pose],
    /// Iterates in order, 50 ms apart in the file.
    pub iterates: &'a [Vec<Pose>],
    /// The frame of all messages, `map` as a rule.
    pub frame: &'a str,
}

/// The file.
pub fn to_mcap(recording: &Recording<'_>) -> Vec<u8> {
    let Recording { world, poses, iterates, frame } = recording;
    let end = ITERATE * iterates.len() as u64;
    let mut messages: Vec<(u16, u64, Vec<u8>)> = Vec::new();
    if let Some(grid) = picture(world) {
        messages.push((1, 0, ros::occupancy_grid(&grid, frame)));
    }
    for (index, iterate) in iterates.iter().enumerate() {
        messages.push((2, ITERATE * index as u64, ros::path(iterate, frame)));
    }
    messages.push((3, end, ros::path(poses, frame)));

    let mut file = MAGIC.to_vec();
    record(&mut file, 0x01, &[string("ros2"), string("sidestep")].concat());
    let descriptions = descriptions();
    let mut records = descriptions.clone();
    let mut indexes: [Vec<u8>; 3] = Default::default();
    let mut counts = [0_u64; 3];
    for (sequence, (channel, time, data)) in messages.iter().enumerate() {
        let slot = usize::from(*channel) - 1;
        indexes[slot].extend([time.to_le_bytes(), (records.len() as u64).to_le_bytes()].concat());
        counts[slot] += 1;
        let head = [&channel.to_le_bytes()[..], &(sequence as u32).to_le_bytes()].concat();
        let times = [time.to_le_bytes(), time.to_le_bytes()].concat();
        record(&mut records, 0x05, &[&head, &times, data].map(|part| &part[..]).concat());
    }
    let size = (records.len() as u64).to_le_bytes();
    let times = [0, end].map(u64::to_le_bytes).concat();
    let chunk_start = file.len() as u64;
    let chunk = [&times, &size[..], &[0; 4], &string(""), &size, &records].concat();
    record(&mut file, 0x06, &chunk);
    let chunk_length = file.len() as u64 - chunk_start;
    let indexes_start = file.len();
    let mut offsets = Vec::new();
    for (channel, index) in (1_u16..).zip(&indexes).filter(|(_, index)| !index.is_empty()) {
        offsets.extend(channel.to_le_bytes());
        offsets.extend((file.len() as u64).to_le_bytes());
        record(&mut file, 0x07, &[&channel.to_le_bytes(), &sized(index)[..]].concat());
    }
    let indexes_length = (file.len() - indexes_start) as u64;
    record(&mut file, 0x0f, &[0; 4]);

    let summary = file.len() as u64;
    file.extend(&descriptions);
    let counted: Vec<u8> = (1_u16..)
        .zip(counts)
        .filter(|(_, count)| *count > 0)
        .flat_map(|(channel, count)| [&channel.to_le_bytes()[..], &count.to_le_bytes()].concat())
        .collect();
    let mut statistics = (messages.len() as u64).to_le_bytes().to_vec();
    statistics.extend(2_u16.to_le_bytes());
    [3_u32, 0, 0, 1].iter().for_each(|count| statistics.extend(count.to_le_bytes()));
    statistics.extend(&times);
    statistics.extend(sized(&counted));
    record(&mut file, 0x0b, &statistics);
    let mut index = times;
    [chunk_start, chunk_length].iter().for_each(|value| index.extend(value.to_le_bytes()));
    index.extend(sized(&offsets));
    index.extend(indexes_length.to_le_bytes());
    index.extend(string(""));
    index.extend([size, size].concat());
    record(&mut file, 0x08, &index);
    record(&mut file, 0x02, &[&summary.to_le_bytes()[..], &[0; 8], &[0; 4]].concat());
    file.extend(MAGIC);
    file
}

/// Schemas and channels.
fn descriptions() -> Vec<u8> {
    let mut records = Vec::new();
    let schemas =
        [("nav_msgs/msg/OccupancyGrid", ros::OCCUPANCY_GRID), ("nav_msgs/msg/Path", ros::PATH)];
    for (id, (name, text)) in (1_u16..).zip(schemas) {
        let id = id.to_le_bytes().to_vec();
        let text = sized(ros::definition(text).as_bytes());
        record(&mut records, 0x03, &[id, string(name), string("ros2msg"), text].concat());
    }
    for (id, schema, topic) in [(1_u16, 1_u16, "/map"), (2, 2, "/iterates"), (3, 2, "/plan")] {
        let ids = [id.to_le_bytes(), schema.to_le_bytes()].concat();
        record(&mut records, 0x04, &[ids, string(topic), string("cdr"), sized(&[])].concat());
    }
    records
}

/// The world as a grid.
fn picture(world: &World) -> Option<Grid> {
    let bounds = world.bounds();
    let (width, height, resolution, origin) = match world.grid() {
        Some(grid) => (grid.width(), grid.height(), grid.resolution(), grid.origin()),
        None => {
            let resolution = bounds.extent() / CELLS as f64;
            let cells = bounds.size().map(|side| ((side / resolution).round() as usize).max(1));
            (cells[0], cells[1], resolution, bounds.min)
        }
    };
    let mut cells =
        world.grid().map_or_else(|| vec![false; width * height], |grid| grid.cells().to_vec());
    for obstacle in world.obstacles() {
        let block = obstacle.bounding_box();
        let range = |axis: usize, count: usize| {
            let cell = |x: f64| ((x - origin[axis]) / resolution).floor().clamp(0.0, count as f64);
            cell(block.min[axis]) as usize..((cell(block.max[axis]) as usize) + 1).min(count)
        };
        for row in range(1, height) {
            for column in range(0, width) {
                let middle =
                    |axis: usize, cell: usize| origin[axis] + resolution * (cell as f64 + 0.5);
                cells[row * width + column] |=
                    obstacle.contains([middle(0, column), middle(1, row)]);
            }
        }
    }
    Grid::new(width, height, resolution, origin, cells).ok()
}

fn record(to: &mut Vec<u8>, opcode: u8, content: &[u8]) {
    to.push(opcode);
    to.extend((content.len() as u64).to_le_bytes());
    to.extend(content);
}

fn string(text: &str) -> Vec<u8> {
    sized(text.as_bytes())
}

/// Bytes with their number in front.
fn sized(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}
