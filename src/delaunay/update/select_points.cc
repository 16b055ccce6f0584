#include "src/delaunay/update/select_points.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <span>
#include <system_error>
#include <utility>

#include "src/base/attribute.h"
#include "src/base/on_threads.h"
#include "src/base/stopped.h"
#include "src/delaunay/update/old_duplicates.h"
#include "src/tiling/kept_points.h"
#include "src/tiling/partition.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

// Where an attribute stands in a row. Error usage when no row has it.
Result<std::size_t> place_of(const TileSource& source, const char* name, AttributeType type, const char* what) {
  std::size_t at = 0;
  for (const Attribute& attribute : source.manifest().schema) {
    if (attribute.name == name && attribute.type == type) return at;
    at += size_of(attribute.type);
  }
  return error(Errc::usage, source.folder().string() + ": the result has no attribute '" + name + "' of " +
                                std::to_string(8 * size_of(type)) + " bits, so its points have no " + what);
}

template <class Number>
Number number_in(std::span<const std::byte> row, std::size_t at) {
  Number value{};
  std::memcpy(&value, row.data() + at, sizeof value);
  return value;
}

bool meets(const Box& tile, const Box& box, int dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    if (tile.lo[axis] > box.hi[axis] || tile.hi[axis] < box.lo[axis]) return false;
  }
  return true;
}

bool meets(const Box& tile, const Bounds& points, const voronoi::ClipRegion& region) {
  // The part of the tile that can have points.
  const double lo_x = std::max(tile.lo.x, points.lo.x), hi_x = std::min(tile.hi.x, points.hi.x);
  const double lo_y = std::max(tile.lo.y, points.lo.y), hi_y = std::min(tile.hi.y, points.hi.y);
  if (lo_x > hi_x || lo_y > hi_y) return false;
  bool near = false;
  region.visit(
      [&](const Bounds& box) { return box.lo.x <= hi_x && lo_x <= box.hi.x && box.lo.y <= hi_y && lo_y <= box.hi.y; },
      [&](std::uint32_t) { near = true; });
  // Without an edge nearby, one of its points decides for all.
  return near || region.contains({lo_x, lo_y, 0});
}

class Selector {
 public:
  static Result<Selector> make(const TileSource& source, const PointSelection& selection) {
    Selector made(source, selection);
    const Manifest& manifest = source.manifest();
    if (!selection.classes.empty()) {
      BOOST_OUTCOME_TRY(at, place_of(source, "classification", AttributeType::u8, "classes"));
      made.class_at_ = at;
    }
    if (selection.times) {
      BOOST_OUTCOME_TRY(at, place_of(source, "gps_time", AttributeType::f64, "times"));
      made.time_at_ = at;
    }
    if (selection.box) made.height_at_ = height_offset(manifest.dimension, manifest.schema);
    BOOST_OUTCOME_TRY(duplicates, OldDuplicates::open(source));
    made.duplicates_ = std::move(duplicates);
    const auto& pairs = made.duplicates_.pairs();
    for (std::size_t i = 0; i < pairs.size(); ++i) made.by_kept_.emplace_back(pairs[i].kept, i);
    std::sort(made.by_kept_.begin(), made.by_kept_.end());
    if (selection.places.empty()) return made;
    BOOST_OUTCOME_TRY(partition, Partition::from_json(manifest.partition));
    for (const Point& p : selection.places) {
      const Point at = without_negative_zero(p);
      made.places_[partition.tile_of(at)].push_back(at);
    }
    for (auto& [tile, places] : made.places_) std::sort(places.begin(), places.end());
    return made;
  }

  // Whether the tile may have selected points.
  bool is_wanted(std::size_t tile) const {
    const TileId id = source_->entry(tile).tile;
    const Manifest& manifest = source_->manifest();
    const Box& box = manifest.boxes.at(id.value);
    if (!selection_->classes.empty() || selection_->times || !selection_->inputs.empty()) return true;
    if (places_.contains(id) || (selection_->box && meets(box, *selection_->box, manifest.dimension))) return true;
    return std::any_of(selection_->regions.begin(), selection_->regions.end(),
                       [&](const auto& region) { return meets(box, manifest.bounds, *region); });
  }

