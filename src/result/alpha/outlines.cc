#include "src/result/alpha/outlines.h"

#include <algorithm>
#include <cerrno>
#include <optional>
#include <unordered_map>
#include <utility>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::alpha {

namespace fs = std::filesystem;

namespace {

// At most as many sorters are in use at once.
constexpr std::uint64_t sorters = 3;
// Marks the pieces that only one tile has.
constexpr std::uint64_t alone = std::uint64_t{1} << 63;

Error unfit() {
  return error(Errc::corrupt,
               "the outlines of the result's tiles do not fit together; its tiles contradict each other");
}

}  // namespace

Outlines::Outlines(fs::path scratch, std::uint64_t memory_bytes, std::stop_token stop)
    : scratch_(std::move(scratch)),
      sorter_bytes_(memory_bytes / sorters),
      stop_(std::move(stop)),
      chain_file_(scratch_),
      ring_file_(scratch_),
      cells_(scratch_, sorter_bytes_, stop_),
      rings_(scratch_, sorter_bytes_, stop_) {}

Result<Outlines::Stored> Outlines::VertexFile::add(std::span<const OutlineVertex> vertices) {
  if (!stream_) {
    BOOST_OUTCOME_TRY(file, nameless_file(scratch_));
    file_ = std::move(file);
    stream_ = std::make_unique<exports::Stream>(file_.get(), scratch_, 0);
  }
  const Stored stored{stream_->offset(), vertices.size()};
  stream_->bytes(std::as_bytes(vertices));
  BOOST_OUTCOME_TRYV(stream_->status());
  return stored;
}

Status Outlines::VertexFile::read(const Stored& stored, std::vector<OutlineVertex>& to) {
  BOOST_OUTCOME_TRYV(stream_->flush());
  const std::size_t before = to.size();
  to.resize(before + stored.count);
  const auto bytes = std::as_writable_bytes(std::span(to).subspan(before));
  BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), bytes, stored.offset, scratch_));
  if (read != bytes.size()) return io_error(scratch_, "cannot read back", EIO);
  return success();
}

Status Outlines::add(const TileOutline& outline) {
  std::vector<std::uint64_t> pieces(outline.pieces, 0);
  for (const SharedCell& cell : outline.shared) pieces[cell.piece] = 1;
  for (std::uint64_t& piece : pieces) {
    if (piece == 0) {
      piece = alone | pieces_alone_++;
    } else {
      piece = shared_pieces_.size();
      shared_pieces_.grow(shared_pieces_.size() + 1);
    }
  }
  for (const SharedCell& cell : outline.shared) {
    BOOST_OUTCOME_TRYV(cells_.push({cell.ids, static_cast<std::uint32_t>(pieces[cell.piece])}));
  }
  for (const OutlineChain& chain : outline.chains) {
    const auto vertices = std::span(outline.vertices).subspan(chain.begin, chain.end - chain.begin);
    if (chain.closed) {
      BOOST_OUTCOME_TRYV(add_walk(vertices, pieces[chain.piece]));
      continue;
    }
    BOOST_OUTCOME_TRY(stored, chain_file_.add(vertices));
    chains_.push_back({chain.first, chain.last, stored, pieces[chain.piece]});
  }
  return success();
}

// Splits a walk where it passes a vertex again. What lies between is a ring of its own.
Status Outlines::add_walk(std::span<const OutlineVertex> walk, std::uint64_t piece) {
  std::unordered_map<std::uint64_t, std::size_t> places;
  std::vector<OutlineVertex> open;
  for (const OutlineVertex& vertex : walk) {
    const auto [found, fresh] = places.try_emplace(vertex.id.value, open.size());
    if (fresh) {
      open.push_back(vertex);
      continue;
    }
    const auto begin = open.begin() + static_cast<std::ptrdiff_t>(found->second);
    BOOST_OUTCOME_TRYV(add_ring({begin, open.end()}, piece));
    for (auto gone = begin + 1; gone != open.end(); ++gone) places.erase(gone->id.value);
    open.erase(begin + 1, open.end());
  }
  return add_ring(std::move(open), piece);
}

