#include "src/surface/smooth.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/files/folder.h"
#include "src/base/files/surface_names.h"
#include "src/base/on_threads.h"
#include "src/surface/arrays.h"
#include "src/surface/spilling_queue.h"

namespace tessera::surface {

namespace {

// The factors of the two steps. Taubin's pass band ends at 1 / forth + 1 / back = 0.1.
constexpr double forth = 0.5, back = -1 / 1.9;
constexpr std::uint64_t mail_part = 16;  // a part of the memory, for each of two turns

// The new position of a vertex of another tile.
struct PlaceRecord {
  PointId vertex;
  Point at;
};

// The vertices of a tile's triangles while they move.
struct Sheet {
  std::vector<Point> at;                // by vertex
  std::vector<std::uint32_t> first;     // by own vertex: where its neighbours begin
  std::vector<std::uint32_t> beside;    // neighbours of own vertices, ordered by their ids
  std::vector<std::uint8_t> ends;       // by own vertex: 1 where the surface ends, so that it stays
  std::vector<std::uint64_t> ids;       // of foreign vertices, ascending
  std::vector<std::uint32_t> foreign;   // beside ids: which vertices they are
  std::vector<std::uint32_t> told, to;  // own vertices, and the numbers of the other tiles that hold them
  std::vector<std::uint64_t> told_ids;  // ids of these vertices

  template <class Self, class Use>
  static void each(Self& self, const Use& use) {
    use(self.at);
    use(self.first);
    use(self.beside);
    use(self.ends);
    use(self.ids);
    use(self.foreign);
    use(self.told);
    use(self.to);
    use(self.told_ids);
  }
  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    each(*this, [&](const auto& array) { sum += array.size() * sizeof array[0]; });
    return sum;
  }
};

double height_of(const StoredTile& tile, std::size_t v, std::size_t width) {
  double z = 0;
  std::memcpy(&z, tile.rows.data() + v * width, sizeof z);
  return z;
}

// Makes the sheet of a tile. REQUIRES: own vertices come first.
Result<Sheet> sheet_of(const TileSource& source, const StoredTile& tile, TileId self) {
  const TileMesh& mesh = tile.mesh;
  const std::size_t n = mesh.points.size(), width = row_bytes(tile.schema);
  Sheet sheet;
  std::size_t own = 0;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> foreign;
  for (std::size_t v = 0; v < n; ++v) {
    const Point& p = mesh.points[v];
    sheet.at.push_back({p.x, p.y, height_of(tile, v, width)});
    if (mesh.owners[v] == self) {
      own = v + 1;
    } else {
      foreign.emplace_back(mesh.ids[v].value, static_cast<std::uint32_t>(v));
    }
  }
  std::ranges::sort(foreign);
  for (const auto& [id, v] : foreign) {
    sheet.ids.push_back(id);
    sheet.foreign.push_back(v);
  }
  std::vector<std::array<std::uint32_t, 2>> edges;  // from own vertices
  for (std::size_t at = 0; at < mesh.cells.size(); at += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::uint32_t>(mesh.cells[at + k]);
      if (v >= own) continue;
      for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3})
        edges.push_back({v, static_cast<std::uint32_t>(mesh.cells[at + other])});
    }
  }
  std::ranges::sort(edges, {}, [&](const auto& edge) { return std::pair(edge[0], mesh.ids[edge[1]]); });
  sheet.first.assign(own + 1, 0);
  sheet.ends.assign(own, 0);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end] == edges[i]) ++end;
    const auto [v, other] = edges[i];
    if ((end - i) % 2 != 0) sheet.ends[v] = 1;
    sheet.beside.push_back(other);
    ++sheet.first[v + 1];
    if (mesh.owners[other] != self) {
      const auto place = source.find(TileId{mesh.owners[other]});
      if (!place) return error(Errc::internal, "a triangle has a vertex of a tile without triangles");
      const auto number = static_cast<std::uint32_t>(*place);
      bool known = false;
      for (std::size_t k = sheet.told.size(); k > 0 && sheet.told[k - 1] == v; --k) known |= sheet.to[k - 1] == number;
      if (!known) {
        sheet.told.push_back(v);
        sheet.told_ids.push_back(mesh.ids[v].value);
        sheet.to.push_back(number);
      }
    }
    i = end;
  }
  for (std::size_t v = 0; v < own; ++v) sheet.first[v + 1] += sheet.first[v];
  return sheet;
}

// Moves own vertices, by the positions of all vertices before.
void move(Sheet& sheet, double factor) {
  const std::size_t own = sheet.ends.size();
  std::vector<Point> moved(own);
  for (std::size_t v = 0; v < own; ++v) {
    const Point& p = sheet.at[v];
    moved[v] = p;
    if (sheet.ends[v] != 0) continue;
    Point sum{};
    for (std::uint32_t i = sheet.first[v]; i < sheet.first[v + 1]; ++i)
      for (int axis = 0; axis < 3; ++axis) sum[axis] += sheet.at[sheet.beside[i]][axis];
    const double count = sheet.first[v + 1] - sheet.first[v];
    for (int axis = 0; axis < 3; ++axis) moved[v][axis] = p[axis] + factor * (sum[axis] / count - p[axis]);
  }
  std::ranges::copy(moved, sheet.at.begin());
}

