//! stub
use super::*;
pub fn pictures(
    _a: &PlanArgs,
    _t: &Task,
    _s: &Scene,
    _p: &Plan,
    _st: &[Step],
) -> Result<(), Failure> {
    Ok(())
}