  Status select_in(std::size_t index, std::vector<PointId>& out) const {
    const std::size_t width = row_bytes(source_->manifest().schema);
    const bool with_rows = class_at_ || time_at_ || height_at_;
    BOOST_OUTCOME_TRY(tile, source_->read(index, {.cells = false, .rows = with_rows}));
    const auto places = places_.find(source_->entry(index).tile);
    for (std::size_t v = 0; v < tile.mesh.ids.size(); ++v) {
      if (tile.mesh.point_ghost[v] != 0) continue;
      const Point& at = tile.mesh.points[v];
      const PointId vertex = tile.mesh.ids[v];
      const bool by_place = is_at_place(at, places == places_.end() ? nullptr : &places->second);
      const auto row =
          with_rows ? std::span<const std::byte>(tile.rows).subspan(v * width, width) : std::span<const std::byte>();
      const bool by_row = is_selected_by_row(at, row);
      if (by_place || by_row || is_of_input(vertex)) out.push_back(vertex);
      auto pair = std::lower_bound(by_kept_.begin(), by_kept_.end(), std::pair(vertex, std::size_t{0}));
      for (; pair != by_kept_.end() && pair->first == vertex; ++pair) {
        const PointId duplicate = duplicates_.pairs()[pair->second].duplicate;
        const bool own = with_rows && duplicates_.has_rows();
        const bool selected = own ? is_selected_by_row(at, duplicates_.row_of(pair->second)) : by_row;
        if (by_place || selected || is_of_input(duplicate)) out.push_back(duplicate);
      }
    }
    return success();
  }

 private:
  Selector(const TileSource& source, const PointSelection& selection) : source_(&source), selection_(&selection) {}

  // By what equal points have in common.
  bool is_at_place(const Point& p, const std::vector<Point>* places) const {
    if (places != nullptr && std::binary_search(places->begin(), places->end(), p)) return true;
    return std::any_of(selection_->regions.begin(), selection_->regions.end(), [&](const auto& region) {
      return region->covers({p.x, p.y, 0});
    });
  }

  bool is_in_box(const Point& p, std::span<const std::byte> row) const {
    if (!selection_->box) return false;
    const Box& box = *selection_->box;
    if (!(box.lo.x <= p.x && p.x <= box.hi.x && box.lo.y <= p.y && p.y <= box.hi.y)) return false;
    if (source_->manifest().dimension == 2 && !height_at_) return true;
    const bool any = std::isinf(box.lo.z) && std::isinf(box.hi.z);  // an unknown height (NaN), too
    const double z = height_at_ ? number_in<double>(row, *height_at_) : p.z;
    return any || (box.lo.z <= z && z <= box.hi.z);
  }

  // By what each of equal points has for itself. `row`: empty when no attribute is needed.
  bool is_selected_by_row(const Point& p, std::span<const std::byte> row) const {
    if (is_in_box(p, row)) return true;
    if (time_at_) {
      const auto time = number_in<double>(row, *time_at_);
      if (selection_->times->from <= time && time <= selection_->times->to) return true;
    }
    if (!class_at_) return false;
    const int of_point = std::to_integer<int>(row[*class_at_]);
    return std::find(selection_->classes.begin(), selection_->classes.end(), of_point) != selection_->classes.end();
  }

  bool is_of_input(PointId id) const {
    return std::any_of(selection_->inputs.begin(), selection_->inputs.end(),
                       [&](const auto& ids) { return ids.first <= id.value && id.value - ids.first < ids.count; });
  }

