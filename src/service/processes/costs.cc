#include "src/service/processes/costs.h"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <span>

#include "src/base/files/descriptor.h"
#include "src/base/ledger.h"
#include "src/input/bytes/objects.h"
#include "src/input/format.h"
#include "src/job/estimate.h"
#include "src/job/open_cloud.h"
#include "src/job/report/human.h"
#include "src/result/density/voxel_grid.h"
#include "src/result/store/period.h"
#include "src/result/terrain/grid.h"
#include "src/result/tileset/tileset.h"
#include "src/service/problem.h"
#include "src/service/processes/kinds.h"

namespace tessera::service {
namespace {

// The vertices and pixels that a thread reads or writes in a second (docs/terrain.md).
constexpr double terrain_rate = 2e6;
// Of a number of a voxel, in the scratch file of a grid (src/result/density/density.h).
constexpr std::uint64_t density_sum_bytes = 48;
// For an estimate, for which a caller waits: some tenths of a second.
constexpr std::uint64_t cells_looked_at_max = 1'000'000;

void add_surface(const Manifest& manifest, std::uint64_t memory_bytes, unsigned threads, proto::Estimate& estimate) {
  estimate.set_points(manifest.vertices);
  estimate.set_cells(manifest.cells);
  estimate.set_tiles(manifest.tiles.size());
  estimate.set_memory_bytes(memory_bytes);
  estimate.set_seconds(static_cast<double>(manifest.vertices) / (terrain_rate * std::max(1u, threads)));
}

// Whether the first bytes of an object are those of a compressed file.
Result<bool> is_packed_object(const std::string& name) {
  BOOST_OUTCOME_TRY(source, open_object(name, Ledger::token_of_thread()));
  std::array<std::byte, format_bytes> begin{};
  const auto there =
      std::span(begin).first(static_cast<std::size_t>(std::min<std::uint64_t>(begin.size(), source->size())));
  BOOST_OUTCOME_TRYV(source->read(0, there));
  const auto format = format_of(there, source->content_name());
  return format == FileFormat::gzip || format == FileFormat::zstd;
}

}  // namespace

std::uint64_t unpacked_max(const ServiceLimits& limits, const std::filesystem::path& data) {
  const auto free = std::max<std::uint64_t>(free_bytes(data), 1);
  return limits.disk_bytes == 0 ? free : std::min(free, limits.disk_bytes);
}

std::optional<proto::Problem> check_costs(const Cloud& cloud, const JobOptions& options, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate,
                                          std::span<const budget::NodeShare> nodes) {
  const auto points = expected_points(cloud.files());
  estimate.set_points(points);
  if (limits.points > 0 && points > limits.points) {
    return problem(422,
                   "inputs: hold " + grouped(points) + " points; a job may have at most " + grouped(limits.points) +
                       " here (limits.points)",
                   Errc::memory);
  }
  const auto limit = tile_limit(options, cloud, nodes);
  if (!limit) return problem_of(limit.error());
  auto cost = tessera::estimate(options.cloud.dimension, options.kernel, kind_of_tiles(options.store, points), points,
                                limit.value(), options.neighbors, row_bytes(cloud.schema()),
                                {.memory_bytes = options.memory_bytes, .threads = options.threads});
  for (const auto& file : cloud.files())
    if (!file.packing.empty()) cost.temporary_bytes += file.content_bytes;
  estimate.set_cells(cost.cells);
  estimate.set_tiles(options.tiles > 0 ? options.tiles : points / std::max<std::uint64_t>(1, limit.value()) + 1);
  estimate.set_memory_bytes(cost.memory_bytes);
  estimate.set_result_bytes(cost.result_bytes);
  estimate.set_temporary_bytes(cost.temporary_bytes);
  estimate.set_seconds(cost.seconds);
  return check_disk("inputs: " + grouped(points) + " points need " + human_bytes(cost.result_bytes) +
                        " of disk for the result and " + human_bytes(cost.temporary_bytes) + " while it is made; ",
                    cost.result_bytes + cost.temporary_bytes, limits, data);
}

std::optional<proto::Problem> check_costs(const Manifest& manifest, const DemOptions& options,
                                          const ServiceLimits& limits, const std::filesystem::path& data,
                                          proto::Estimate& estimate) {
  add_surface(manifest, options.memory_bytes, options.threads, estimate);
  const auto grid = terrain::grid_over(options.res, options.box.value_or(manifest.bounds), manifest.bounds);
  if (!grid) return problem_of(grid.error());
  const auto pixels = static_cast<std::uint64_t>(grid.value().width) * static_cast<std::uint64_t>(grid.value().height);
  const std::uint64_t bytes = pixels * (options.doubles ? 8 : options.light ? 1 : 4);
  estimate.set_result_bytes(bytes);
  estimate.set_temporary_bytes(pixels * (options.doubles ? 8 : 4) + (options.light ? bytes : 0));
  estimate.set_seconds(estimate.seconds() +
                       static_cast<double>(pixels) / (terrain_rate * std::max(1u, options.threads)));
  const auto disk = estimate.result_bytes() + estimate.temporary_bytes();
  return check_disk("res: a raster of " + grouped(pixels) + " pixels needs up to " + human_bytes(disk) +
                        " of disk while it is made; ",
                    disk, limits, data);
}

std::optional<proto::Problem> check_costs(const Manifest& manifest, const density::GridOptions& options,
                                          const ServiceLimits& limits, const std::filesystem::path& data,
                                          proto::Estimate& estimate) {
  add_surface(manifest, options.memory_bytes, options.threads, estimate);
  const auto grid =
      density::voxels_over("the result", manifest.dimension, period_of(manifest), options.shape, manifest.bounds);
  if (!grid) return problem_of(grid.error());
  const bool density = options.kind == density::GridKind::density;
  const std::uint64_t components = density::components_of(options.kind, manifest.dimension);
  const auto voxels = static_cast<std::uint64_t>(grid.value().voxels());
  estimate.set_result_bytes(voxels * components * sizeof(double));
  estimate.set_temporary_bytes(voxels * (components + (density ? 0 : 1)) * density_sum_bytes);
  estimate.set_seconds(estimate.seconds() +
                       static_cast<double>(voxels) / (terrain_rate * std::max(1u, options.threads)));
  const auto disk = estimate.result_bytes() + estimate.temporary_bytes();
  return check_disk((options.shape.voxels.empty() ? "res" : "grid") + std::string(": a grid of ") + grouped(voxels) +
                        " pixels or voxels needs up to " + human_bytes(disk) + " of disk while it is made; ",
                    disk, limits, data);
}

std::optional<proto::Problem> check_costs(const Manifest& manifest, const ContourOptions& options,
                                          const std::filesystem::path& out, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate) {
  add_surface(manifest, options.memory_bytes, options.threads, estimate);
  const auto cost = estimate_contours(out, options, cells_looked_at_max, Ledger::token_of_thread());
  if (!cost) return problem_of(cost.error());
  estimate.set_result_bytes(cost.value().file_bytes);
  estimate.set_temporary_bytes(cost.value().scratch_bytes);
  const auto disk = cost.value().file_bytes + cost.value().scratch_bytes;
  estimate.set_seconds(estimate.seconds() + static_cast<double>(cost.value().points) / terrain_rate);
  return check_disk("interval: lines of about " + grouped(cost.value().points) + " points need about " +
                        human_bytes(disk) + " of disk while they are made; ",
                    disk, limits, data);
}

std::optional<proto::Problem> check_costs(const Manifest& manifest, const ExportOptions& options,
                                          const std::string& output, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate) {
  add_surface(manifest, 0, 1, estimate);
  const auto bytes = options.format == tileset_format ? Result<std::uint64_t>(tileset_bytes(manifest))
                                                      : estimate_export(manifest, output, options);
  if (!bytes) return problem_of(bytes.error());
  estimate.set_result_bytes(bytes.value());
  if (options.max_edge || options.max_radius) return std::nullopt;  // which may leave out most cells
  return check_disk("output: the export needs about " + human_bytes(bytes.value()) + " of disk; ", bytes.value(),
                    limits, data);
}

std::optional<proto::Problem> check_disk(const std::string& needs, std::uint64_t bytes, const ServiceLimits& limits,
                                         const std::filesystem::path& data) {
  if (limits.disk_bytes > 0 && bytes > limits.disk_bytes)
    return problem(422, needs + "a job may take at most " + human_bytes(limits.disk_bytes) + " here (limits.disk)",
                   Errc::memory);
  if (const auto free = free_bytes(data); bytes > free - std::min(free, limits.reserve_bytes))
    return problem(507,
                   needs + human_bytes(free) + " are free, of which " + human_bytes(limits.reserve_bytes) +
                       " must stay free (limits.reserve)",
                   Errc::io);
  return std::nullopt;
}

Ledger::Bounds bounds_of_job(const ServiceLimits& limits, const std::filesystem::path& data) {
  Ledger::Bounds bounds{.reserve_bytes = limits.reserve_bytes, .free_bytes = [data] { return free_bytes(data); }};
  if (limits.disk_bytes > 0) bounds.disk = {limits.disk_bytes, "limits.disk, " + human_bytes(limits.disk_bytes) + ","};
  return bounds;
}

Result<bool> any_packed(const std::vector<std::string>& files) {
  for (const auto& file : files) {
    if (names_object(file)) {
      BOOST_OUTCOME_TRY(packed, is_packed_object(file));
      if (packed) return true;
      continue;
    }
    BOOST_OUTCOME_TRY(handle, open_handle(file, O_RDONLY | O_NONBLOCK));
    std::array<std::byte, format_bytes> begin{};
    BOOST_OUTCOME_TRY(count, read_up_to(handle.get(), begin, 0, file));
    const auto format = format_of(std::span(begin).first(count), file);
    if (format == FileFormat::gzip || format == FileFormat::zstd) return true;
  }
  return false;
}

}  // namespace tessera::service
