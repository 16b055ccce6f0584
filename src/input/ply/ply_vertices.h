// The vertices of a PLY body as records of equal length, however the body is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/ply/ply_header.h"

namespace tessera {

// Reads the vertices of one file. Not thread-safe.
class PlyVertices {
 public:
  // Where a scalar property is in a record.
  struct Scalar {
    std::size_t property;  // its index in the element's list
    std::size_t offset;
    AttributeType stored;  // f64 if the file is text
    bool swapped;
  };

  virtual ~PlyVertices() = default;
  // The next records, at most `most`. They are valid until the next call. Empty at the end.
  virtual Result<std::span<const std::byte>> next(std::size_t most) = 0;
  virtual bool seek(std::uint64_t index) = 0;
  virtual std::string place(std::size_t index) const = 0;

  const std::vector<Scalar>& scalars() const { return scalars_; }
  std::size_t record_bytes() const { return record_bytes_; }

 protected:
  std::vector<Scalar> scalars_;
  std::size_t record_bytes_ = 0;
};

// Opens the vertices behind the elements before them. Error bad_input if the file is shorter than its header promises.
Result<std::unique_ptr<PlyVertices>> open_ply_vertices(std::unique_ptr<ByteSource> source, const PlyHeader& header);

}  // namespace tessera
