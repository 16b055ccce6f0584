// The sums of all voxels. They are kept in a file, in blocks, so a grid may be larger than memory. Each thread adds to
// blocks of its own, and hands them over. The sums do not depend on the order (order_free_sum.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/density/voxel_grid.h"
#include "src/result/measure/order_free_sum.h"

namespace tessera::density {

// A block is a square of pixels, or a cube of voxels.
inline constexpr std::int64_t voxels_a_block = 4096;
constexpr std::int64_t block_side_of(int dimension) { return dimension == 2 ? 64 : 16; }

// How the grid is cut into blocks.
struct Blocking {
  explicit Blocking(const VoxelGrid& grid) : first(grid.first), side(block_side_of(grid.dimension)) {
    for (std::size_t axis = 0; axis < 3; ++axis) blocks[axis] = (grid.size[axis] + side - 1) / side;
    if (grid.dimension == 2) blocks[2] = 1;
  }
  struct Place {
    std::int64_t block = 0, voxel = 0;
  };
  // `at` is counted as the grid's `first`.
  Place of(const std::array<std::int64_t, 3>& at) const {
    Place place;
    for (std::size_t axis = 3; axis-- > 0;) {
      const std::int64_t i = at[axis] - first[axis];
      place.block = place.block * blocks[axis] + i / side;
      place.voxel = place.voxel * side + i % side;
    }
    return place;
  }
  std::int64_t number(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return (z * blocks[1] + y) * blocks[0] + x;
  }

  std::array<std::int64_t, 3> first;
  std::int64_t side;
  std::array<std::int64_t, 3> blocks{1, 1, 1};
};

// The sums of a block: `sums` of each voxel, one after the other.
using BlockSums = std::vector<OrderFreeSum>;

class ThreadSums {
 public:
  ThreadSums(const VoxelGrid& grid, std::size_t sums) : blocking_(grid), sums_(sums) {}

  // The sums of a voxel, until the next call.
  OrderFreeSum* at(const std::array<std::int64_t, 3>& voxel) {
    const Blocking::Place place = blocking_.of(voxel);
    if (place.block != last_ || last_block_ == nullptr) {
      auto& block = blocks_[place.block];
      if (!block) block = std::make_unique<BlockSums>(static_cast<std::size_t>(voxels_a_block) * sums_);
      last_ = place.block;
      last_block_ = block.get();
    }
    return last_block_->data() + static_cast<std::size_t>(place.voxel) * sums_;
  }
  std::size_t bytes() const { return blocks_.size() * block_bytes(sums_); }
  static std::size_t block_bytes(std::size_t sums) {
    return static_cast<std::size_t>(voxels_a_block) * sums * sizeof(OrderFreeSum);
  }
  // The blocks by number; they are gone afterwards.
  auto take() {
    last_block_ = nullptr;
    return std::exchange(blocks_, {});
  }

 private:
  Blocking blocking_;
  std::size_t sums_;
  std::unordered_map<std::int64_t, std::unique_ptr<BlockSums>> blocks_;
  std::int64_t last_ = 0;
  BlockSums* last_block_ = nullptr;
};

class SumFile {
 public:
  // Makes a file without a name in `folder`, with `sums` sums a voxel. Errors here and below: io.
  static Result<SumFile> create(const std::filesystem::path& folder, std::size_t sums);

  // Adds the sums of a thread, which are gone afterwards. Safe to call from several threads.
  Status add(ThreadSums& more);
  // Reads a block. Returns false when nothing was added to it; then `block` is as it was.
  Result<bool> read(std::int64_t number, BlockSums& block) const;
  std::size_t sums() const { return sums_; }

 private:
  SumFile(std::filesystem::path folder, FileHandle file, std::size_t sums)
      : folder_(std::move(folder)), file_(std::move(file)), sums_(sums), mutex_(std::make_unique<std::mutex>()) {}

  std::filesystem::path folder_;
  FileHandle file_;
  std::size_t sums_;
  std::unique_ptr<std::mutex> mutex_;
  std::unordered_map<std::int64_t, std::uint64_t> places_;  // of blocks in the file, by number
};

}  // namespace tessera::density
