#include "src/result/store/points_blocks.h"

#include <algorithm>
#include <cstdint>
#include <span>

#include "src/base/files/checksum.h"

namespace tessera::store {

void append_column(const Column& values, ColumnBlocks& blocks, PointsHead& head, BigVector<std::byte>& to) {
  for (std::size_t row = 0; row < values.rows; row += block_rows) {
    const std::size_t begin = to.size();
    blocks.append(values.part(row, std::min<std::size_t>(row + block_rows, values.rows)), to);
    const auto block = std::span(to).subspan(begin);
    head.blocks.push_back({static_cast<std::uint32_t>(block.size()), checksum(block, head.blocks.size())});
  }
}

}  // namespace tessera::store
