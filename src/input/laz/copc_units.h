// The parts of a COPC file that can be read by themselves.
#pragma once

#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/file_part.h"

namespace tessera::laz {

// Returns the nodes with points that `resolution` needs (see ReadHints), in the order of the file. Reads no points.
// Error bad_input: those of the header, the chunk table and the hierarchy. With resolution 0 also a chunk that is no
// node, because the file does not say where its points are. REQUIRES: the file is COPC.
Result<std::vector<FilePart>> read_copc_units(const ByteSource& source, double resolution);

// Fetches what reading rows of these attributes will read of units of a file that is far; see FarSource::bring(). Does
// nothing for other files.
Status bring_copc_units(const ByteSource& source, const std::vector<Attribute>& attributes,
                        std::span<const FilePart> units);

}  // namespace tessera::laz