class Smoother {
 public:
  Smoother(const TileSource& source, const std::filesystem::path& scratch, const SmoothOptions& options)
      : source_(source),
        options_(options),
        sheets_(surface_tiles_folder(scratch)),
        mail_{Mail(surface_mail_folder(scratch, 0), source.tiles(), options.how.memory_bytes / mail_part),
              Mail(surface_mail_folder(scratch, 1), source.tiles(), options.how.memory_bytes / mail_part)},
        here_(source.tiles()) {}

  Status run(TriangleStore& to) {
    BOOST_OUTCOME_TRYV(
        for_each_tile(source_, {.rows = true}, options_.how, [&](std::size_t i, StoredTile tile) -> Status {
          BOOST_OUTCOME_TRY(sheet, sheet_of(source_, tile, source_.entry(i).tile));
          return put(i, std::move(sheet));
        }));
    for (unsigned turn = 0; turn < 2 * options_.rounds; ++turn) {
      BOOST_OUTCOME_TRYV(step(turn));
      if (options_.progress) options_.progress((turn + 1.0) / (2 * options_.rounds + 1));
    }
    return for_each_tile(source_, {.rows = true}, options_.how, [&](std::size_t i, StoredTile tile) -> Status {
      BOOST_OUTCOME_TRY(sheet, take(i, 2 * options_.rounds));
      const std::size_t width = row_bytes(tile.schema);
      for (std::size_t v = 0; v < sheet.at.size(); ++v) {
        tile.mesh.points[v] = {sheet.at[v].x, sheet.at[v].y, 0};
        std::memcpy(tile.rows.data() + v * width, &sheet.at[v].z, sizeof(double));
      }
      return to.add(source_.entry(i).tile, tile, options_.how.stop);
    });
  }

 private:
  using Mail = SpillingQueue<PlaceRecord>;

  // Does one step. Messages of one turn are read in the next.
  Status step(unsigned turn) {
    std::atomic<std::size_t> next{0};
    return on_threads(options_.how.threads, stopped_, [&]() -> Status {
      for (std::size_t i = next++; i < source_.tiles() && !stopped_; i = next++) {
        if (options_.how.stop.stop_requested()) return error(Errc::interrupted, "interrupted while smoothing");
        BOOST_OUTCOME_TRY(sheet, take(i, turn));
        move(sheet, turn % 2 == 0 ? forth : back);
        SendBuffer<PlaceRecord> out(mail_[(turn + 1) % 2], source_.tiles());
        for (std::size_t k = 0; k < sheet.told.size(); ++k) {
          BOOST_OUTCOME_TRYV(out.add(sheet.to[k], {{sheet.told_ids[k]}, sheet.at[sheet.told[k]]}));
        }
        BOOST_OUTCOME_TRYV(out.send());
        BOOST_OUTCOME_TRYV(put(i, std::move(sheet)));
      }
      return success();
    });
  }

  Result<Sheet> take(std::size_t i, unsigned turn) {
    Sheet sheet;
    std::unique_lock lock(mutex_);
    if (here_[i]) {
      sheet = *std::exchange(here_[i], std::nullopt);
      held_ -= sheet.bytes();
      lock.unlock();
    } else {
      lock.unlock();
      BOOST_OUTCOME_TRYV(
          load_arrays(surface_cells_file(sheets_, i), [&](const auto& use) { Sheet::each(sheet, use); }));
    }
    BOOST_OUTCOME_TRY(mail, mail_[turn % 2].take(i));
    for (const PlaceRecord& record : mail) {
      const auto found = std::ranges::lower_bound(sheet.ids, record.vertex.value);
      if (found == sheet.ids.end() || *found != record.vertex.value)
        return error(Errc::internal, "a tile has received a position of a vertex that it does not have");
      sheet.at[sheet.foreign[static_cast<std::size_t>(found - sheet.ids.begin())]] = record.at;
    }
    return sheet;
  }

  Status put(std::size_t i, Sheet sheet) {
    {
      const std::lock_guard lock(mutex_);
      if (held_ + sheet.bytes() <= options_.how.memory_bytes / 2) {
        held_ += sheet.bytes();
        here_[i] = std::move(sheet);
        return success();
      }
    }
    return save_arrays(surface_cells_file(sheets_, i), [&](const auto& use) { Sheet::each(sheet, use); });
  }

  const TileSource& source_;
  const SmoothOptions& options_;
  std::filesystem::path sheets_;
  std::array<Mail, 2> mail_;
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::vector<std::optional<Sheet>> here_;
  std::uint64_t held_ = 0;
};

}  // namespace

Status smooth(const TileSource& from, TriangleStore& to, const std::filesystem::path& scratch,
              const SmoothOptions& options) {
  for (const auto& folder :
       {surface_tiles_folder(scratch), surface_mail_folder(scratch, 0), surface_mail_folder(scratch, 1)}) {
    BOOST_OUTCOME_TRYV(make_directories(folder));
  }
  return Smoother(from, scratch, options).run(to);
}

}  // namespace tessera::surface
