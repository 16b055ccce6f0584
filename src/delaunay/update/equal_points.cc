#include "src/delaunay/update/equal_points.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "src/tiling/kept_points.h"

namespace tessera {
namespace {

using Coordinates = std::tuple<double, double, double>;

Coordinates coordinates_of(const Point& p) { return {p.x, p.y, p.z}; }

// What is at a place.
struct Place {
  std::vector<LocalPoint> added;
  std::optional<PointId> vertex = {};  // of the result, whether it stays or goes
  std::vector<std::byte> row = {};     // its attributes
};

class Placer {
 public:
  Placer(const TileSource& source, std::span<const std::byte> rows, UpdatePlan& plan)
      : source_(source),
        manifest_(source.manifest()),
        width_(row_bytes(manifest_.schema)),
        height_at_(height_offset(manifest_.dimension, manifest_.schema)),
        rows_(rows),
        plan_(plan) {}

  Status place_in(TileId tile, std::vector<LocalPoint>& added) {
    std::map<Coordinates, Place> places;
    for (const LocalPoint& p : added) places[coordinates_of(p.at)].added.push_back(p);
    BOOST_OUTCOME_TRYV(find_vertices(tile, places));
    added.clear();
    for (const auto& [at, place] : places) {
      if (const auto left = decide(tile, place)) added.push_back(*left);
    }
    return success();
  }

  // The duplicates of vertices that were replaced go over to the points that took their places.
  void finish() {
    for (DuplicatePair& pair : plan_.duplicates) {
      if (const auto found = replaced_.find(pair.kept); found != replaced_.end()) pair.kept = found->second;
    }
    std::sort(plan_.duplicates.begin(), plan_.duplicates.end());
  }

 private:
  Status find_vertices(TileId tile, std::map<Coordinates, Place>& places) {
    const auto index = source_.find(tile);
    if (!index) return success();
    BOOST_OUTCOME_TRY(stored, source_.read(*index, {.cells = false, .rows = width_ > 0}));
    for (std::size_t v = 0; v < stored.mesh.ids.size(); ++v) {
      if (stored.mesh.point_ghost[v] != 0) continue;
      const auto found = places.find(coordinates_of(stored.mesh.points[v]));
      if (found == places.end()) continue;
      found->second.vertex = stored.mesh.ids[v];
      const auto row = std::span(stored.rows).subspan(v * width_, width_);
      found->second.row.assign(row.begin(), row.end());
    }
    return success();
  }

  double height_of(std::span<const std::byte> row) const { return height_at_ ? height_in(row, *height_at_) : 0; }

  // The old point that is the vertex of a place unless a new one takes it.
  std::optional<KeptCandidate> old_vertex(const Place& place) const {
    if (!place.vertex) return std::nullopt;
    if (!plan_.removed.contains(*place.vertex)) return KeptCandidate{*place.vertex, height_of(place.row)};
    const auto heir = plan_.heirs.find(*place.vertex);
    if (heir == plan_.heirs.end()) return std::nullopt;
    const auto row = plan_.old.row(heir->second);
    return KeptCandidate{heir->second, row ? height_of(*row) : 0};
  }

  // Returns the new point that is a vertex where there was none before, or nothing.
  std::optional<LocalPoint> decide(TileId tile, const Place& place) {
    const auto old = old_vertex(place);
    std::optional<KeptCandidate> kept = old;
    for (const LocalPoint& p : place.added) {
      const auto row = rows_.subspan((p.id.value - plan_.first_new) * width_, width_);
      const KeptCandidate other{p.id, height_of(row)};
      if (!kept || is_kept_before(manifest_.keep, other, *kept)) kept = other;
    }
    for (const LocalPoint& p : place.added) {
      if (p.id != kept->id) plan_.duplicates.push_back({p.id, kept->id});
    }
    plan_.new_equal += place.added.size() - (old ? 0 : 1);
    plan_.duplicates_changed |= old || place.added.size() > 1;
    if (!old) return LocalPoint{place.added.front().at, kept->id};
    if (kept->id == old->id) return std::nullopt;
    plan_.duplicates.push_back({old->id, kept->id});
    replaced_[old->id] = kept->id;
    plan_.heirs[*place.vertex] = kept->id;
    if (plan_.removed.insert(*place.vertex)) plan_.old.keep(*place.vertex, place.row);
    plan_.losing.insert(tile);
    return std::nullopt;
  }

  const TileSource& source_;
  const Manifest& manifest_;
  std::size_t width_;
  std::optional<std::size_t> height_at_;
  std::span<const std::byte> rows_;
  UpdatePlan& plan_;
  std::map<PointId, PointId> replaced_;
};

}  // namespace

double height_in(std::span<const std::byte> row, std::size_t at) {
  double height = 0;
  std::memcpy(&height, row.data() + at, sizeof height);
  return height;
}

Status place_equal_points(const TileSource& source, std::span<const std::byte> rows, UpdatePlan& plan) {
  Placer placer(source, rows, plan);
  for (auto& [tile, added] : plan.added) {
    BOOST_OUTCOME_TRYV(placer.place_in(tile, added));
  }
  std::erase_if(plan.added, [](const auto& tile) { return tile.second.empty(); });
  placer.finish();
  return success();
}

}  // namespace tessera
