//! The linear system B = E + rho P B.
