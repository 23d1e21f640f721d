//! JSON for readers that must say where a fault lies: a tree that refuses doubled keys, a cursor
//! that knows its path, and the line and column of a path.

mod locate;
mod node;
mod tree;

use locate::locate;
use node::Step;

pub(crate) use node::{Node, Source};
pub(crate) use tree::{Json, parse};
