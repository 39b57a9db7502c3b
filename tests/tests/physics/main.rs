//! Physics by others' tables, through whole bakes: closed forms of radiative transfer, and the cases of CIE 171:2006
//! whose answers can be computed.

mod cie_171;
mod enclosures;
mod factors;
mod gaps;
mod points;