Status Outlines::add_ring(std::vector<OutlineVertex> ring, std::uint64_t piece) {
  if (ring.size() < 3) return unfit();
  const auto by_id = [](const OutlineVertex& a, const OutlineVertex& b) { return a.id < b.id; };
  std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end(), by_id), ring.end());
  // At the vertex that is least by coordinates a ring turns in the direction in which it runs.
  const auto by_place = [](const OutlineVertex& a, const OutlineVertex& b) {
    return std::tie(a.x, a.y) < std::tie(b.x, b.y);
  };
  const auto least = static_cast<std::size_t>(std::min_element(ring.begin(), ring.end(), by_place) - ring.begin());
  const auto at = [&](std::size_t i) { return Point{ring[i % ring.size()].x, ring[i % ring.size()].y, 0}; };
  const int turn = exact::orientation_2(at(least + ring.size() - 1), at(least), at(least + 1));
  if (turn == 0) return unfit();
  BOOST_OUTCOME_TRY(stored, ring_file_.add(ring));
  return rings_.push({{PointId{piece}, PointId{0}}, turn < 0, {ring[0].id, ring[1].id}, stored});
}

Status Outlines::join_pieces() {
  const auto same = [](const PieceCell& a, const PieceCell& b) { return a.ids == b.ids; };
  constexpr std::size_t tiles_of_a_cell = 3;
  return for_each_group(cells_, tiles_of_a_cell, same, [&](std::span<const PieceCell> cells) -> Status {
    for (const PieceCell& cell : cells.subspan(1))
      shared_pieces_.join(shared_pieces_.find(cells[0].piece), shared_pieces_.find(cell.piece));
    return success();
  });
}

Status Outlines::join_chains() {
  const auto before = [](const OpenChain& a, const OpenChain& b) { return a.first < b.first; };
  std::sort(chains_.begin(), chains_.end(), before);
  std::vector<OutlineVertex> walk;
  for (OpenChain& start : chains_) {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while joining outlines");
    if (start.done) continue;
    walk.clear();
    OpenChain* chain = &start;
    do {
      if (chain->done) return unfit();
      chain->done = true;
      BOOST_OUTCOME_TRYV(chain_file_.read(chain->vertices, walk));
      const auto next = std::lower_bound(chains_.begin(), chains_.end(), chain->last,
                                         [](const OpenChain& a, const OutlineEdge& edge) { return a.first < edge; });
      if (next == chains_.end() || next->first != chain->last) return unfit();
      chain = &*next;
    } while (chain != &start);
    BOOST_OUTCOME_TRYV(add_walk(walk, start.piece));
  }
  chains_ = {};
  return success();
}

Status Outlines::group_by_piece(ExternalSort<Ring>& to) {
  return rings_.for_each([&](Ring ring) -> Status {
    std::uint64_t& piece = ring.group[0].value;
    if ((piece & alone) == 0) piece = shared_pieces_.find(static_cast<std::uint32_t>(piece));
    return to.push(ring);
  });
}

Status Outlines::group_by_polygon(ExternalSort<Ring>& from, ExternalSort<Ring>& to) {
  std::optional<PointId> piece;
  OutlineEdge outer{};
  return from.for_each([&](Ring ring) -> Status {
    const bool fresh = piece != ring.group[0];
    if (fresh == ring.hole) return unfit();  // a piece has one outer ring, which comes first
    if (fresh) outer = ring.first;
    piece = ring.group[0];
    ring.group = outer;
    return to.push(ring);
  });
}

Status Outlines::for_each(const std::function<Status(const OutlineRings&)>& visit) {
  BOOST_OUTCOME_TRYV(join_pieces());
  BOOST_OUTCOME_TRYV(join_chains());
  ExternalSort<Ring> polygons(scratch_, sorter_bytes_, stop_);
  {
    ExternalSort<Ring> pieces(scratch_, sorter_bytes_, stop_);
    BOOST_OUTCOME_TRYV(group_by_piece(pieces));
    BOOST_OUTCOME_TRYV(group_by_polygon(pieces, polygons));
  }
  OutlineRings rings;
  BOOST_OUTCOME_TRYV(polygons.for_each([&](const Ring& ring) -> Status {
    if (!ring.hole && !rings.empty()) {
      BOOST_OUTCOME_TRYV(visit(rings));
      rings.clear();
    }
    rings.emplace_back();
    return ring_file_.read(ring.vertices, rings.back());
  }));
  return rings.empty() ? success() : visit(rings);
}

}  // namespace tessera::alpha
