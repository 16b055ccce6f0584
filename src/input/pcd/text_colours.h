// Colours that a PCD file stores as one number a point, in text.
#pragma once

#include <cstddef>
#include <memory>

#include "src/input/ply/ply_vertices.h"

namespace tessera {

// Replaces the property `colour` of `element` by the properties red, green, blue and, for "rgba", alpha, from 0 to 255.
// The number in the text is a whole number with the bytes alpha, red, green, blue, the highest first, or the
// floating-point number of 32 bits that has these bytes, as old versions of PCL write.
std::unique_ptr<PlyVertices> unpack_text_colours(std::unique_ptr<PlyVertices> vertices, std::size_t colour,
                                                 PlyElement& element);

}  // namespace tessera
