// Fetches chunks before they are decoded, when the file is far away.
#pragma once

#include <cstddef>
#include <span>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/laz/chunk_decoder.h"
#include "src/input/laz/laz_layout.h"

namespace tessera::laz {

// Fetches what decoding these chunks will read: of layered chunks only the layers that are wanted. Does nothing when
// the source is near. Errors: those of FarSource::bring().
Status bring_chunks(const ByteSource& source, const LazLayout& layout, const WantedFields& plan,
                    std::span<const Chunk> chunks);

// For chunks_at_once(). Chunks of 50,000 points, some 300 kB: 10 MB, enough for a slow way to a fast server.
inline constexpr std::size_t chunks_ahead_max = 32;

// How many of the next chunks are worth bringing at a time: at least one, at most `most`, and not more than what the
// source can keep.
std::size_t chunks_at_once(const ByteSource& source, std::span<const Chunk> chunks, std::size_t most);

}  // namespace tessera::laz
