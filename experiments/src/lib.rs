//! The papers' studies.
