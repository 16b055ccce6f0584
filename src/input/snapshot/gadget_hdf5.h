// Snapshots in HDF5, as Gadget-3 and Gadget-4, AREPO, GIZMO and SWIFT write them: a group for each type of particles.
// Source: V. Springel et al., GADGET-4 (2021), section on file formats; the user guides of AREPO and SWIFT.
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

// Whether a file begins as HDF5 does.
bool looks_like_hdf5(std::span<const std::byte> begin);

// Reads the particles of all types, type by type. Positions come from Coordinates, or from IntegerCoordinates and the
// size of the box. Attributes are particle_type (0 to 5), vx, vy, vz, particle_id, mass, and all other tables with a
// number, or a few, for each particle, by their names: Density, StarFormationRate, ... Where a type has no such table,
// the attribute is NaN, or 0 as an integer. Of hints.particles, only the types that are named are
// looked at. Errors: those of Hdf5File; bad_input for a file without such groups, and for tables that do not fit the
// header.
Result<std::unique_ptr<PointReader>> open_gadget_hdf5(std::unique_ptr<ByteSource> source,
                                                      const std::vector<Attribute>& attributes, const ReadHints& hints);

// From now on this process refuses HDF5. The library of HDF5 was not made for files of strangers: damaged ones have
// made it read and write beyond its memory. So a service reads such files only when its operator says so.
void refuse_hdf5();

}  // namespace tessera::snapshot
