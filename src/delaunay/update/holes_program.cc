#include "src/delaunay/update/holes_program.h"

#include <algorithm>
#include <utility>

#include "src/exchange/update.h"
#include "src/tiling/affine_basis.h"
#include "src/tiling/tile/holes.h"

namespace tessera {
namespace {

class HolesTold final : public Finished {
 public:
  HolesTold(UpdateStore& store, TileId tile, ToldOfHoles told) : store_(store), tile_(tile), told_(std::move(told)) {}
  std::uint64_t bytes() const override {
    return told_.around.size() * sizeof(SharedPoint) + told_.filled.size() * sizeof(PointId);
  }
  void store(Stored done) override {
    Status kept = told_.empty() ? success() : store_.keep_told(tile_, told_);
    done(kept ? Result<Receipt>(Receipt()) : Result<Receipt>(std::move(kept).error()));
  }

 private:
  UpdateStore& store_;
  TileId tile_;
  ToldOfHoles told_;
};

// Whether the points that stay span space: only then has every point a star without the exchange.
bool span_space(const TileMesh& mesh, const PointIds& removed) {
  AffineBasis basis(mesh.dimension);
  for (std::size_t v = 0; v < mesh.ids.size() && !basis.complete(); ++v) {
    const LocalPoint p{mesh.points[v], mesh.ids[v]};
    if (!removed.contains(p.id)) basis.add(std::span(&p, 1));
  }
  return basis.complete();
}

std::vector<SharedPoint> spread(std::vector<SharedPoint> points, std::size_t most) {
  const std::size_t stride = (points.size() + most - 1) / most;
  std::vector<SharedPoint> out;
  for (std::size_t k = 0; k < points.size(); k += stride) out.push_back(points[k]);
  return out;
}

void make_unique(std::vector<SharedPoint>& points) {
  const auto by_id = [](const SharedPoint& a, const SharedPoint& b) { return a.id < b.id; };
  std::sort(points.begin(), points.end(), by_id);
  const auto same = [](const SharedPoint& a, const SharedPoint& b) { return a.id == b.id; };
  points.erase(std::unique(points.begin(), points.end(), same), points.end());
}

// As messages, none of which is too long.
std::vector<Message> messages_of(const ToldOfHoles& told) {
  constexpr std::size_t most_points = 16'384, most_ids = 32'768;
  static_assert(most_points * sizeof(SharedPoint) + most_ids * sizeof(PointId) + 64 < message_bytes_max);
  std::vector<Message> out;
  std::span<const SharedPoint> around(told.around);
  std::span<const PointId> filled(told.filled);
  do {
    const auto points = around.first(std::min(most_points, around.size()));
    const auto ids = filled.first(std::min(most_ids, filled.size()));
    out.push_back(bytes_of(ToldOfHoles{told.beside, {points.begin(), points.end()}, {ids.begin(), ids.end()}}));
    around = around.subspan(points.size());
    filled = filled.subspan(ids.size());
  } while (!around.empty() || !filled.empty());
  return out;
}

}  // namespace

// What a tile tells depends on the result and the plan alone, so it is the same in each of its lives.
Status HolesProgram::tell(std::span<const TileId> to) {
  const UpdatePlan& plan = *setting_->plan;
  if (!plan.losing.contains(self_)) return success();
  BOOST_OUTCOME_TRY(mesh, setting_->store->read(self_, true));
  const std::vector<Hole> holes = find_holes(self_, mesh, plan.removed);
  const bool fill = span_space(mesh, plan.removed);
  mesh = {};
  std::map<TileId, ToldOfHoles> told;
  std::vector<SharedPoint> around;
  for (const TileId tile : setting_->around->neighbours(self_)) told[tile];
  for (const Hole& hole : holes) {
    around.insert(around.end(), hole.around.begin(), hole.around.end());
    const bool filled = fill && hole.whole && hole.around.size() <= points_max;
    if (filled) filled_.insert(hole.removed.begin(), hole.removed.end());
    for (const TileId tile : hole.beside) {
      told[tile].beside = true;
      if (!filled) continue;
      told[tile].filled.insert(told[tile].filled.end(), hole.removed.begin(), hole.removed.end());
      told[tile].around.insert(told[tile].around.end(), hole.around.begin(), hole.around.end());
    }
  }
  make_unique(around);
  around = spread(std::move(around), points_max);
  for (auto& [tile, of_tile] : told) {
    const bool part = tile != self_ && !setting_->around->bounds(tile).empty();
    if (!part || (!to.empty() && !std::binary_search(to.begin(), to.end(), tile))) continue;
    of_tile.around.insert(of_tile.around.end(), around.begin(), around.end());
    std::erase_if(of_tile.around, [&](const SharedPoint& p) { return p.tile == tile; });
    make_unique(of_tile.around);
    std::sort(of_tile.filled.begin(), of_tile.filled.end());
    counts_.sent += of_tile.around.size();
    for (Message& message : messages_of(of_tile)) messages_.emplace_back(tile, std::move(message));
  }
  return success();
}

bool HolesProgram::add(std::span<const std::byte> bytes) {
  const auto told = told_of(bytes);
  if (!told) return false;
  beside_ |= told->beside;
  for (const SharedPoint& p : told->around) around_.emplace(p.id, p);
  filled_.insert(told->filled.begin(), told->filled.end());
  return true;
}

ToldOfHoles HolesProgram::told() const {
  ToldOfHoles told{beside_, {}, {filled_.begin(), filled_.end()}};
  for (const auto& [id, p] : around_) told.around.push_back(p);
  return told;
}

Status HolesProgram::begin_settled(Message settled) {
  return add(settled) ? Status(success()) : damaged(self_, "list of points around holes");
}

Status HolesProgram::take(TileId from, bool, Message message) {
  if (message.empty()) return success();  // the tile's call to itself
  if (add(message)) return success();
  return error(Errc::internal, "tile " + to_string(from) + " has sent no list of points around holes");
}

Status HolesProgram::step() {
  if (reborn_.empty()) return success();
  return tell(std::exchange(reborn_, {}));
}

void HolesProgram::replay_to(std::span<const TileId> reborn) {
  std::vector<TileId> all;
  std::set_union(reborn_.begin(), reborn_.end(), reborn.begin(), reborn.end(), std::back_inserter(all));
  reborn_ = std::move(all);
}

Result<bool> HolesProgram::load(Image image, ImageOf whose) {
  if (!add(image)) return false;
  if (whose == ImageOf::earlier) {
    BOOST_OUTCOME_TRYV(tell({}));
  }
  return true;
}

void HolesProgram::free() {
  around_.clear();
  filled_.clear();
  messages_ = {};
}

Message HolesProgram::settled() const { return bytes_of(told()); }

Result<std::unique_ptr<Finished>> HolesProgram::finish() {
  return std::unique_ptr<Finished>(std::make_unique<HolesTold>(*setting_->store, self_, told()));
}

std::size_t HolesProgram::memory() const {
  std::size_t sum = sizeof *this + around_.size() * (sizeof(SharedPoint) + 48) + filled_.size() * 56;
  for (const auto& [to, message] : messages_) sum += message.size();
  return sum;
}

}  // namespace tessera
