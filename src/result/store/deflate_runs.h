// Deflates data that hardly changes, forty times as fast as zlib: this code only looks for repetitions of the last
// element. It is meant for flags and owners, whose blocks mostly hold one value, or a few runs.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tessera::store {

// Returns a zlib stream of `bytes`: one block with the fixed codes of RFC 1951, or a stored block where that is
// smaller. `size` is the size of an element, 1 to 4 bytes. REQUIRES: at most 65535 bytes.
std::vector<std::byte> deflate_runs(std::span<const std::byte> bytes, std::size_t size);

}  // namespace tessera::store
