#include "src/result/terrain/sample_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

namespace tessera::terrain {
namespace {

// A value is stored as its bits, exclusive or those of this NaN. So a hole, which reads as zeros, is no value.
constexpr std::uint64_t no_value = std::bit_cast<std::uint64_t>(std::numeric_limits<double>::quiet_NaN());

std::uint64_t stored(double value) { return std::bit_cast<std::uint64_t>(value) ^ no_value; }
double loaded(std::uint64_t bits) { return std::bit_cast<double>(bits ^ no_value); }

}  // namespace

Result<SampleFile> SampleFile::create(const std::filesystem::path& folder, const Grid& grid) {
  BOOST_OUTCOME_TRY(file, nameless_file(folder));
  return SampleFile(std::move(file), folder, grid);
}

Status SampleFile::add(Blocks& blocks) const {
  Status status = success();
  blocks.take([&](std::int64_t x, std::int64_t y, const Block& block) {
    const std::int64_t width = std::min(block_side, grid_.width - x), height = std::min(block_side, grid_.height - y);
    std::uint64_t run[block_side];
    for (std::int64_t line = 0; line < height; ++line) {
      const double* pixels = block.pixels + line * block_side;
      // Writes runs of drawn pixels, because other threads may draw the pixels between.
      for (std::int64_t begin = 0, end = 0; status && begin < width; begin = end + 1) {
        for (end = begin; end < width && !std::isnan(pixels[end]); ++end) run[end - begin] = stored(pixels[end]);
        if (end == begin) continue;
        const auto drawn = std::span(run).first(static_cast<std::size_t>(end - begin));
        // Lines are counted from the top, rows from the bottom.
        status = write_at(file_.get(), std::as_bytes(drawn),
                          offset(grid_.column0 + x + begin, grid_.row0 + grid_.height - 1 - (y + line)), folder_);
      }
    }
  });
  return status;
}

Status SampleFile::read(const Grid& part, std::vector<double>& values) const {
  values.assign(static_cast<std::size_t>(part.width * part.height), std::numeric_limits<double>::quiet_NaN());
  const std::int64_t left = std::max(part.column0, grid_.column0),
                     right = std::min(part.column0 + part.width, grid_.column0 + grid_.width);
  if (left >= right) return success();
  std::vector<std::uint64_t> bits(static_cast<std::size_t>(right - left));
  for (std::int64_t row = std::max(part.row0, grid_.row0);
       row < std::min(part.row0 + part.height, grid_.row0 + grid_.height); ++row) {
    const auto bytes = std::as_writable_bytes(std::span(bits));
    BOOST_OUTCOME_TRY(count, read_up_to(file_.get(), bytes, offset(left, row), folder_));
    // The file ends with the last pixel that was drawn.
    std::memset(bytes.data() + count, 0, bytes.size() - count);
    double* to = values.data() + (row - part.row0) * part.width + (left - part.column0);
    std::transform(bits.begin(), bits.end(), to, loaded);
  }
  return success();
}

}  // namespace tessera::terrain
