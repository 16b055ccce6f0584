// Points in a program's memory, presented as a NumPy file, so that a cloud needs no file on disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "src/input/bytes/byte_source.h"

namespace tessera {

// A source of n x dimension coordinates, row after row. The array must neither move nor change while the source is
// read. Errors call it `name`. REQUIRES: dimension divides coordinates.size().
std::unique_ptr<ByteSource> array_source(const std::string& name, std::span<const double> coordinates, int dimension);

// A source of `rows` rows with named columns. `columns` is what the header of a NumPy file says: "[('x', '<f8'), ('y',
// '<f8')]". Mistakes in it are reported when the source is opened by a reader.
std::unique_ptr<ByteSource> record_source(const std::string& name, std::span<const std::byte> bytes,
                                          const std::string& columns, std::uint64_t rows);

}  // namespace tessera
