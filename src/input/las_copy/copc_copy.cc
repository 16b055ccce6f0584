#include "src/input/las_copy/copc_copy.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"

namespace tessera::laz {
namespace {

constexpr std::size_t info_bytes = 160, root_at = 40, root_bytes_at = 48, entry_bytes = 32;

class MoveHierarchy {
 public:
  MoveHierarchy(const ByteSource& source, LasParts& parts, std::span<const Chunk> from, std::span<const Chunk> to,
                std::uint64_t extended_at)
      : source_(source), parts_(parts), from_(from), to_(to), extended_at_(extended_at) {}

  Status run(std::vector<std::byte>& info) {
    if (info.size() < info_bytes)
      return bad("info record: has " + std::to_string(info.size()) + " bytes, not " + std::to_string(info_bytes));
    BOOST_OUTCOME_TRYV(find_records());
    BOOST_OUTCOME_TRY(
        root, take_page(load<std::uint64_t>(info.data() + root_at), load<std::uint64_t>(info.data() + root_bytes_at)));
    store_at(info, root_at, root);
    while (!pages_.empty()) {
      const auto page = pages_.back();
      pages_.pop_back();
      for (std::size_t at = 0; at + entry_bytes <= page.size(); at += entry_bytes) {
        BOOST_OUTCOME_TRYV(move_entry(page.subspan(at, entry_bytes)));
      }
    }
    return success();
  }

 private:
  struct Hierarchy {
    std::uint64_t from, to;  // the places of the payload in the input and in the copy
    std::span<std::byte> payload;
  };

  Error bad(const std::string& what) const {
    return error(Errc::bad_input, source_.path().string() + ", COPC " + what);
  }

  Status find_records() {
    std::uint64_t at = extended_at_;
    for (auto& record : parts_.extended) {
      if (record.is("copc", 1000)) {
        BOOST_OUTCOME_TRY(payload, read_payload(source_, record));
        record.payload = std::move(payload);
        hierarchies_.push_back({record.source.at, at + record.head.size(), *record.payload});
        bytes_left_ += record.payload->size();
      }
      at += record.bytes();
    }
    return success();
  }

  // Puts a page of the input on the list, and returns its place in the copy.
  Result<std::uint64_t> take_page(std::uint64_t at, std::uint64_t bytes) {
    const std::string page = "hierarchy page at byte " + std::to_string(at) + ": ";
    for (const auto& record : hierarchies_) {
      if (at < record.from || at - record.from > record.payload.size()) continue;
      const std::uint64_t offset = at - record.from;
      if (bytes > record.payload.size() - offset) continue;
      if (bytes > bytes_left_) return bad(page + "the pages up to this one form a circle or overlap");
      bytes_left_ -= bytes;
      pages_.push_back(record.payload.subspan(offset, bytes));
      return record.to + offset;
    }
    return bad(page + "is in no hierarchy record");
  }

  // An entry: level and key (4 integers), place (8 bytes), length, points; -1 points: the place is that of a page.
  Status move_entry(std::span<std::byte> entry) {
    auto at = load<std::uint64_t>(entry.data() + 16);
    auto bytes = load<std::int32_t>(entry.data() + 24);
    const auto points = load<std::int32_t>(entry.data() + 28);
    if (points == 0) return success();
    if (points == -1) {
      if (bytes <= 0) return bad("hierarchy: an entry leads to an empty page");
      BOOST_OUTCOME_TRY(moved, take_page(at, static_cast<std::uint64_t>(bytes)));
      at = moved;
    } else {
      const auto chunk = std::lower_bound(from_.begin(), from_.end(), at,
                                          [](const Chunk& c, std::uint64_t place) { return c.begin < place; });
      if (chunk == from_.end() || chunk->begin != at ||
          std::int64_t{points} != static_cast<std::int64_t>(chunk->points))
        return bad("hierarchy: the node of " + std::to_string(points) + " points at byte " + std::to_string(at) +
                   " is not in the chunk table");
      const Chunk& moved = to_[static_cast<std::size_t>(chunk - from_.begin())];
      if (moved.end - moved.begin > INT32_MAX) return bad("hierarchy: a node would have more than 2 GiB");
      at = moved.begin;
      bytes = static_cast<std::int32_t>(moved.end - moved.begin);
    }
    std::memcpy(entry.data() + 16, &at, sizeof at);
    std::memcpy(entry.data() + 24, &bytes, sizeof bytes);
    return success();
  }

  const ByteSource& source_;
  LasParts& parts_;
  std::span<const Chunk> from_, to_;
  std::uint64_t extended_at_, bytes_left_ = 0;
  std::vector<Hierarchy> hierarchies_;
  std::vector<std::span<std::byte>> pages_;
};

}  // namespace

Status move_copc_hierarchy(const ByteSource& source, LasParts& parts, std::span<const Chunk> from,
                           std::span<const Chunk> to, std::uint64_t extended_at, std::vector<std::byte>& info) {
  return MoveHierarchy(source, parts, from, to, extended_at).run(info);
}

}  // namespace tessera::laz