  const TileSource* source_;
  const PointSelection* selection_;
  std::optional<std::size_t> class_at_, time_at_, height_at_;  // in a row
  OldDuplicates duplicates_;
  std::vector<std::pair<PointId, std::size_t>> by_kept_;  // numbers of pairs
  std::map<TileId, std::vector<Point>> places_;
};

std::string text_of(const Manifest::Input::Ids& ids) {
  if (ids.count == 0) return "no points";
  return "points " + std::to_string(ids.first) + " to " + std::to_string(ids.first + (ids.count - 1));
}

// Links are not followed: the file need not exist any more.
fs::path absolute(const fs::path& path) {
  std::error_code failed;
  const fs::path whole = fs::absolute(path, failed);
  return (failed ? path : whole).lexically_normal();
}

std::vector<const Manifest::Input*> inputs_of(const Manifest& manifest, const std::string& file) {
  std::vector<const Manifest::Input*> found;
  for (const Manifest::Input& input : manifest.inputs) {
    if (input.path == file || absolute(input.path) == absolute(file)) found.push_back(&input);
  }
  return found;
}

// Those of PATH@FIRST.
std::vector<const Manifest::Input*> numbered_inputs_of(const Manifest& manifest, const std::string& file) {
  const std::size_t at = file.rfind('@');
  if (at == std::string::npos) return {};
  auto found = inputs_of(manifest, file.substr(0, at));
  std::erase_if(found, [&](const auto* input) {
    return !input->ids || std::to_string(input->ids->first) != file.substr(at + 1);
  });
  return found;
}

}  // namespace

Result<std::vector<PointId>> select_points(const TileSource& source, const PointSelection& selection, unsigned threads,
                                           const std::stop_token& stop) {
  std::vector<PointId> selected;
  if (selection.empty()) return selected;
  BOOST_OUTCOME_TRY(selector, Selector::make(source, selection));
  std::vector<std::size_t> tiles;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    if (selector.is_wanted(i)) tiles.push_back(i);
  }
  std::mutex mutex;
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> next{0};
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    for (std::size_t i = next++; i < tiles.size() && !failed; i = next++) {
      throw_if_stopped(stop);
      std::vector<PointId> of_tile;
      BOOST_OUTCOME_TRYV(selector.select_in(tiles[i], of_tile));
      const std::lock_guard lock(mutex);
      selected.insert(selected.end(), of_tile.begin(), of_tile.end());
    }
    return success();
  }));
  std::sort(selected.begin(), selected.end());
  return selected;
}

Result<Manifest::Input::Ids> ids_of_input(const fs::path& result, const Manifest& manifest, const std::string& file) {
  auto found = inputs_of(manifest, file);
  if (found.empty()) found = numbered_inputs_of(manifest, file);
  const auto refuse = [&](const std::string& why) { return error(Errc::usage, result.string() + ": " + why); };
  if (found.empty()) {
    std::string names;
    constexpr std::size_t shown = 8;
    for (std::size_t i = 0; i < std::min(shown, manifest.inputs.size()); ++i)
      names += (i == 0 ? "" : ", ") + manifest.inputs[i].path;
    if (manifest.inputs.size() > shown) names += " and " + std::to_string(manifest.inputs.size() - shown) + " more";
    return refuse("no points came from '" + file + "'; the inputs are " + (names.empty() ? "not known" : names));
  }
  if (std::any_of(found.begin(), found.end(), [](const auto* input) { return !input->ids.has_value(); }))
    return refuse("the manifest does not tell which points came from '" + file +
                  "', because older software wrote it; remove them by place, time or source index");
  if (found.size() == 1) return *found.front()->ids;
  std::string names;
  for (const auto* input : found) names += (names.empty() ? "" : ", ") + text_of(*input->ids);
  return refuse("'" + file + "' was read " + std::to_string(found.size()) + " times (" + names +
                "); name one of them by its first point, for example '" + found.back()->path + "@" +
                std::to_string(found.back()->ids->first) + "'");
}

}  // namespace tessera
