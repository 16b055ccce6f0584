#include "src/result/tile_source.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/geometry/kernel/kernel.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/check_sum.h"
#include "src/result/held_manifest.h"
#include "src/result/store/period.h"
#include "src/result/store/points_file.h"
#include "src/tiling/tile/rebuild.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

template <class Flags>
std::uint64_t count_zeros(const Flags& flags) {
  return static_cast<std::uint64_t>(std::count(flags.begin(), flags.end(), 0));
}

constexpr const char *other_dimension = "has another dimension than the manifest says",
                     *other_numbers = "holds other numbers of vertices or cells than the manifest says",
                     *other_attributes = "has other attributes than the manifest says",
                     *other_cell_columns = "has other columns of cells than the manifest says";

// Describes the first difference between the tile and what the manifest says; empty when there is none.
std::string difference(const Manifest& manifest, const TileEntry& entry, const StoredTile& tile, bool with_cells) {
  const TileMesh& mesh = tile.mesh;
  if (mesh.dimension != manifest.dimension) return other_dimension;
  if (mesh.points.size() != entry.points || count_zeros(mesh.point_ghost) != entry.own_points ||
      (with_cells && (mesh.cell_ghost.size() != entry.cells || count_zeros(mesh.cell_ghost) != entry.main_cells)))
    return other_numbers;
  if (with_cells && entry.cells > 0 && mesh.neighbors.empty() == manifest.neighbors)
    return manifest.neighbors ? "has no neighbours, though the manifest says that it has"
                              : "has neighbours, though the manifest says that it has none";
  if (tile.schema != manifest.schema) return other_attributes;
  if (tile.cell_schema != cell_schema_of(manifest)) return other_cell_columns;
  return {};
}

Status check_period(const fs::path& out, const Manifest& manifest, Periods periods) {
  if (periods == Periods::known || !period_of(manifest).any()) return success();
  return error(Errc::usage, out.string() +
                                ": holds the triangulation of a periodic cloud, which can be verified, measured, "
                                "exported, described, materialised, and read by the library, and nothing else yet");
}

}  // namespace

Result<TileSource> TileSource::open(const fs::path& out, Periods periods) {
  const auto named = named_version(out);
  const fs::path folder = named ? named->out : out;
  if (result::is_far(folder)) {
    BOOST_OUTCOME_TRY(manifest, result::read_far_manifest(folder));
    if (named && named->version != manifest.version)
      return error(Errc::usage, folder.string() + ": only the newest version of a result in an object store can be " +
                                    "read, which is version " + std::to_string(manifest.version));
    BOOST_OUTCOME_TRYV(check_period(out, manifest, periods));
    const Period period = period_of(manifest);
    return TileSource(std::make_shared<const Inside>(
        Inside{folder, std::move(manifest), FileHandle{}, std::make_shared<result::FarFiles>(), {}, period}));
  }
  BOOST_OUTCOME_TRY(held, named ? result::hold_version(folder, named->version) : result::hold_manifest(folder));
  BOOST_OUTCOME_TRYV(check_period(out, held.manifest, periods));
  const Period period = period_of(held.manifest);
  return TileSource(
      std::make_shared<const Inside>(Inside{folder, std::move(held.manifest), std::move(held.file), {}, {}, period}));
}

TileSource TileSource::draft(fs::path folder, Manifest manifest) {
  const Period period = period_of(manifest);
  return TileSource(
      std::make_shared<const Inside>(Inside{std::move(folder), std::move(manifest), FileHandle{}, {}, {}, period}));
}

TileSource TileSource::without_columns() const {
  if (manifest().columns.empty()) return *this;
  TileSource plain(std::make_shared<const Inside>(Inside{folder(),
                                                         tessera::without_columns(manifest()),
                                                         FileHandle{},
                                                         inside_->far,
                                                         {inside_, &inside_->manifest},
                                                         period()}));
  plain.stop_ = stop_;
  return plain;
}

