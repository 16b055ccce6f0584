// Points in a program's memory, as the NumPy file they would be: a cloud without a detour over the disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "src/input/bytes/byte_source.h"

namespace tessera {

// `coordinates`: n x dimension, row after row. They must stay where they are, and as they are, while the source is
// read. Errors call it `name`. REQUIRES: dimension divides coordinates.size().
std::unique_ptr<ByteSource> array_source(const std::string& name, std::span<const double> coordinates, int dimension);

// `rows` of named columns, `columns` as the header of a NumPy file has them: "[('x', '<f8'), ('y', '<f8')]". What is
// wrong with them is told when the source is opened.
std::unique_ptr<ByteSource> record_source(const std::string& name, std::span<const std::byte> bytes,
                                          const std::string& columns, std::uint64_t rows);

}  // namespace tessera
