//! Optimisation-based motion planning with classical and learned optimizers.
