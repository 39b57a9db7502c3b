//! Light probes: few, degenerate, far away, in walls.
