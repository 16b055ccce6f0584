// Mail of a step in which each tile sends every other tile all it has to say at once, in numbered pieces. A tile always
// makes the same pieces. So a receiver that gets a piece again, from a later life of the sender, recognises it by its
// number.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/flat_codec.h"
#include "src/exchange/tile_program.h"

namespace tessera::surface {

inline constexpr std::size_t piece_bytes_max = 250'000;

struct PieceHead {
  std::uint32_t number = 0;  // of the pieces from one tile to another
  std::uint32_t kind = 0;    // of the records in the piece
};

// Collects what one tile sends.
class PieceOutbox {
 public:
  template <class Record>
  void add(TileId to, std::uint32_t kind, const Record& record) {
    static_assert(std::is_trivially_copyable_v<Record>);
    Box& box = boxes_[to];
    auto [at, fresh] = box.open.try_emplace(kind);
    FlatWriter& piece = at->second;
    if (!fresh && piece.size() + sizeof(Record) > piece_bytes_max) {
      messages_.emplace_back(to, piece.take());
      piece = {};
      fresh = true;
    }
    if (fresh) piece.value(PieceHead{box.pieces++, kind});
    piece.value(record);
  }
  // Returns the pieces by receiver, and forgets them.
  std::vector<std::pair<TileId, Message>> take() {
    for (auto& [to, box] : boxes_)
      for (auto& [kind, piece] : box.open) messages_.emplace_back(to, piece.take());
    boxes_.clear();
    return std::exchange(messages_, {});
  }

 private:
  struct Box {
    std::uint32_t pieces = 0;
    std::map<std::uint32_t, FlatWriter> open;  // pieces that are being filled, by kind
  };
  std::map<TileId, Box> boxes_;
  std::vector<std::pair<TileId, Message>> messages_;
};

// Collects what one tile receives, in any order, and each piece once however often it arrives.
class PieceInbox {
 public:
  // Returns false if the message is no piece.
  bool add(TileId from, Message piece) {
    PieceHead head;
    FlatReader in(piece);
    if (!in.value(head)) return false;
    pieces_.try_emplace({from, head.number}, std::move(piece));
    return true;
  }
  // Calls `use` with each record of a kind, ordered by sender and number of the piece. Returns false when a piece does
  // not consist of such records.
  template <class Record, class Use>
  bool for_each(std::uint32_t kind, const Use& use) const {
    for (const auto& [name, piece] : pieces_) {
      PieceHead head;
      FlatReader in(piece);
      if (!in.value(head) || (head.kind == kind && (piece.size() - sizeof head) % sizeof(Record) != 0)) return false;
      Record record;
      while (head.kind == kind && in.value(record)) use(name.first, record);
    }
    return true;
  }
  Message save() const {
    FlatWriter out;
    for (const auto& [name, piece] : pieces_) {
      out.value(name.first);
      out.list(piece);
    }
    return out.take();
  }
  bool load(std::span<const std::byte> saved) {
    pieces_.clear();
    FlatReader in(saved);
    TileId from;
    Message piece;
    while (!in.at_end())
      if (!in.value(from) || !in.list(piece) || !add(from, std::exchange(piece, {}))) return false;
    return true;
  }
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& [name, piece] : pieces_) sum += piece.size() + 64;
    return sum;
  }

 private:
  std::map<std::pair<TileId, std::uint32_t>, Message> pieces_;
};

}  // namespace tessera::surface
