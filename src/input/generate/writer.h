// Writes points to a file: LAS, PLY, NumPy or text, by the extension.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

struct WriterOptions {
  int dimension = 3;         // 2: PLY, NumPy and text files have no z, and LAS files have z = 0
  std::uint64_t points = 0;  // exactly so many points must be written
  Bounds bounds = {};        // a box around all points, from which LAS chooses its steps
  double step = 0;           // a power of ten of which coordinates are multiples; 0 if there is none
};

// Writes the points of one file. The formats:
//   .las: LAS 1.4, point format 0. Coordinates become 32-bit integers: multiples of `step`, or else of the least power
//         of ten with which `bounds` fits (1e-9 for the unit cube). The other formats lose nothing.
//   .ply: binary little endian, double.
//   .npy: n x dimension, f8.
//   .xyz, .txt: the shortest decimals that are read back as the same doubles, with blanks between them.
//   .csv: the same with commas, and a header.
class PointWriter {
 public:
  virtual ~PointWriter() = default;
  // Writes points. `classes` has the LAS class of each point, or is empty; only LAS files store it. Errors: io;
  // bad_input if a point lies so far outside `bounds` that LAS cannot store it.
  virtual Status write(std::span<const Point> points, std::span<const std::uint8_t> classes) = 0;
  // Completes the file and gives it its name. Without this call the file is removed.
  virtual Status finish() = 0;
};

// Errors: usage if no writer has this extension; io.
Result<std::unique_ptr<PointWriter>> open_writer(const std::filesystem::path& path, const WriterOptions& options);

}  // namespace tessera
