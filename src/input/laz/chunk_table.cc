#include "src/input/laz/chunk_table.h"

#include <algorithm>
#include <array>
#include <string>

#include "src/input/bytes/fields.h"
#include "src/input/laz/integer_decoder.h"

namespace tessera::laz {

Result<std::vector<Chunk>> read_chunk_table(const ByteSource& source, const LazLayout& layout, std::uint64_t points_at,
                                            std::uint64_t points, std::size_t record_bytes) {
  if (!layout.chunked()) return std::vector{Chunk{points_at, source.size(), 0, points}};
  const auto bad = [&](const std::string& what) {
    return error(Errc::bad_input, source.path().string() + ", chunk table: " + what);
  };
  if (points == 0) return std::vector<Chunk>{};

  std::array<std::byte, 8> raw{};
  const std::uint64_t first_at = points_at + raw.size();
  if (first_at > source.size()) return bad("the file ends before the number that says where the table is");
  BOOST_OUTCOME_TRYV(source.read(points_at, raw));
  // a writer that cannot go back writes this value at the end of the file instead
  if (load<std::int64_t>(raw.data()) == -1) {
    BOOST_OUTCOME_TRYV(source.read(source.size() - raw.size(), raw));
  }
  const auto table_at = load<std::uint64_t>(raw.data());
  if (table_at < first_at || table_at > source.size() || source.size() - table_at < raw.size())
    return bad("would be at byte " + std::to_string(table_at) + " of " + std::to_string(source.size()) +
               "; the file was cut off, or its writer did not finish it");
  BOOST_OUTCOME_TRYV(source.read(table_at, raw));
  const auto version = load<std::uint32_t>(raw.data()), count = load<std::uint32_t>(raw.data() + 4);
  if (version != 0) return bad("is of version " + std::to_string(version) + "; only 0 is known");
  if (count > (table_at - first_at) / record_bytes)
    return bad("lists " + std::to_string(count) + " chunks, which do not fit in " +
               std::to_string(table_at - first_at) + " bytes");

  ArithmeticDecoder decoder(ByteFeed(source, table_at + raw.size(), source.size()));
  IntegerDecoder<32, 2> integers;
  std::vector<Chunk> chunks;  // grows as the table is read: its count may be made up
  std::uint32_t chunk_points = 0, bytes = 0;
  std::uint64_t at = first_at, listed = 0;
  while (chunks.size() < count && decoder.feed().missing() == 0) {
    if (layout.variable_chunks()) {
      chunk_points = static_cast<std::uint32_t>(integers.next(decoder, static_cast<std::int32_t>(chunk_points), 0));
    } else {
      chunk_points = static_cast<std::uint32_t>(std::min<std::uint64_t>(layout.chunk_points, points - listed));
    }
    bytes = static_cast<std::uint32_t>(integers.next(decoder, static_cast<std::int32_t>(bytes), 1));
    BOOST_OUTCOME_TRYV(decoder.feed().status());
    const auto bad_chunk = [&](const std::string& what) {
      return bad("chunk " + std::to_string(chunks.size()) + " of " + std::to_string(count) + " " + what);
    };
    if (bytes > table_at - at) return bad_chunk("claims " + std::to_string(bytes) + " bytes, more than there are");
    if (chunk_points > points - listed)
      return bad_chunk("claims " + std::to_string(chunk_points) + " points, more than the header promises");
    chunks.push_back({at, at + bytes, listed, chunk_points});
    at += bytes;
    listed += chunk_points;
  }
  BOOST_OUTCOME_TRYV(decoder.feed().status());
  if (decoder.feed().missing() > 0) return bad("ends before its last chunk");
  if (listed != points)
    return bad("lists " + std::to_string(listed) + " points, but the header promises " + std::to_string(points));
  return chunks;
}

}  // namespace tessera::laz
