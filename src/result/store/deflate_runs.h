// Deflates what hardly changes, forty times as fast as zlib: it looks for repetitions of the last element alone. For
// flags and owners, of which most blocks are one value throughout, or a few runs.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tessera::store {

// A zlib stream of `bytes`: a block with the fixed codes of RFC 1951, or a stored one where that is smaller. `size`: of
// an element, 1 to 4 bytes. REQUIRES: at most 65535 bytes.
std::vector<std::byte> deflate_runs(std::span<const std::byte> bytes, std::size_t size);

}  // namespace tessera::store
