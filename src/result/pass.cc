#include "src/result/pass.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "src/base/files/disk_file.h"
#include "src/base/files/names.h"
#include "src/base/files/pass_names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/tile_queue.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// A vertex, and a tile that has it as a foreign vertex.
struct Sent {
  TileId to;
  std::int32_t vertex = 0;
  friend auto operator<=>(const Sent&, const Sent&) = default;
};

// Returns the receivers of the tile's own vertices. A tile has exactly the cells with a vertex of its own. So the other
// owners of a cell's vertices are the tiles that have the cell, too. If a foreign vertex is an image of an own one,
// this tile has another copy of the cell, in which the cell's other vertices are images: then the tile is its own
// receiver.
std::vector<Sent> receivers(const TileMesh& mesh) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<Sent> sent;
  std::size_t sorted = 0;
  const auto sort = [&] {
    std::sort(sent.begin(), sent.end());
    sent.erase(std::unique(sent.begin(), sent.end()), sent.end());
    sorted = sent.size();
  };
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
    for (std::size_t k = 0; k < corners; ++k) {
      const auto other = static_cast<std::size_t>(mesh.cells[at + k]);
      if (mesh.point_ghost[other] == 0) continue;
      const TileId to = mesh.owners[other];
      for (std::size_t i = 0; i < corners; ++i) {
        const std::int32_t v = mesh.cells[at + i];
        if (mesh.point_ghost[static_cast<std::size_t>(v)] == 0) sent.push_back({to, v});
      }
    }
    // The same vertex comes many times. Sorting now and then keeps the list at most about twice as long as its final
    // length.
    if (sent.size() > 2 * sorted + (std::size_t{1} << 20)) sort();
  }
  sort();
  return sent;
}

Error contradiction(const TileSource& source, std::size_t index, PointId id, const std::string& what) {
  return error(Errc::corrupt, source.file(index).string() + ": foreign vertex " + to_string(id) + " " + what);
}

}  // namespace

std::size_t Pass::row_bytes() const {
  std::size_t bytes = 0;
  for (const auto& column : columns_) bytes += column.of_cells ? 0 : size_of(column.as.type);
  return bytes;
}

std::uint64_t Pass::scratch_bytes() const {
  std::uint64_t of_a_cell = 0, bytes = 0;
  for (const auto& column : columns_) of_a_cell += column.of_cells ? size_of(column.as.type) : 0;
  for (const auto& entry : source_.manifest().tiles) {
    bytes += entry.cells * of_a_cell + entry.points * row_bytes();
    if (row_bytes() > 0)
      bytes += (entry.points - std::min(entry.points, entry.own_points)) * (sizeof(PointId) + row_bytes());
  }
  return bytes;
}

Status Pass::run(const Compute& compute, const Consumer& take) {
  constexpr double computing_part = 0.6;
  BOOST_OUTCOME_TRYV(make_directories(pass_values_file(scratch_, {}).parent_path()));
  BOOST_OUTCOME_TRYV(make_directories(pass_sent_file(scratch_, {}).parent_path()));
  BOOST_OUTCOME_TRYV(on_tiles(0, computing_part, options_.tile_factor, [&](std::size_t index) -> Status {
    BOOST_OUTCOME_TRY(tile, source_.read(index, {}));
    BOOST_OUTCOME_TRY(values, compute(index, tile));
    BOOST_OUTCOME_TRYV(put_down(index, tile, values));
    return send(index, tile, values);
  }));
  // This pass needs memory for values and vertices, and for what the function keeps of them.
  return on_tiles(computing_part, 1, 1, [&](std::size_t index) -> Status {
    BOOST_OUTCOME_TRY(values, read_values(index));
    if (row_bytes() > 0) {
      BOOST_OUTCOME_TRYV(fill_foreign(index, values));
    }
    return take(index, values);
  });
}

Status Pass::on_tiles(double from, double to, double tile_factor, const std::function<Status(std::size_t)>& work) {
  const auto told = [&](double done) {
    if (options_.progress) options_.progress(from + (to - from) * done);
  };
  return for_each_tile(source_,
                       {.threads = options_.threads,
                        .memory_bytes = options_.memory_bytes,
                        .tile_factor = tile_factor,
                        .stop = options_.stop,
                        .progress = told},
                       [&](const TileSource&, std::size_t index) { return work(index); });
}

Status Pass::put_down(std::size_t index, const StoredTile& tile, const PassValues& values) {
  if (values.size() != columns_.size()) return error(Errc::internal, "a pass has another number of columns");
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const std::size_t rows = columns_[c].of_cells ? tile.mesh.cell_ghost.size() : tile.mesh.points.size();
    if (values[c].size() != rows * size_of(columns_[c].as.type))
      return error(Errc::internal, "a pass has not one value for each row");
  }
  BOOST_OUTCOME_TRY(file,
                    DiskFile::open(pass_values_file(scratch_, source_.entry(index).tile), DiskFile::Mode::replace));
  for (const auto& column : values) {
    BOOST_OUTCOME_TRYV(file.write(column));
  }
  return file.close();
}

