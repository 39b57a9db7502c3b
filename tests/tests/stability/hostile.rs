//! Nothing that comes in makes a NaN come out.
