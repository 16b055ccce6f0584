// Coordinates in a program's memory, as the NumPy file they would be: a cloud without a detour over the disk.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "src/io/bytes/byte_source.h"

namespace tessera {

// `coordinates`: n x dimension, row after row. They must stay where they are, and as they are, while the source is
// read. Errors call it `name`. REQUIRES: dimension divides coordinates.size().
std::unique_ptr<ByteSource> array_source(const std::string& name, std::span<const double> coordinates, int dimension);

}  // namespace tessera