std::optional<std::size_t> TileSource::find(TileId tile) const {
  const auto& all = manifest().tiles;
  const auto found = std::lower_bound(all.begin(), all.end(), tile,
                                      [](const TileEntry& entry, TileId wanted) { return entry.tile < wanted; });
  if (found == all.end() || found->tile != tile) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

TileSource TileSource::stopped_by(std::stop_token stop) const {
  TileSource same(*this);
  same.stop_ = std::move(stop);
  return same;
}

fs::path TileSource::file(TileId tile) const {
  const auto i = find(tile);
  return i ? file(*i) : tile_file(folder(), tile);
}

Status TileSource::check(std::size_t i) const {
  return check(file(i), {entry(i).bytes, entry(i).xxh3, data_sum_of(manifest().format_version)});
}

Status TileSource::check(const fs::path& file, const result::ToldFile& told) const {
  if (!is_far()) return check_sum(file, told.xxh3, told.sum);
  BOOST_OUTCOME_TRYV(inside_->far->whole(file, told, stop_));
  return success();
}

Result<DataFile> TileSource::open_file(std::size_t i) const {
  if (!is_far()) return DataFile::open(file(i));
  return inside_->far->whole(file(i), {entry(i).bytes, entry(i).xxh3, data_sum_of(manifest().format_version)}, stop_);
}

Result<std::vector<DuplicatePair>> TileSource::read_duplicates() const {
  if (!is_far()) return tessera::read_duplicates(folder(), manifest());
  const Manifest& told = manifest();
  if (told.duplicates_xxh3 == 0) return std::vector<DuplicatePair>{};
  constexpr std::uint64_t bytes_max = std::uint64_t{1} << 40;  // more than any memory
  if (told.duplicates > bytes_max / sizeof(DuplicatePair))
    return error(Errc::corrupt, manifest_file(folder()).string() + ": tells of too many duplicates");
  const result::ToldFile file{told.duplicates * sizeof(DuplicatePair), told.duplicates_xxh3,
                              data_sum_of(told.format_version)};
  BOOST_OUTCOME_TRY(opened, inside_->far->whole(duplicates_of(folder(), told), file, stop_));
  std::vector<std::byte> bytes(file.bytes);
  BOOST_OUTCOME_TRYV(opened.read_up_to(0, bytes));
  return parse_duplicates(opened.path(), bytes, told.keep);
}

// A kernel has a row of 32 bytes for each cell, and the mesh is made from these rows.
std::uint64_t TileSource::work_bytes(std::size_t i) const {
  const TileEntry& tile = entry(i);
  if (tile.kind == TileKind::cells) return tile.bytes;
  const std::uint64_t corners = static_cast<std::uint64_t>(manifest().dimension) + 1;
  const std::uint64_t cells = tile.cells + tile.cells / 8;  // and cells of foreign vertices alone
  return cells * (sizeof(CellRecord) + 9 + 8 * corners) + tile.points * (96 + row_bytes(manifest().schema)) +
         tile.cells * row_bytes(cell_schema_of(manifest()));
}

namespace {

// The first `narrow` bytes of each row of `width` bytes.
std::vector<std::byte> narrowed(const std::vector<std::byte>& rows, std::size_t width, std::size_t narrow) {
  if (width == 0 || narrow == width) return rows;
  std::vector<std::byte> out(rows.size() / width * narrow);
  for (std::size_t i = 0; i * narrow < out.size(); ++i)
    std::memcpy(out.data() + i * narrow, rows.data() + i * width, narrow);
  return out;
}

// Permutes rows of `width` bytes: row i comes from `from[i]`.
std::vector<std::byte> permuted(const std::vector<std::byte>& rows, std::size_t width,
                                const std::vector<std::uint32_t>& from) {
  std::vector<std::byte> out(rows.size());
  for (std::size_t k = 0; k < from.size(); ++k) {
    std::memcpy(out.data() + k * width, rows.data() + from[k] * width, width);
  }
  return out;
}

}  // namespace

Result<PointsTile> TileSource::read_as_points(std::size_t i, const PointsFields& fields) const {
  BOOST_OUTCOME_TRY(tile, read_points_with_columns(i, fields));
  if (inside_->whole) {
    tile.rows = narrowed(tile.rows, row_bytes(tile.schema), row_bytes(manifest().schema));
    tile.schema = manifest().schema;
    tile.cell_schema.clear();
    tile.cell_columns.clear();
  }
  return std::move(tile);
}

// Small blocks can claim many points and cells. So the numbers are compared with the manifest before memory is taken.
Result<PointsTile> TileSource::read_points_with_columns(std::size_t i, const PointsFields& fields) const {
  BOOST_OUTCOME_TRY(at_head, open_file(i));
  BOOST_OUTCOME_TRY(head, read_points_head(std::move(at_head), entry(i).tile));
  const TileEntry& tile = entry(i);
  const char* found =
      head.dimension != manifest().dimension ? other_dimension
      : head.own != tile.own_points || head.own + head.foreign != tile.points || head.cells != tile.cells
          ? other_numbers
      : head.schema() != whole().schema               ? other_attributes
      : head.cell_schema() != cell_schema_of(whole()) ? other_cell_columns
                                                      : nullptr;
  if (found != nullptr) return error(Errc::corrupt, file(i).string() + ": " + found);
  BOOST_OUTCOME_TRY(whole_file, open_file(i));
  BOOST_OUTCOME_TRY(points, read_points_file(std::move(whole_file), tile.tile, fields));
  for (std::size_t k = 0; k < points.ids.size(); ++k) {
    const std::uint32_t code = offset_code(points.ids[k]);
    if (code != offset_code(points.owners[k]) || !has_offset(code) || (k < points.own && code != 0))
      return error(Errc::corrupt, file(i).string() + ": a source index is too large");
  }
  return std::move(points);
}

bool TileSource::has_offset(std::uint32_t code) const {
  return code < image::codes && period().allows(image::offset(code));
}

// In the file, foreign vertices are in the order that suits a kernel; in the mesh they are sorted by id.
Result<StoredTile> TileSource::read_points(std::size_t i, const TileFields& fields) const {
  const auto path = file(i);
  BOOST_OUTCOME_TRY(
      tile, read_points_with_columns(i, {.rows = fields.rows, .cell_columns = fields.cells && fields.cell_columns}));
  const std::size_t n = tile.points.size(), own = tile.own;
  std::vector<std::uint32_t> from;  // by index in the mesh
  if (fields.rows || !fields.cells) {
    from.resize(own);
    std::iota(from.begin(), from.end(), 0u);
    for (const std::uint32_t k : by_id(std::span(tile.ids).subspan(own)))
      from.push_back(static_cast<std::uint32_t>(own) + k);
  }
  StoredTile stored;
  stored.schema = std::move(tile.schema);
  stored.cell_schema = std::move(tile.cell_schema);
  stored.cell_columns = std::move(tile.cell_columns);
  if (fields.rows) stored.rows = permuted(tile.rows, row_bytes(stored.schema), from);
  TileMesh& mesh = stored.mesh;
  if (fields.cells) {
    auto rebuilt = rebuild({.dimension = tile.dimension,
                            .self = tile.tile,
                            .own = own,
                            .points = std::move(tile.points),
                            .ids = std::move(tile.ids),
                            .owners = std::move(tile.owners),
                            .stop = stop_});
    if (!rebuilt) return error(rebuilt.error().code, path.string() + ": " + rebuilt.error().where);
    mesh = std::move(rebuilt).value();
    if (!manifest().neighbors) mesh.neighbors = {};
    return stored;
  }
  mesh.dimension = tile.dimension;
  mesh.point_ghost.assign(n, 1);
  std::fill_n(mesh.point_ghost.begin(), own, std::uint8_t{0});
  bool images = false;
  for (const std::uint32_t k : from) {
    mesh.points.push_back(tile.points[k]);
    mesh.ids.push_back(plain(tile.ids[k]));
    mesh.owners.push_back(plain(tile.owners[k]));
    mesh.offsets.push_back(static_cast<std::uint8_t>(offset_code(tile.ids[k])));
    images |= mesh.offsets.back() != 0;
  }
  if (!images) mesh.offsets.clear();
  return stored;
}

Result<StoredTile> TileSource::read(std::size_t i, const TileFields& fields) const {
  const auto path = file(i);
  const bool of_points = entry(i).kind == TileKind::points;
  BOOST_OUTCOME_TRY(opened, open_file(i));
  const std::uint64_t bytes = opened.bytes();
  BOOST_OUTCOME_TRY(tile,
                    of_points ? read_points(i, fields) : store::read_tile(std::move(opened), entry(i).tile, fields));
  if (bytes != entry(i).bytes)
    return error(Errc::corrupt, path.string() + ": has " + std::to_string(bytes) + " bytes, but the manifest says " +
                                    std::to_string(entry(i).bytes));
  for (const std::uint8_t code : tile.mesh.offsets) {
    if (!has_offset(code)) return error(Errc::corrupt, path.string() + ": has images along an axis without a period");
  }
  if (const auto found = difference(whole(), entry(i), tile, fields.cells); !found.empty())
    return error(Errc::corrupt, path.string() + ": " + found);
  if (inside_->whole) {
    tile.rows = narrowed(tile.rows, row_bytes(tile.schema), row_bytes(manifest().schema));
    tile.schema = manifest().schema;
    tile.cell_schema.clear();
    tile.cell_columns.clear();
  }
  return std::move(tile);
}

Result<std::vector<PointId>> TileSource::read_own_ids(std::size_t i) const {
  BOOST_OUTCOME_TRY(opened, is_far() ? inside_->far->ranges(file(i), entry(i).bytes, stop_) : DataFile::open(file(i)));
  BOOST_OUTCOME_TRY(ids, entry(i).kind == TileKind::points ? read_own_point_ids(std::move(opened), entry(i).tile)
                                                           : store::read_own_ids(std::move(opened), entry(i).tile));
  if (ids.size() != entry(i).own_points)
    return error(Errc::corrupt, file(i).string() + ": holds another number of vertices than the manifest says");
  return std::move(ids);
}

}  // namespace tessera
