#include "src/input/las_copy/chunk_encoder.h"

namespace tessera::laz {

std::unique_ptr<ChunkEncoder> make_chunk_encoder(const LazLayout& layout, std::size_t record_bytes) {
  if (layout.compressor == Compressor::layered_chunked) return make_layered_encoder(layout, record_bytes);
  return make_pointwise_encoder(layout, record_bytes);
}

}  // namespace tessera::laz
