// Snapshots in Tipsy's binary format, of both byte orders.
// Source: N. Katz and T. Quinn, TIPSY: header of 28 or 32 bytes, then the records of gas, dark matter and stars.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera::snapshot {

// Whether these are the first bytes of such a snapshot. The format has no typical first bytes: the numbers of particles
// in the header must add up, and must fit the size of the file exactly.
bool is_tipsy(std::span<const std::byte> begin, std::optional<std::uint64_t> size);

// Reads positions, and as attributes particle_type (0: gas, 1: dark matter, 4: stars, as in Gadget), mass, vx, vy, vz,
// potential, softening; of gas gas_density, temperature and smoothing_length; of stars formation_time; of both metals.
// Of hints.particles, only the types that are named are read. REQUIRES: is_tipsy().
Result<std::unique_ptr<PointReader>> open_tipsy(std::unique_ptr<ByteSource> source,
                                                const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera::snapshot
