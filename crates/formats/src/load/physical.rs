//! Physical materials (base colour, metallic, roughness) in Phong's parameters.
//!
//! In: base colour c, metallic m, roughness r of X3D's PhysicalMaterial or of glTF. Out: Kd, Ks and
//! the exponent n of Blinn's lobe.
//!
//! ```text
//! Kd = c (1 - m/2)                      a metal has no diffuse light of its own: half its
//!                                       colour stands for the surroundings that it would
//!                                       mirror, which are not there
//! F0 = 0.04 (1 - m) + c m               what is mirrored straight on (4 % of a dielectric)
//! a  = max(r, 0.1)^2                    width of the lobe, as in GGX
//! n  = min(2 / a^2 - 2, 1000)           the exponent of Blinn's lobe of this width
//! Ks = F0 min(1, (1 - a^4) / (4 a^2))   GGX's height straight on, F0 / (4 a^2), less the part
//!                                       that is as flat as diffuse light
//! ```
//!
//! Sources: ISO/IEC 19775-1 (X3D 4) clause 12.4.6; glTF 2.0 Specification, appendix B; B. Walter et
//! al., "Microfacet Models for Refraction through Rough Surfaces", 2007, section 5.2; B. Karis,
//! "Real Shading in Unreal Engine 4", 2013 (a = r^2, the exponent).

use glam::DVec3;

/// Diffuse and specular reflection Kd and Ks, and the specular exponent n.
pub(super) struct Reflection {
    pub(super) kd: DVec3,
    pub(super) ks: DVec3,
    pub(super) n: f64,
}

/// Converts a physical material: base colour c, metallic m, roughness r.
pub(super) fn reflection(c: DVec3, metallic: f64, roughness: f64) -> Reflection {
    let m = metallic.clamp(0.0, 1.0);
    let a = roughness.clamp(0.1, 1.0) * roughness.clamp(0.1, 1.0);
    let f0 = DVec3::splat(0.04) * (1.0 - m) + c * m;
    Reflection {
        kd: c * (1.0 - m / 2.0),
        ks: f0 * ((1.0 - a * a * a * a) / (4.0 * a * a)).min(1.0),
        n: (2.0 / (a * a) - 2.0).min(1000.0),
    }
}
