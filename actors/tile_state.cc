#include "actors/tile_state.h"

#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/util/delimited_message_util.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "exchange.pb.h"
#include "src/base/check.h"
#include "src/kernel/brio.h"
#include "src/tiling/hilbert.h"

namespace tessera {
namespace {

// Mail of a tile that is not in memory goes to disk in pieces of this size.
constexpr std::uint64_t spill_points = 16384;

template <class List>
std::span<const std::byte> bytes_of(const List& list) {
  return std::as_bytes(std::span(list));
}

// Appends a list of 32-bit numbers with its length.
template <class List>
void append(std::vector<std::byte>& out, const List& list) {
  const std::uint64_t n = list.size();
  const auto length = std::as_bytes(std::span(&n, 1));
  out.insert(out.end(), length.begin(), length.end());
  const auto body = bytes_of(list);
  out.insert(out.end(), body.begin(), body.end());
}

template <class List>
bool extract(std::span<const std::byte>& in, List& list) {
  using T = typename List::value_type;
  std::uint64_t n = 0;
  if (in.size() < sizeof n) return false;
  std::memcpy(&n, in.data(), sizeof n);
  in = in.subspan(sizeof n);
  if (n > in.size() / sizeof(T)) return false;
  list.resize(n);
  if (n > 0) std::memcpy(list.data(), in.data(), n * sizeof(T));
  in = in.subspan(n * sizeof(T));
  return true;
}

Error damaged(TileId tile, const char* what) {
  return error(Errc::corrupt, "tile " + std::to_string(tile.value) + ": its " + what + " on disk is damaged");
}

}  // namespace

TileState::TileState(Peer self, const TileContext& context) : self_(self), context_(context) {}

Status TileState::triangulate() {
  check(phase_ == Phase::fresh, "a tile is triangulated once");
  BOOST_OUTCOME_TRY(loaded, context_.storage->load_points(self_.tile));
  duplicates_ = std::move(loaded.duplicates);
  own_points_ = loaded.points.size();
  const Box& box = context_.boxes[self_.tile.value];
  triangulation_ = std::make_unique<TileTriangulation>(options());
  // Kept until collect() when the tile is not reduced; moving the vector leaves its points where they are.
  triangulation_->triangulate(loaded.points, loaded.ids, context_.seeds,
                              context_.reduce ? KeepPoints::copied : KeepPoints::borrowed);
  if (context_.reduce) {
    BOOST_OUTCOME_TRYV(put_finals(triangulation_->reduce(loaded.points, box)));
  }
  triangulation_->announce(loaded.points, box, context_.neighbours[self_.tile.value]);
  if (!context_.reduce) points_ = std::move(loaded);
  counts_ = triangulation_->counts();
  phase_ = Phase::awake;
  return success();
}

void TileState::receive(Batch batch) {
  check(phase_ != Phase::collected, "no mail comes after quiescence");
  waiting_points_ += batch.points.size();
  mail_points_ += batch.points.size();
  waiting_peers_.push_back(batch.from);
  waiting_hops_ = std::max(waiting_hops_, batch.hops);
  mail_.push_back({batch.from.tile, std::move(batch.points)});
}

Status TileState::splay() {
  BOOST_OUTCOME_TRYV(wake());
  BOOST_OUTCOME_TRY(mail, take_mail());
  hops_ = std::max(hops_, waiting_hops_);
  // In Hilbert order, so that each insertion starts where the last one ended, but a random few first: the first points
  // beyond the hull see a whole face of it, and in Hilbert order alone every point would be the first of its region.
  struct Item {
    std::uint64_t key;
    TileId from;
    const SharedPoint* point;
  };
  Bounds bounds;
  std::size_t n = 0;
  for (const Waiting& w : mail) {
    n += w.points.size();
    for (const SharedPoint& p : w.points) bounds.add(p.at);
  }
  const HilbertKey key(bounds, context_.dimension);
  std::vector<Item> items;
  items.reserve(n);
  for (const Waiting& w : mail) {
    for (const SharedPoint& p : w.points) items.push_back({key(p.at), w.from, &p});
  }
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.key < b.key; });
  for_each_in_brio_order<2>(
      n, [&](std::size_t i) { triangulation_->receive(items[i].from, std::span(items[i].point, 1)); });
  for (const Peer peer : waiting_peers_) counters_.add_processed(peer);
  if (context_.progress) context_.progress->batches_processed += waiting_peers_.size();
  waiting_peers_.clear();
  waiting_points_ = 0;
  counts_ = triangulation_->counts();
  return success();
}

std::vector<Batch> TileState::take_outgoing() {
  std::vector<Batch> out;
  if (!triangulation_) return out;
  for (auto& [tile, points] : triangulation_->take_updates()) {
    const Peer to{TileId{tile}, 0};
    counters_.add_sent(to);
    if (context_.progress) {
      ++context_.progress->batches_sent;
      context_.progress->points_sent += points.size();
    }
    out.push_back({self_, to, hops_ + 1, std::move(points)});
  }
  return out;
}

