#include "tessera/triangulation.h"

#include <exception>
#include <utility>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/tile_impl.h"
#include "src/front/api/triangulation_impl.h"
#include "src/job/describe.h"
#include "src/job/machine.h"
#include "src/job/version.h"
#include "src/result/export/export.h"
#include "src/result/verify/verify.h"

namespace tessera {

Triangulation Triangulation::open(const std::filesystem::path& folder) {
  return guarded([&] {
    return Triangulation(
        std::make_shared<const Impl>(Impl{value_or_throw(TileSource::open(folder, Periods::known)), nullptr,
                                          named_version(folder) ? folder : std::filesystem::path()}));
  });
}

Triangulation Triangulation::open(const std::filesystem::path& folder, std::uint32_t version) {
  return open(version_file(folder, version));
}

const std::filesystem::path& Triangulation::folder() const {
  return impl_->version.empty() ? impl_->source.folder() : impl_->version;
}
int Triangulation::dimension() const { return impl_->source.manifest().dimension; }
std::uint64_t Triangulation::vertices() const { return impl_->source.manifest().vertices; }
std::uint64_t Triangulation::cells() const { return impl_->source.manifest().cells; }
std::uint64_t Triangulation::points_read() const { return impl_->source.manifest().points_read; }
std::uint64_t Triangulation::duplicates() const { return impl_->source.manifest().duplicates; }
std::optional<std::uint64_t> Triangulation::duplicates_at_other_heights() const {
  return impl_->source.manifest().other_heights;
}
std::string Triangulation::digest() const {
  return impl_->source.manifest().digest ? digest_text(*impl_->source.manifest().digest) : std::string();
}
std::array<double, 3> Triangulation::period() const { return impl_->source.period().length; }
std::size_t Triangulation::tiles() const { return impl_->source.manifest().tiles.size(); }
std::string Triangulation::crs() const { return impl_->source.manifest().crs; }

Tile Triangulation::tile(std::size_t index) const {
  return guarded([&] {
    if (index >= tiles()) {
      throw Failure(Cause::usage, "there is no tile " + std::to_string(index) + "; the result has " +
                                      std::to_string(tiles()) + ", counted from 0");
    }
    auto stored = value_or_throw(impl_->source.read(index, {.rows = true, .cell_columns = true}));
    return TileMaker::make(impl_->source.entry(index).tile.value, std::move(stored));
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
  const auto exported = guarded([&] { return export_result(folder(), target, options, stop.get_token()); });
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
    auto report = value_or_throw(tessera::verify(folder(), options, asked.stop));
    return Proof(std::make_shared<const Proof::Impl>(Proof::Impl{std::move(report)}));
  });
}

std::string file_checksum(const std::filesystem::path& file, bool in_pieces) {
  return guarded([&] {
    const auto sum = checksum_file(file, in_pieces ? ChecksumOf::pieces : ChecksumOf::bytes);
    if (!sum) throw_failure(sum.error());
    return checksum_text(sum.value());
  });
}

std::vector<ColumnInfo> Triangulation::columns() const {
  std::vector<ColumnInfo> list;
  for (const ResultColumn& column : impl_->source.manifest().columns)
    list.push_back({column.name, column.of_cells, numpy_name(column.type), column.unit, column.version});
  return list;
}

MeasureReport Triangulation::measure(const MeasureRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    MeasureOptions options = asked.options;
    if (options.memory_bytes == 0) options.memory_bytes = default_memory();
    if (options.threads == 0) options.threads = usable_processors();
    options.software_version = tessera::version();
    const std::filesystem::path folder = this->folder();
    const auto measured = value_or_throw(tessera::measure(folder, options, asked.stop));
    impl_ =
        std::make_shared<const Impl>(Impl{value_or_throw(TileSource::open(folder, Periods::known)), impl_->temporary});
    return MeasureReport{measured.total.value_or(0), measured.unit, measured.made, measured.note};
  });
}

std::string Triangulation::describe() const {
  return guarded([&] { return value_or_throw(describe_result(folder().string(), true)); });
}

}  // namespace tessera