// A record is an id and a row of the columns of vertices.
Status Pass::send(std::size_t index, const StoredTile& tile, const PassValues& values) {
  if (row_bytes() == 0) return success();
  const auto sent = receivers(tile.mesh);
  std::vector<std::byte> records;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    const auto vertex = static_cast<std::size_t>(sent[i].vertex);
    const auto id = std::as_bytes(std::span(&tile.mesh.ids[vertex], 1));
    records.insert(records.end(), id.begin(), id.end());
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].of_cells) continue;
      const std::size_t size = size_of(columns_[c].as.type);
      const auto value = std::span(values[c]).subspan(vertex * size, size);
      records.insert(records.end(), value.begin(), value.end());
    }
    if (i + 1 < sent.size() && sent[i + 1].to == sent[i].to) continue;
    const auto to = source_.find(sent[i].to);
    if (!to)
      return error(Errc::corrupt, source_.file(index).string() + ": a vertex is of tile " + to_string(sent[i].to) +
                                      ", which the manifest does not have");
    BOOST_OUTCOME_TRYV(append(*to, records));
    records.clear();
  }
  return success();
}

Status Pass::append(std::size_t to, std::span<const std::byte> records) {
  const std::lock_guard lock(appending_[to % appending_.size()]);
  BOOST_OUTCOME_TRY(file, DiskFile::open(pass_sent_file(scratch_, source_.entry(to).tile), DiskFile::Mode::append));
  BOOST_OUTCOME_TRYV(file.write(records));
  return file.close();
}

Result<PassValues> Pass::read_values(std::size_t index) const {
  const TileEntry& entry = source_.entry(index);
  const auto path = pass_values_file(scratch_, entry.tile);
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  PassValues values(columns_.size());
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    values[c].resize((columns_[c].of_cells ? entry.cells : entry.points) * size_of(columns_[c].as.type));
    BOOST_OUTCOME_TRY(read, file.read(values[c]));
    if (read != values[c].size()) return error(Errc::io, path.string() + ": is shorter than it was");
  }
  return values;
}

// `row` begins with the values of the columns of vertices.
void Pass::fill_row(std::span<const std::byte> row, std::size_t vertex, PassValues& values) const {
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].of_cells) continue;
    const std::size_t size = size_of(columns_[c].as.type);
    std::memcpy(&values[c][vertex * size], row.data(), size);
    row = row.subspan(size);
  }
}

Status Pass::fill_foreign(std::size_t index, PassValues& values) const {
  BOOST_OUTCOME_TRY(tile, source_.read(index, {.cells = false}));
  const TileMesh& mesh = tile.mesh;
  std::vector<std::pair<PointId, std::size_t>> foreign;
  for (std::size_t v = 0; v < mesh.ids.size(); ++v)
    if (mesh.point_ghost[v] != 0) foreign.emplace_back(mesh.ids[v], v);
  std::sort(foreign.begin(), foreign.end());
  if (foreign.empty()) return success();
  const auto path = pass_sent_file(scratch_, source_.entry(index).tile);
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return contradiction(source_, index, foreign.front().first, "is missing in the tile that owns it");
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  const std::size_t record = sizeof(PointId) + row_bytes();
  std::vector<std::byte> buffer(record * 4096);
  std::vector<std::uint8_t> filled(foreign.size(), 0);
  for (;;) {
    BOOST_OUTCOME_TRY(read, file.read(buffer));
    for (std::size_t at = 0; at + record <= read; at += record) {
      PointId id;
      std::memcpy(&id, &buffer[at], sizeof id);
      auto found = std::lower_bound(foreign.begin(), foreign.end(), std::pair(id, std::size_t{0}));
      if (found == foreign.end() || found->first != id)
        return contradiction(source_, index, id,
                             "is missing, though its tile has a cell that belongs in this tile, too");
      for (; found != foreign.end() && found->first == id; ++found) {  // the images of the point
        filled[static_cast<std::size_t>(found - foreign.begin())] = 1;
        fill_row(std::span(buffer).subspan(at + sizeof id), found->second, values);
      }
    }
    if (read < buffer.size()) break;
  }
  const auto missing = std::find(filled.begin(), filled.end(), 0);
  if (missing == filled.end()) return success();
  return contradiction(source_, index, foreign[static_cast<std::size_t>(missing - filled.begin())].first,
                       "is missing in the tile that owns it");
}

}  // namespace tessera
