#include "src/result/export/point_table.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <set>
#include <utility>

#include "src/base/attribute_value.h"
#include "src/base/crs/survey_system.h"
#include "src/base/option.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t block_bytes = std::uint64_t{32} << 20, most_blocks = 4096;
constexpr std::size_t waiting_bytes_of_block = 16 << 10;

std::string unit_of(const Manifest& manifest, const std::string& name) {
  for (const auto& column : manifest.columns)
    if (!column.of_cells && column.name == name) return column.unit;
  for (const auto& attribute : manifest.schema)
    if (attribute.name == name) return attribute.unit;
  return {};
}

std::string names_of(const std::vector<Attribute>& schema) {
  std::string names;
  for (const auto& attribute : schema) names += (names.empty() ? "" : ", ") + attribute.name;
  return names.empty() ? "no attributes" : names;
}

Error two_rows(std::uint64_t id) {
  return error(Errc::corrupt, "two vertices of the result have the source index " + std::to_string(id));
}

}  // namespace

Result<PointTable> PointTable::open(const MeshSource& source, const std::vector<std::string>& names) {
  PointTable table(source);
  BOOST_OUTCOME_TRY(duplicates, source.tiles->read_duplicates());
  table.duplicates_ = std::move(duplicates);
  std::sort(table.duplicates_.begin(), table.duplicates_.end(), [](const DuplicatePair& a, const DuplicatePair& b) {
    return std::pair(a.kept, a.duplicate) < std::pair(b.kept, b.duplicate);
  });
  table.rows_ = source.manifest.vertices + table.duplicates_.size();
  BOOST_OUTCOME_TRYV(table.choose(names));
  return table;
}

void PointTable::add(std::string name, AttributeType type, std::string unit) {
  const auto taken = [&] {
    return std::any_of(columns_.begin(), columns_.end(),
                       [&](const TableColumn& column) { return column.name == name; });
  };
  while (taken()) name += '_';
  columns_.push_back({std::move(name), type, stride_, std::move(unit)});
  stride_ += size_of(type);
}

Status PointTable::choose(const std::vector<std::string>& names) {
  const Manifest& manifest = source_->manifest;
  add("id", AttributeType::u64, "");
  const CoordinateUnits units = coordinate_units(manifest.crs);
  const bool stated = units.horizontal.empty();  // then the unit is the one that the input states, if any
  add("x", AttributeType::f64, stated ? manifest.unit : units.horizontal);
  add("y", AttributeType::f64, stated ? manifest.unit : units.horizontal);
  if (manifest.dimension == 3) add("z", AttributeType::f64, stated ? manifest.unit : units.vertical);
  if (!duplicates_.empty()) {
    vertex_at_ = stride_;
    add("vertex", AttributeType::u64, "");
  }
  std::vector<std::string> wanted = names;
  if (wanted.empty())
    for (const auto& attribute : manifest.schema) wanted.push_back(attribute.name);
  std::set<std::string> given;
  for (const auto& name : wanted) {
    const auto found = column_of(manifest.schema, name);
    if (!found)
      return error(Errc::usage, source_->out.string() + ": has no attribute or column '" + name +
                                    "' of its vertices; " + option("names") + " can name " + names_of(manifest.schema));
    if (!given.insert(name).second) return error(Errc::usage, option("names") + ": names '" + name + "' twice");
    pieces_.push_back({found->offset, stride_, size_of(found->type)});
    add(name, found->type, unit_of(manifest, name));
  }
  return success();
}

PointId PointTable::vertex_of(const std::byte* row) const {
  PointId id;
  std::memcpy(&id, row + vertex_at_, sizeof id);  // without duplicates this is the id of the point
  return id;
}

std::span<const DuplicatePair> PointTable::duplicates_of(PointId vertex) const {
  const auto [first, last] = std::equal_range(duplicates_.begin(), duplicates_.end(), DuplicatePair{{}, vertex},
                                              [](const auto& a, const auto& b) { return a.kept < b.kept; });
  return {first, last};
}

std::uint64_t PointTable::points_at(PointId vertex) const { return 1 + duplicates_of(vertex).size(); }