Status TileState::sleep() {
  check(phase_ == Phase::awake, "only a tile that is awake falls asleep");
  BOOST_OUTCOME_TRYV(context_.storage->put(self_.tile, Scratch::state, triangulation_->save(), false));
  triangulation_.reset();
  phase_ = Phase::asleep;
  return spill_mail();
}

Status TileState::wake() {
  if (phase_ == Phase::awake) return success();
  check(phase_ == Phase::asleep, "only a tile that sleeps is woken");
  BOOST_OUTCOME_TRY(bytes, context_.storage->take(self_.tile, Scratch::state));
  triangulation_ = std::make_unique<TileTriangulation>(options());
  if (!triangulation_->load(bytes)) return damaged(self_.tile, "state");
  phase_ = Phase::awake;
  return success();
}

Status TileState::spill_mail() {
  if (!context_.reduce || mail_points_ < spill_points) return success();
  std::string bytes;
  google::protobuf::io::StringOutputStream out(&bytes);
  for (const Waiting& w : mail_) {
    proto::PointBatch record;
    record.set_from_tile(w.from.value);
    record.set_points(w.points.data(), w.points.size() * sizeof(SharedPoint));
    google::protobuf::util::SerializeDelimitedToZeroCopyStream(record, &out);
  }
  bytes.resize(static_cast<std::size_t>(out.ByteCount()));
  mail_.clear();
  mail_points_ = 0;
  return context_.storage->put(self_.tile, Scratch::mail, std::as_bytes(std::span(bytes)), true);
}

Result<std::vector<TileState::Waiting>> TileState::take_mail() {
  std::vector<Waiting> mail = std::exchange(mail_, {});
  const std::uint64_t in_memory = std::exchange(mail_points_, 0);
  if (in_memory == waiting_points_) return mail;
  BOOST_OUTCOME_TRY(bytes, context_.storage->take(self_.tile, Scratch::mail));
  google::protobuf::io::ArrayInputStream in(bytes.data(), static_cast<int>(bytes.size()));
  std::uint64_t spilled = 0;
  for (bool at_end = false; !at_end;) {
    proto::PointBatch record;
    if (!google::protobuf::util::ParseDelimitedFromZeroCopyStream(&record, &in, &at_end)) {
      if (at_end) break;
      return damaged(self_.tile, "mail");
    }
    Waiting w{TileId{record.from_tile()}, std::vector<SharedPoint>(record.points().size() / sizeof(SharedPoint))};
    std::memcpy(w.points.data(), record.points().data(), w.points.size() * sizeof(SharedPoint));
    spilled += w.points.size();
    mail.push_back(std::move(w));
  }
  if (in_memory + spilled != waiting_points_) return damaged(self_.tile, "mail");
  return mail;
}

Status TileState::put_finals(const FinalCells& finals) {
  std::vector<std::byte> bytes;
  bytes.reserve(finals.vertices.size() * 8 + 16);
  append(bytes, finals.vertices);
  append(bytes, finals.neighbors);
  return context_.storage->put(self_.tile, Scratch::finals, bytes, false);
}

Result<FinalCells> TileState::take_finals() {
  FinalCells finals;
  if (!context_.reduce) return finals;
  BOOST_OUTCOME_TRY(bytes, context_.storage->take(self_.tile, Scratch::finals));
  std::span<const std::byte> rest(bytes);
  const auto corners = static_cast<std::size_t>(context_.dimension) + 1;
  if (!extract(rest, finals.vertices) || !extract(rest, finals.neighbors) || !rest.empty() ||
      finals.vertices.size() != finals.neighbors.size() || finals.vertices.size() % corners != 0) {
    return damaged(self_.tile, "list of final cells");
  }
  const auto cells = static_cast<std::int64_t>(finals.vertices.size() / corners);
  for (std::size_t i = 0; i < finals.vertices.size(); ++i) {
    if (finals.vertices[i] >= own_points_ || finals.neighbors[i] < FinalCells::open || finals.neighbors[i] >= cells) {
      return damaged(self_.tile, "list of final cells");
    }
  }
  return finals;
}

Result<TileMesh> TileState::collect() {
  BOOST_OUTCOME_TRYV(wake());
  if (context_.reduce) {
    BOOST_OUTCOME_TRY(loaded, context_.storage->load_points(self_.tile));
    points_ = std::move(loaded);
    if (points_.points.size() != own_points_) return damaged(self_.tile, "file of points");
  }
  BOOST_OUTCOME_TRY(finals, take_finals());
  TileMesh mesh = triangulation_->collect(points_.points, points_.ids, std::move(finals));
  counts_ = triangulation_->counts();
  triangulation_.reset();
  points_ = {};
  phase_ = Phase::collected;
  return mesh;
}

std::size_t TileState::memory() const {
  return (triangulation_ ? triangulation_->memory() : 0) + points_.points.capacity() * 32 +
         mail_points_ * sizeof(SharedPoint);
}

}  // namespace tessera
