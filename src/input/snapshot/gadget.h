// Snapshots of Gadget in its binary formats 1 and 2, of both byte orders.
// Source: V. Springel, User guide for GADGET-2 (2005), section 6: blocks with their length before and behind them.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera::snapshot {

// Whether a file begins like a snapshot: with the header's length, or with the label of the header in format 2.
bool looks_like_gadget(std::span<const std::byte> begin);

// Reads positions, and as attributes particle_type (0 to 5), velocities vx, vy, vz, particle_id and mass; for gas also
// internal_energy, gas_density and smoothing_length, where the file has them. Errors: bad_input for blocks that end
// early, or have other lengths than the header's numbers of particles say. Of hints.particles, only the types that are
// named are read; attributes that none of them has are left out.
Result<std::unique_ptr<PointReader>> open_gadget(std::unique_ptr<ByteSource> source,
                                                 const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera::snapshot
