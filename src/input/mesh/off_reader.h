// OFF (Geomview's object file format) as text: OFF, COFF, NOFF, STOFF and their combinations. The vertices are the
// points. Their normals, colours and texture coordinates are attributes. Faces are skipped.
// Source: Geomview manual, 4.2.5 OFF Files.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Whether `begin` is the beginning of an OFF file: "OFF", "COFF 8 6 12", "nOFF", ..., perhaps after comments.
bool looks_like_off(std::string_view begin);

// Opens an OFF file. Each vertex has a line of its own. The first vertex tells whether colours have alpha.
Result<std::unique_ptr<PointReader>> open_off(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera
