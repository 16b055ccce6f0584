// duplicates.bin while it is written: there may be more pairs than fit into memory.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::store {

struct WrittenPairs {
  std::uint64_t count = 0;
  std::uint64_t xxh3 = 0;  // XXH3-64 of the file; 0 when there is none
};
// Writes the pairs, ascending, or removes the file of an earlier result when there are none. Ends the sorter's life.
Result<WrittenPairs> write_duplicates(const std::filesystem::path& out, DuplicateSort& pairs);

}  // namespace tessera::store
