#include "tessera/triangulation.h"

#include <exception>
#include <utility>

#include "src/api/errors.h"
#include "src/api/options_inside.h"
#include "src/api/tile_impl.h"
#include "src/api/triangulation_impl.h"
#include "src/export/export.h"
#include "src/files/checksum.h"
#include "src/job/describe.h"
#include "src/job/machine.h"
#include "src/verify/verify.h"

namespace tessera {

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
std::optional<std::uint64_t> Triangulation::duplicates_at_other_heights() const {
  return impl_->manifest.other_heights;
}
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
    return TileMaker::make(id.value, std::move(stored));
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

std::string file_checksum(const std::filesystem::path& file, bool in_pieces) {
  return guarded([&] {
    const auto sum = checksum_file(file, in_pieces ? SumOf::pieces : SumOf::bytes);
    if (!sum) throw_failure(sum.error());
    return checksum_text(sum.value());
  });
}

std::string Triangulation::describe() const {
  return guarded([&] { return value_or_throw(describe_result(impl_->folder.string(), true)); });
}

}  // namespace tessera
