// PCD files (Point Cloud Library): points as text, as binary records, or as compressed columns.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Whether `begin` is the beginning of a PCD file: a comment "# .PCD v0.7", or the first line of the header.
bool looks_like_pcd(std::string_view begin);

// Opens a PCD file. Fields other than x, y and z are attributes. The packed colours "rgb" and "rgba" become the
// attributes red, green, blue and alpha. A field with several numbers, such as a histogram, becomes an attribute for
// each: name_1, name_2, and so on. Fields called "_" are padding. The viewpoint is not applied, as in PCL.
Result<std::unique_ptr<PointReader>> open_pcd(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera
