//! columba
fn main() {}
