// Points to a file: LAS, PLY, NumPy or text, by the extension.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

struct WriterOptions {
  int dimension = 3;         // 2: PLY, NumPy and text files have no z; in LAS it is 0
  std::uint64_t points = 0;  // how many will be written: exactly that many must be
  Bounds bounds = {};        // holds them all; LAS needs it to choose its steps
  double step = 0;           // coordinates are multiples of this power of ten; 0 if they are not
};

// .las: LAS 1.4, point format 0. Coordinates become 32-bit integers: multiples of `step`, else of the least power of
// ten
//   with which `bounds` fits (1e-9 for the unit cube). Nothing else loses anything:
// .ply: binary little endian, double.  .npy: n x dimension, f8.
// .xyz, .txt: blanks between, .csv: commas and a header; the shortest decimals that read back as the same doubles.
class PointWriter {
 public:
  virtual ~PointWriter() = default;
  // `classes`: the LAS classification of each point, or empty. Formats other than LAS do not keep it.
  // Errors io; bad_input if a point lies outside `bounds` so far that LAS cannot hold it.
  virtual Status write(std::span<const Point> points, std::span<const std::uint8_t> classes) = 0;
  // Completes the file under its name; until then it has another, and without this call it is removed.
  virtual Status finish() = 0;
};

// Errors: usage if no writer has this extension, io.
Result<std::unique_ptr<PointWriter>> open_writer(const std::filesystem::path& path, const WriterOptions& options);

}  // namespace tessera
