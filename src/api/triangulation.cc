#include "tessera/triangulation.h"

#include <cstring>
#include <exception>
#include <utility>

#include "src/api/errors.h"
#include "src/api/options_inside.h"
#include "src/api/triangulation_impl.h"
#include "src/export/export.h"
#include "src/files/checksum.h"
#include "src/job/describe.h"
#include "src/job/machine.h"
#include "src/verify/verify.h"

namespace tessera {
namespace {

// NumPy's names.
const char* name_of(AttributeType type) {
  switch (type) {
    case AttributeType::u8:
      return "uint8";
    case AttributeType::i8:
      return "int8";
    case AttributeType::u16:
      return "uint16";
    case AttributeType::i16:
      return "int16";
    case AttributeType::u32:
      return "uint32";
    case AttributeType::i32:
      return "int32";
    case AttributeType::u64:
      return "uint64";
    case AttributeType::i64:
      return "int64";
    case AttributeType::f32:
      return "float32";
    case AttributeType::f64:
      return "float64";
  }
  return "";
}

}  // namespace

struct Tile::Impl {
  std::uint32_t id = 0;
  TileMesh mesh;
  std::vector<std::vector<std::byte>> columns;  // of attributes
  std::vector<Field> attributes;

  void set_attributes(const std::vector<Attribute>& schema, const std::vector<std::byte>& rows) {
    const std::size_t stride = row_bytes(schema), n = mesh.points.size();
    std::size_t offset = 0;
    for (const Attribute& attribute : schema) {
      const std::size_t size = size_of(attribute.type);
      auto& column = columns.emplace_back(n * size);
      for (std::size_t i = 0; i < n; ++i) std::memcpy(&column[i * size], &rows[i * stride + offset], size);
      attributes.push_back({attribute.name, name_of(attribute.type), column});
      offset += size;
    }
  }
};

std::uint32_t Tile::id() const { return impl_->id; }
int Tile::dimension() const { return impl_->mesh.dimension; }
std::span<const double> Tile::points() const {
  static_assert(sizeof(Point) == 3 * sizeof(double));
  const auto& points = impl_->mesh.points;
  return {reinterpret_cast<const double*>(points.data()), 3 * points.size()};
}
std::span<const std::uint64_t> Tile::ids() const { return numbers_of(impl_->mesh.ids); }
std::span<const std::uint8_t> Tile::foreign() const { return impl_->mesh.point_ghost; }
std::span<const std::int32_t> Tile::cells() const { return impl_->mesh.cells; }
std::span<const std::uint8_t> Tile::ghost() const { return impl_->mesh.cell_ghost; }
std::span<const std::int32_t> Tile::neighbors() const { return impl_->mesh.neighbors; }
const std::vector<Tile::Field>& Tile::attributes() const { return impl_->attributes; }

Triangulation Triangulation::open(const std::filesystem::path& folder) {
  return guarded([&] {
    auto manifest = value_or_throw(read_manifest(folder));
    return Triangulation(std::make_shared<const Impl>(Impl{folder, std::move(manifest), std::nullopt}));
  });
}

const std::filesystem::path& Triangulation::folder() const { return impl_->folder; }
int Triangulation::dimension() const { return impl_->manifest.dimension; }
std::uint64_t Triangulation::vertices() const { return impl_->manifest.vertices; }
std::uint64_t Triangulation::cells() const { return impl_->manifest.cells; }
std::uint64_t Triangulation::points_read() const { return impl_->manifest.points_read; }
std::uint64_t Triangulation::duplicates() const { return impl_->manifest.duplicates; }
std::string Triangulation::digest() const {
  return impl_->manifest.digest ? digest_text(*impl_->manifest.digest) : std::string();
}
std::size_t Triangulation::tiles() const { return impl_->manifest.tiles.size(); }
std::string Triangulation::crs() const { return impl_->manifest.crs; }

Tile Triangulation::tile(std::size_t index) const {
  return guarded([&] {
    if (index >= tiles()) {
      throw Failure(Cause::usage, "there is no tile " + std::to_string(index) + "; the result has " +
                                      std::to_string(tiles()) + ", counted from 0");
    }
    const TileId id = impl_->manifest.tiles[index].tile;
    auto stored = value_or_throw(read_tile(impl_->folder, id, true));
    auto tile = std::make_shared<Tile::Impl>();
    tile->id = id.value;
    tile->mesh = std::move(stored.mesh);
    tile->set_attributes(stored.schema, stored.rows);
    return Tile(std::move(tile));
  });
}

std::string Triangulation::export_to(const std::filesystem::path& target, const ExportRequest& request) const {
  const auto& asked = OptionsInside::of(request);
  std::stop_source stop;
  const std::stop_callback forward(asked.stop, [&] { stop.request_stop(); });
  std::exception_ptr thrown;
  ExportOptions options = asked.options;
  options.progress = [&](double part) {
    try {
      call_back(asked.options.progress, part);
    } catch (...) {
      thrown = std::current_exception();
      stop.request_stop();
    }
  };
  const auto exported = guarded([&] { return export_result(impl_->folder, target, options, stop.get_token()); });
  if (thrown) std::rethrow_exception(thrown);
  return value_or_throw(exported).note;
}

struct Proof::Impl {
  VerifyReport report;
};

std::uint64_t Proof::cells() const { return impl_->report.cells; }
std::uint64_t Proof::facets() const { return impl_->report.facets; }
std::uint64_t Proof::hull_facets() const { return impl_->report.hull_facets; }
std::uint64_t Proof::vertices() const { return impl_->report.vertices; }
const std::vector<std::string>& Proof::checks() const { return impl_->report.passed; }

Proof Triangulation::verify(const VerifyRequest& request) const {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    VerifyOptions options = asked.options;
    if (options.memory_bytes == 0) options.memory_bytes = default_memory();
    auto report = value_or_throw(tessera::verify(impl_->folder, options, asked.stop));
    return Proof(std::make_shared<const Proof::Impl>(Proof::Impl{std::move(report)}));
  });
}

std::string file_checksum(const std::filesystem::path& file) {
  return guarded([&] {
    const auto sum = checksum_file(file);
    if (!sum) throw_failure(sum.error());
    return checksum_text(sum.value());
  });
}

std::string Triangulation::describe() const {
  return guarded([&] { return value_or_throw(describe_result(impl_->folder.string(), true)); });
}

}  // namespace tessera
