//! Likelihood of poses: mutual information of echo images and map patches (eqs. (9)-(16)), and the caches that make
//! it fast.

mod direction_cache;
mod map_patches;
pub mod mutual_information;
pub(crate) mod particle_likelihood;
