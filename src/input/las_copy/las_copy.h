// Copies of LAS and LAZ files in which each point has further dimensions, as extra bytes. Nothing else changes: point
// records, header and records of variable length are those of the input, bit for bit and in the same order.
// Source: ASPRS, LAS Specification 1.4 - R15 (2019); rapidlasso, LAZ Specification 1.4.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/las_copy/extra_bytes.h"

namespace tessera {

enum class LasPacking : std::uint8_t { as_input, las, laz };

struct LasCopyOptions {
  LasPacking packing = LasPacking::as_input;
  std::vector<ExtraDimension> dimensions = {};  // with names that differ
  bool replace = false;                         // whether dimensions of the input with these names are left out
  unsigned threads = 1;                         // for LAZ, each with a chunk of points in memory
  std::stop_token stop = {};
};

// Fills `values` for consecutive records, the first of which has the rank `first` in the file: for each record one
// value for each dimension. The calls follow each other in the order of the file. An error ends the copy and is its
// error.
using DimensionValues = std::function<Status(std::uint64_t first, std::span<double> values)>;

// Copies `source` to the file `to`, and returns the number of points. `to` may be the file of `source`: it appears
// whole or not at all, and is replaced. The memory used does not depend on the number of points, but on the largest
// chunk of a LAZ file.
//
// What differs in the copy, besides what LAS says of places and lengths: records for extra bytes and LASzip, where the
// options ask for them; the places in a COPC hierarchy. A compressed copy of a compressed file has chunks of the same
// points. Bytes of the file that belong to nothing, such as those behind the last point, are left out, and so are the
// records of LASzip and COPC in an uncompressed copy.
//
// Waveforms (point formats 4, 5, 9 and 10) stay where they are: in the file's own record, which is copied, or in a file
// beside it with the ending .wdp, which is not.
//
// The descriptors of the new dimensions tell the least and the greatest value, without NaN.
//
// Errors: bad_input for input that is not LAS, is damaged, holds waveforms and is or would be compressed, has a
// dimension of the same name (unless options.replace), or whose records would become too long; io; interrupted. No file
// is left then, and a file that was there before is as it was.
// REQUIRES: `values` may be empty only without dimensions.
Result<std::uint64_t> copy_las(std::unique_ptr<ByteSource> source, const std::filesystem::path& to,
                               const LasCopyOptions& options, const DimensionValues& values);

}  // namespace tessera
