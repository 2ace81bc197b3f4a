//! Photons as a PLY file: little-endian, one vertex each.

use crate::render::photon::map::PhotonMap;

/// The file. Coordinates are doubles, as they are kept; the rest is single precision.
pub(super) fn encode(map: &PhotonMap) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment n is the direction to where the photon came from, colours are watts\n\
         element vertex {}\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\n\
         property float nz\nproperty float red\nproperty float green\nproperty float blue\nproperty uint bounces\n\
         property uint shape\nend_header\n",
        map.len()
    );
    let mut bytes = header.into_bytes();
    for photon in map.photons() {
        for x in photon.p.to_array() {
            bytes.extend(x.to_le_bytes());
        }
        for x in photon.wi.to_array().into_iter().chain(photon.flux.to_array()) {
            bytes.extend((x as f32).to_le_bytes());
        }
        bytes.extend(photon.bounces.to_le_bytes());
        bytes.extend(photon.shape.to_le_bytes());
    }
    bytes
}
