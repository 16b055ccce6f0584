// Pixels that a thread has drawn and not yet handed over, in square blocks of the raster.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>

#include "src/result/terrain/grid.h"

namespace tessera::terrain {

constexpr std::int64_t block_side = 256;

// Line by line from the top; NaN where nothing was drawn.
struct Block {
  double pixels[block_side * block_side];
  std::int64_t drawn = 0;
};

class Blocks {
 public:
  explicit Blocks(const Grid& grid) : grid_(grid), across_((grid.width + block_side - 1) / block_side) {}

  // Returns true if the pixel had no value before. NaN is not drawn.
  bool put(std::int64_t column, std::int64_t row, double value) {
    if (std::isnan(value)) return true;
    const std::int64_t x = column - grid_.column0, y = grid_.line(row);
    const std::int64_t number = y / block_side * across_ + x / block_side;
    if (number != last_) {
      auto& block = blocks_[number];
      if (!block) block = make();
      last_ = number;
      last_block_ = block.get();
    }
    double& pixel = last_block_->pixels[y % block_side * block_side + x % block_side];
    const bool is_new = std::isnan(pixel);
    pixel = value;
    ++last_block_->drawn;
    return is_new;
  }

  std::size_t bytes() const { return blocks_.size() * sizeof(Block); }
  // Calls visit(x, y, block) for each block, with the position of its first pixel from the left and from the top; then
  // removes all blocks.
  template <class Visit>
  void take(const Visit& visit) {
    for (const auto& [number, block] : blocks_)
      visit(number % across_ * block_side, number / across_ * block_side, *block);
    blocks_.clear();
    last_ = -1;
  }

 private:
  static std::unique_ptr<Block> make() {
    auto block = std::make_unique_for_overwrite<Block>();
    for (double& pixel : block->pixels) pixel = std::numeric_limits<double>::quiet_NaN();
    block->drawn = 0;
    return block;
  }

  Grid grid_;
  std::int64_t across_;
  std::unordered_map<std::int64_t, std::unique_ptr<Block>> blocks_;  // by number, line by line
  std::int64_t last_ = -1;
  Block* last_block_ = nullptr;
};

}  // namespace tessera::terrain