Status PointTable::for_each(const fs::path& scratch,
                            const std::function<Status(std::span<const std::byte>)>& visit) const {
  const Manifest& manifest = source_->manifest;
  const TileSource tiles = source_->tiles->stopped_by(source_->stop);
  const std::size_t stored = tessera::row_bytes(manifest.schema);
  BOOST_OUTCOME_TRY(waiting, RowsById::create(scratch, manifest.points_read, stride_));
  const std::size_t place_bytes = sizeof(double) * static_cast<std::size_t>(manifest.dimension);
  std::vector<std::byte> row(stride_);
  std::uint64_t pushed = 0;
  const auto push = [&](PointId id) {
    ++pushed;
    std::memcpy(row.data(), &id, sizeof id);
    return waiting.push(row);
  };
  // Tells of progress and looks for a stop, between tiles and blocks of rows.
  const auto look = [&](double done) -> Status {
    if (source_->stop.stop_requested()) return error(Errc::interrupted, "interrupted while exporting");
    if (source_->options.progress) source_->options.progress(done);
    return success();
  };
  for (std::size_t index = 0; index < tiles.tiles(); ++index) {
    BOOST_OUTCOME_TRYV(look(0.5 * static_cast<double>(index) / static_cast<double>(tiles.tiles())));
    BOOST_OUTCOME_TRY(tile, tiles.read(index, {.cells = false, .rows = !pieces_.empty()}));
    for (std::size_t i = 0; i < tile.mesh.ids.size(); ++i) {
      if (tile.mesh.point_ghost[i] != 0) continue;
      const PointId id = tile.mesh.ids[i];
      std::memcpy(row.data() + sizeof id, &tile.mesh.points[i], place_bytes);
      if (vertex_at_ > 0) std::memcpy(row.data() + vertex_at_, &id, sizeof id);
      for (const Piece& piece : pieces_)
        std::memcpy(row.data() + piece.to, tile.rows.data() + i * stored + piece.from, piece.bytes);
      BOOST_OUTCOME_TRYV(push(id));
      for (const auto& pair : duplicates_of(id)) {
        BOOST_OUTCOME_TRYV(push(pair.duplicate));
      }
    }
  }
  if (pushed != rows_)
    return error(Errc::corrupt, source_->out.string() + ": its duplicates stand for points that are no vertices");
  std::uint64_t given = 0;
  return waiting.for_each([&](std::span<const std::byte> rows) -> Status {
    given += rows.size() / stride_;
    BOOST_OUTCOME_TRYV(look(0.5 + 0.5 * static_cast<double>(given) / static_cast<double>(rows_)));
    return visit(rows);
  });
}

RowsById::RowsById(FileHandle file, fs::path path, std::uint64_t ids, std::size_t stride)
    : file_(std::move(file)),
      path_(std::move(path)),
      ids_(ids),
      stride_(stride),
      waiting_bytes_(std::max<std::size_t>(1, waiting_bytes_of_block / stride) * stride),
      block_ids_(std::max<std::uint64_t>({1, block_bytes / stride, (ids + most_blocks - 1) / most_blocks})),
      blocks_((ids + block_ids_ - 1) / block_ids_) {}

Result<RowsById> RowsById::create(const fs::path& scratch, std::uint64_t ids, std::size_t stride) {
  BOOST_OUTCOME_TRY(file, nameless_file(scratch));
  return RowsById(std::move(file), scratch, ids, stride);
}

Status RowsById::push(std::span<const std::byte> row) {
  std::uint64_t id = 0;
  std::memcpy(&id, row.data(), sizeof id);
  if (id >= ids_)
    return error(Errc::corrupt, "a vertex of the result has the source index " + std::to_string(id) +
                                    ", but the input had " + std::to_string(ids_) + " points");
  const std::size_t index = id / block_ids_;
  Block& block = blocks_[index];
  if (block.written + block.waiting.size() / stride_ >= block_ids_) return two_rows(id);
  block.waiting.insert(block.waiting.end(), row.begin(), row.end());
  return block.waiting.size() < waiting_bytes_ ? Status(success()) : write(index);
}

Status RowsById::write(std::size_t index) {
  Block& block = blocks_[index];
  const std::uint64_t at = (index * block_ids_ + block.written) * stride_;
  BOOST_OUTCOME_TRYV(write_at(file_.get(), block.waiting, at, path_));
  block.written += block.waiting.size() / stride_;
  block.waiting.clear();
  return success();
}

Status RowsById::for_each(const std::function<Status(std::span<const std::byte>)>& visit) {
  for (std::size_t index = 0; index < blocks_.size(); ++index) {
    BOOST_OUTCOME_TRYV(write(index));
    std::vector<std::byte>().swap(blocks_[index].waiting);
    BOOST_OUTCOME_TRYV(give(index, visit));
  }
  return success();
}

Status RowsById::give(std::size_t index, const std::function<Status(std::span<const std::byte>)>& visit) {
  constexpr std::uint32_t none = ~std::uint32_t{0};
  const std::uint64_t first = index * block_ids_;
  std::vector<std::byte> rows(blocks_[index].written * stride_);
  BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), rows, first * stride_, path_));
  if (read != rows.size()) return io_error(path_, "cannot read back a temporary part of the file", EIO);
  std::vector<std::uint32_t> place(std::min(block_ids_, ids_ - first), none);  // by id: the number of its row
  for (std::size_t i = 0; i < blocks_[index].written; ++i) {
    std::uint64_t id = 0;
    std::memcpy(&id, rows.data() + i * stride_, sizeof id);
    if (place[id - first] != none) return two_rows(id);
    place[id - first] = static_cast<std::uint32_t>(i);
  }
  std::vector<std::byte> some;
  constexpr std::size_t some_bytes = std::size_t{1} << 20;
  some.reserve(some_bytes + stride_);
  for (const std::uint32_t number : place) {
    if (number == none) continue;
    const auto* row = rows.data() + number * stride_;
    some.insert(some.end(), row, row + stride_);
    if (some.size() < some_bytes) continue;
    BOOST_OUTCOME_TRYV(visit(some));
    some.clear();
  }
  return some.empty() ? Status(success()) : visit(some);
}

}  // namespace tessera::exports
