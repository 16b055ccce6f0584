// What is known of a cloud in EPT once its ept.json and its hierarchy were read.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/far_source.h"
#include "src/input/ept/ept_files.h"
#include "src/input/ept/ept_info.h"
#include "src/input/ept/ept_nodes.h"
#include "src/input/file_part.h"

namespace tessera::ept {

struct Known : Learnt {
  Info info;
  std::vector<Node> nodes;            // those with points, in the order of the cloud
  std::vector<Attribute> attributes;  // of LAZ tiles those of the first tile
  Files files;
};

// Reads the cloud. What was read of a cloud on a server is kept with its source, up to a million nodes, so that the
// hierarchy is read once, however often the cloud is opened. Errors: those of read_info(), read_nodes() and
// open_tile(); bad_input for a cloud without points.
Result<std::shared_ptr<const Known>> know(const ByteSource& source);

// The nodes that `resolution` needs as parts of the cloud. Their bytes are estimates for compressed tiles.
Result<std::vector<FilePart>> read_parts(const ByteSource& source, double resolution);

// Fetches the tiles of these parts, many at once, if the cloud is on a server. REQUIRES: read_parts() returned them.
Status bring_parts(const ByteSource& source, std::span<const FilePart> parts);

}  // namespace tessera::ept
