// The hierarchy of a COPC file whose chunks were compressed anew, and so lie at other places.
// Source: Hobu, Cloud Optimized Point Cloud Specification 1.0 (2021).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/las_copy/las_parts.h"
#include "src/input/laz/chunk_decoder.h"

namespace tessera::laz {

// Rewrites the hierarchy pages in the extended records of `parts` for a copy. The copy has its first extended record at
// byte `extended_at`, and the chunks `to`, where the input has `from`. Rewrites the place of the root page in `info`,
// the payload of the COPC info record. Error bad_input, naming `source`: a page that is in no hierarchy record, pages
// in a circle, a node that is no chunk. REQUIRES: from and to have the same length and order, and no empty chunk.
Status move_copc_hierarchy(const ByteSource& source, LasParts& parts, std::span<const Chunk> from,
                           std::span<const Chunk> to, std::uint64_t extended_at, std::vector<std::byte>& info);

}  // namespace tessera::laz
