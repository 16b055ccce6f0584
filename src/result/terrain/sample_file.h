// The pixels of a grid on disk: several threads draw them in any order, and they are read back in parts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/terrain/blocks.h"
#include "src/result/terrain/grid.h"

namespace tessera::terrain {

// An unnamed file with 8 bytes a pixel. Pixels without a value take no room where the file system has holes.
class SampleFile {
 public:
  // Errors, here and below: io, and those of the thread's ledger.
  static Result<SampleFile> create(const std::filesystem::path& folder, const Grid& grid);
  const Grid& grid() const { return grid_; }
  // Takes the pixels that were drawn, and leaves none in `blocks`. Safe to call from several threads.
  Status add(Blocks& blocks) const;
  // The values of `part`, row by row from the lowest; NaN where nothing was drawn, and outside the grid.
  Status read(const Grid& part, std::vector<double>& values) const;

 private:
  SampleFile(FileHandle file, std::filesystem::path folder, const Grid& grid)
      : file_(std::move(file)), folder_(std::move(folder)), grid_(grid) {}
  std::uint64_t offset(std::int64_t column, std::int64_t row) const {
    return static_cast<std::uint64_t>((row - grid_.row0) * grid_.width + column - grid_.column0) * sizeof(double);
  }

  FileHandle file_;
  std::filesystem::path folder_;
  Grid grid_;
};

}  // namespace tessera::terrain
