#include "src/input/laz/laz_layout.h"

#include <algorithm>

#include "src/input/bytes/fields.h"

namespace tessera::laz {
namespace {

struct Expected {
  ItemType type;
  std::uint16_t bytes;
};

constexpr std::uint16_t wave_packet_bytes = 29;

std::vector<Expected> items_of(int point_format, std::uint16_t record_bytes) {
  using enum ItemType;
  std::vector<Expected> items;
  const bool layered = point_format >= 6;
  if (layered) {
    items.push_back({point_14, 30});
    if (point_format == 7) items.push_back({rgb_14, 6});
    if (point_format == 8 || point_format == 10) items.push_back({rgb_nir_14, 8});
    if (point_format >= 9) items.push_back({wave_packet_14, wave_packet_bytes});
  } else {
    items.push_back({point_10, 20});
    if (point_format != 0 && point_format != 2) items.push_back({gps_time_11, 8});
    if (point_format == 2 || point_format == 3 || point_format == 5) items.push_back({rgb_12, 6});
    if (point_format >= 4) items.push_back({wave_packet_13, wave_packet_bytes});
  }
  std::uint16_t bytes = 0;
  for (const auto& item : items) bytes = static_cast<std::uint16_t>(bytes + item.bytes);
  if (record_bytes > bytes)
    items.push_back({layered ? byte_14 : byte, static_cast<std::uint16_t>(record_bytes - bytes)});
  return items;
}

}  // namespace

Result<LazLayout> read_laz_layout(const std::string& path, std::span<const std::byte> record, int point_format,
                                  std::uint16_t record_bytes) {
  constexpr std::size_t head_bytes = 34, item_bytes = 6;
  const auto bad = [&](const std::string& what) { return error(Errc::bad_input, path + ", LASzip record: " + what); };
  if (record.size() < head_bytes) return bad("has " + std::to_string(record.size()) + " bytes, fewer than its head");
  const auto* at = record.data();
  const auto compressor = load<std::uint16_t>(at), coder = load<std::uint16_t>(at + 2);
  if (compressor > 3) return bad("names compressor " + std::to_string(compressor) + "; 0 to 3 are known");
  if (coder != 0) return bad("names coder " + std::to_string(coder) + "; only 0, arithmetic coding, is known");
  LazLayout layout;
  layout.compressor = static_cast<Compressor>(compressor);
  layout.chunk_points = load<std::uint32_t>(at + 12);
  if (layout.chunked() && layout.chunk_points == 0) return bad("says that chunks have 0 points");
  const std::size_t count = load<std::uint16_t>(at + 32);
  if (record.size() < head_bytes + item_bytes * count)
    return bad("announces " + std::to_string(count) + " items, but ends before the last");

  const auto expected = items_of(point_format, record_bytes);
  const std::string of_format =
      " of point format " + std::to_string(point_format) + " in " + std::to_string(record_bytes) + " bytes";
  if (count != expected.size())
    return bad("lists " + std::to_string(count) + " items, not the " + std::to_string(expected.size()) + of_format);
  if (expected.back().bytes > extra_bytes_max)
    return bad("describes " + std::to_string(expected.back().bytes) + " extra bytes a point; at most " +
               std::to_string(extra_bytes_max) + " are read");
  const bool layered = point_format >= 6;
  if (layout.compressor != Compressor::none && layered != (layout.compressor == Compressor::layered_chunked))
    return bad("names compressor " + std::to_string(compressor) + ", which is not for point format " +
               std::to_string(point_format));
  for (std::size_t i = 0; i < count; ++i) {
    const auto* item = at + head_bytes + item_bytes * i;
    const auto type = load<std::uint16_t>(item), bytes = load<std::uint16_t>(item + 2),
               version = load<std::uint16_t>(item + 4);
    if (type != static_cast<std::uint16_t>(expected[i].type) || bytes != expected[i].bytes)
      return bad("lists item type " + std::to_string(type) + " with " + std::to_string(bytes) + " bytes where type " +
                 std::to_string(static_cast<std::uint16_t>(expected[i].type)) + " with " +
                 std::to_string(expected[i].bytes) + " bytes stands in a record" + of_format);
    const std::uint16_t low = layered ? 3 : 1;
    const auto high = static_cast<std::uint16_t>(expected[i].type == ItemType::wave_packet_13 ? low : low + 1);
    if (layout.compressor != Compressor::none && (version < low || version > high))
      return bad("lists item type " + std::to_string(type) + " in version " + std::to_string(version) + "; " +
                 (low == high ? "only " + std::to_string(low) + " is read"
                              : std::to_string(low) + " and " + std::to_string(high) + " are read"));
    layout.items.push_back({expected[i].type, bytes, version});
  }
  return layout;
}

LazLayout standard_layout(int point_format, std::uint16_t record_bytes, std::uint32_t chunk_points) {
  const bool layered = point_format >= 6;
  LazLayout layout{.compressor = layered ? Compressor::layered_chunked : Compressor::pointwise_chunked,
                   .chunk_points = chunk_points,
                   .items = {}};
  for (const auto& item : items_of(point_format, record_bytes))
    layout.items.push_back({item.type, item.bytes, static_cast<std::uint16_t>(layered ? 3 : 2)});
  return layout;
}

}  // namespace tessera::laz
