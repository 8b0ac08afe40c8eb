//! Self-localization by Doppler-resolved echoes.
