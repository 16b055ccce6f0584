#include "src/input/laz/chunks_ahead.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "src/input/bytes/far_source.h"
#include "src/input/bytes/fields.h"

namespace tessera::laz {
namespace {

// The bytes of a record that a layer holds.
struct LayerField {
  std::size_t at, bytes;
};

// The layers in the order of the chunk. Source: LAZ specification 1.4, "layered chunks".
std::vector<LayerField> layers_of(const LazLayout& layout, std::size_t record_bytes) {
  std::vector<LayerField> layers{{0, 8}, {8, 4}, {16, 1}, {15, 1}, {12, 2}, {18, 2}, {17, 1}, {20, 2}, {22, 8}};
  std::size_t at = 30;
  const bool rgb = layout.items.size() > 1 && layout.items[1].type != ItemType::byte_14;
  const bool nir = rgb && layout.items[1].type == ItemType::rgb_nir_14;
  if (rgb) layers.push_back({at, 6});
  at += rgb ? 6 : 0;
  if (nir) layers.push_back({at, 2});
  at += nir ? 2 : 0;
  for (; at < record_bytes; ++at) layers.push_back({at, 1});
  return layers;
}

bool is_wanted(const LayerField& layer, const WantedFields& plan) {
  if (layer.at <= 8) return true;  // x, y, z
  for (std::size_t i = layer.at; i < layer.at + layer.bytes && i < plan.wanted.size(); ++i)
    if (plan.wanted[i]) return true;
  return false;
}

}  // namespace

Status bring_chunks(const ByteSource& source, const LazLayout& layout, const WantedFields& plan,
                    std::span<const Chunk> chunks) {
  if (near_bytes_max(source) == 0) return success();
  const auto layers = layers_of(layout, plan.record_bytes);
  const bool all = std::all_of(layers.begin(), layers.end(), [&](const auto& layer) { return is_wanted(layer, plan); });
  std::vector<ByteRange> ranges;
  if (layout.compressor != Compressor::layered_chunked || all) {
    for (const auto& chunk : chunks) ranges.push_back({chunk.begin, chunk.end});
    return bring_near(source, ranges);
  }
  const std::uint64_t lengths_at = plan.record_bytes + 4, head_bytes = lengths_at + 4 * layers.size();
  for (const auto& chunk : chunks) ranges.push_back({chunk.begin, std::min(chunk.end, chunk.begin + head_bytes)});
  BOOST_OUTCOME_TRYV(bring_near(source, ranges));
  ranges.clear();
  std::vector<std::byte> lengths(4 * layers.size());
  for (const auto& chunk : chunks) {
    if (chunk.end - chunk.begin < head_bytes) continue;  // the decoder reports such a chunk
    BOOST_OUTCOME_TRYV(source.read(chunk.begin + lengths_at, lengths));
    std::uint64_t at = chunk.begin + head_bytes;
    for (std::size_t i = 0; i < layers.size(); ++i) {
      const std::uint64_t end = std::min<std::uint64_t>(chunk.end, at + load<std::uint32_t>(lengths.data() + 4 * i));
      if (is_wanted(layers[i], plan) && at < end) ranges.push_back({at, end});
      at = end;
    }
  }
  return bring_near(source, ranges);
}

std::size_t chunks_at_once(const ByteSource& source, std::span<const Chunk> chunks, std::size_t most) {
  std::uint64_t left = near_bytes_max(source) / 2;  // what is brought now must not push out what is still being read
  std::size_t n = 0;
  for (; n < chunks.size() && n < most; ++n) {
    const std::uint64_t bytes = chunks[n].end - chunks[n].begin;
    if (n > 0 && bytes > left) break;
    left -= std::min(left, bytes);
  }
  return n;
}

}  // namespace tessera::laz
