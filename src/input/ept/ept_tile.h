// One tile of a cloud in EPT as a stream of points.
#pragma once

#include <memory>
#include <vector>

#include "src/input/ept/ept_info.h"
#include "src/input/ept/ept_nodes.h"
#include "src/input/reader.h"

namespace tessera::ept {

struct Known;

// Opens the tile of a node. `ept`: the source of ept.json. Attributes are called as in LAS. Errors: those of reading;
// bad_input when the tile has another number of points than the hierarchy says, or is not of the kind that ept.json
// says.
Result<std::unique_ptr<PointReader>> open_tile(const ByteSource& ept, const Known& known, const Node& node,
                                               const std::vector<Attribute>& attributes, std::uint32_t threads);

// The attributes of binary tiles: all dimensions but the coordinates.
std::vector<Attribute> attributes_of(const Info& info);

}  // namespace tessera::ept
