//! mavlink-bridge
