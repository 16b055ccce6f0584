// OFF (Geomview's object file format) in text: OFF, COFF, NOFF, STOFF and their combinations. The vertices are the
// points, their normals, colours and texture coordinates the attributes; faces are skipped.
// Source: Geomview manual, 4.2.5 OFF Files.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Whether a file that begins with `begin` is OFF: "OFF", "COFF 8 6 12", "nOFF", ..., perhaps below comments.
bool looks_like_off(std::string_view begin);

// A vertex takes a line; of colours, the first vertex tells whether there is alpha.
Result<std::unique_ptr<PointReader>> open_off(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera
