// The side files by which a resumed run knows which tiles are stored. They have plain lines instead of JSON, because
// the JSON library takes memory even to destroy what it has read. Side files are written and read while tiles are at
// work, when memory may be short.
#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <type_traits>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/disk_file.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/result/store/manifest.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr const char* no_digest = "-";
constexpr const char* no_heights = "-";
constexpr const char* of_points = "points ";  // begins the line of a tile kept as points

// Removes the next word from `rest` and returns it.
std::string_view take_word(std::string_view& rest) {
  const auto word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(std::min(word.size() + 1, rest.size()));
  return word;
}

template <class Number>
bool take_number(std::string_view& rest, Number& value, int base = 10) {
  const auto word = take_word(rest);
  const char* const last = word.data() + word.size();
  std::from_chars_result got{};
  if constexpr (std::is_floating_point_v<Number>)
    got = std::from_chars(word.data(), last, value);
  else
    got = std::from_chars(word.data(), last, value, base);
  const auto [end, failed] = got;
  return failed == std::errc() && end == word.data() + word.size();
}

// As many digits as are needed to read the same value back.
std::string shortest(double value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

// Returns nothing when the line, without its end, is not one that line_of() made.
std::optional<TileEntry> read_line(std::string_view line) {
  constexpr std::size_t sum_bytes = 17;  // a space and the checksum
  if (line.size() < sum_bytes) return std::nullopt;
  auto text = line.substr(0, line.size() - sum_bytes);
  if (line.substr(text.size()) != " " + checksum_text(checksum(std::as_bytes(std::span(text))))) return std::nullopt;
  TileEntry entry;
  if (text.starts_with(of_points)) {
    entry.kind = TileKind::points;
    text.remove_prefix(std::string_view(of_points).size());
  }
  const bool read = take_number(text, entry.tile.value) && take_number(text, entry.points) &&
                    take_number(text, entry.own_points) && take_number(text, entry.cells) &&
                    take_number(text, entry.main_cells) && take_number(text, entry.bytes) &&
                    take_number(text, entry.xxh3, 16);
  const auto digest = take_word(text);
  if (digest != no_digest) entry.digest = parse_digest(digest);
  if (text != no_heights) {
    HeightRange heights;
    if (!take_number(text, heights.lo) || !take_number(text, heights.hi)) return std::nullopt;
    entry.heights = heights;
  } else {
    text = {};
  }
  if (!read || !text.empty() || (digest != no_digest && !entry.digest)) return std::nullopt;  // of another version
  return entry;
}

// Returns an entry of a tile whose file exists and is intact, or null. `entries` are all of one tile. A tile whose file
// is missing, unreadable or damaged is made again.
const TileEntry* sound_of(const fs::path& out, std::span<const TileEntry> entries) {
  std::optional<std::pair<TileKind, std::uint64_t>> summed;  // the last file that was read
  for (const TileEntry& entry : entries) {
    const auto file = tile_file(out, entry);
    const auto bytes = bytes_if_there(file);
    if (!bytes || bytes.value() != entry.bytes) continue;
    if (!summed || summed->first != entry.kind) {
      const auto sum = checksum_file(file, ChecksumOf::pieces);
      if (!sum) continue;
      summed = {entry.kind, sum.value()};
    }
    if (summed->second == entry.xxh3) return &entry;
  }
  return nullptr;
}

}  // namespace

namespace {

std::string line_of(const TileEntry& entry) {
  std::string text = entry.kind == TileKind::points ? of_points : "";
  for (const std::uint64_t number :
       {std::uint64_t{entry.tile.value}, entry.points, entry.own_points, entry.cells, entry.main_cells, entry.bytes}) {
    text += std::to_string(number) + " ";
  }
  text += checksum_text(entry.xxh3) + " " + (entry.digest ? digest_text(*entry.digest) : no_digest) + " ";
  text += entry.heights ? shortest(entry.heights->lo) + " " + shortest(entry.heights->hi) : no_heights;
  return text + " " + checksum_text(checksum(std::as_bytes(std::span(text))));
}

}  // namespace

namespace store {

Status write_done(const fs::path& out, NodeId node, const TileEntry& entry) {
  // The line is written in one call, so that lines of several threads do not mix. It begins with a line end, because a
  // process may have ended in the middle of the line before.
  const std::string line = "\n" + line_of(entry) + "\n";
  BOOST_OUTCOME_TRY(file, DiskFile::open(done_file(out, node), DiskFile::Mode::append));
  BOOST_OUTCOME_TRYV(file.write(std::as_bytes(std::span(line))));
  return file.close();
}

}  // namespace store

BigVector<std::byte> bytes_of(const TileEntry& entry) {
  const std::string line = line_of(entry);
  const auto bytes = std::as_bytes(std::span(line));
  return {bytes.begin(), bytes.end()};
}

std::optional<TileEntry> tile_entry_of(std::span<const std::byte> bytes) {
  return read_line({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Result<std::vector<TileEntry>> stored_tiles(const fs::path& out, const std::function<bool(TileId)>& wanted) {
  std::vector<TileEntry> entries;
  FolderReader reader(tiles_folder(out));
  while (const char* name = reader.next()) {
    if (!is_tile_name(name) || !is_done_name(name)) continue;
    BOOST_OUTCOME_TRY(bytes, read_whole(tiles_folder(out) / name));
    for (std::string_view rest = as_text(bytes); !rest.empty();) {
      const auto line = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(std::min(line.size() + 1, rest.size()));
      const auto entry = read_line(line);
      if (entry && (!wanted || wanted(entry->tile))) entries.push_back(*entry);
    }
  }
  if (reader.error() && reader.error() != std::errc::no_such_file_or_directory)
    return io_error(tiles_folder(out), "cannot be listed", reader.error().value());
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.tile < b.tile; });
  std::vector<TileEntry> stored;
  for (std::size_t i = 0, end = 0; i < entries.size(); i = end) {
    while (end < entries.size() && entries[end].tile == entries[i].tile) ++end;
    const auto of_tile = std::span(entries).subspan(i, end - i);  // more than one when the tile was stored again
    if (const auto* entry = sound_of(out, of_tile)) stored.push_back(*entry);
  }
  return stored;
}

}  // namespace tessera
