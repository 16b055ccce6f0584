// The places of the chunks in a LAZ file.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/laz/chunk_decoder.h"
#include "src/input/laz/laz_layout.h"

namespace tessera::laz {

// Returns the chunks of the `points` points whose bytes begin at `points_at`, in the order of the file. Together they
// have all points. A file that is not chunked is one chunk. Error bad_input, naming the file: there is no table,
// because the file was not finished; the chunks do not fit the file or the number of points; there are more chunks than
// bytes permit.
// Source: rapidlasso, LAZ Specification 1.4.
Result<std::vector<Chunk>> read_chunk_table(const ByteSource& source, const LazLayout& layout, std::uint64_t points_at,
                                            std::uint64_t points, std::size_t record_bytes);

}  // namespace tessera::laz
