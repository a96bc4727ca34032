//! The system ids behind one port: no two vehicles may have the same, or neither could be addressed.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// The id of each vehicle of a port, by its place among them.
#[derive(Debug, Default)]
pub(crate) struct SystemIds(Mutex<Vec<u8>>);

impl SystemIds {
    pub fn new(ids: Vec<u8>) -> Self {
        Self(Mutex::new(ids))
    }

    /// Whether another vehicle than the one at a place has an id.
    pub fn is_taken(&self, place: usize, id: u8) -> bool {
        self.lock().iter().enumerate().any(|(other, taken)| other != place && *taken == id)
    }

    /// The vehicle at a place has another id.
    pub fn set(&self, place: usize, id: u8) {
        if let Some(own) = self.lock().get_mut(place) {
            *own = id;
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<u8>> {
        // A vehicle that panicked while it held the lock leaves whole ids behind.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_had_by_one_and_free_when_he_leaves_it() {
        let ids = SystemIds::new(vec![1, 2]);
        assert!(ids.is_taken(0, 2) && !ids.is_taken(1, 2));
        ids.set(1, 7);
        assert!(!ids.is_taken(0, 2) && ids.is_taken(0, 7));
        let alone = SystemIds::default();
        alone.set(0, 9);
        assert!(!alone.is_taken(0, 9));
    }
}
