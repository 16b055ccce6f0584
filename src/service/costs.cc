#include "src/service/costs.h"

#include <fcntl.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <array>

#include "src/files/descriptor.h"
#include "src/io/format.h"
#include "src/job/estimate.h"
#include "src/job/open_cloud.h"
#include "src/report/human.h"
#include "src/service/problem.h"

namespace tessera {

std::uint64_t free_bytes(const std::filesystem::path& folder) {
  struct statvfs status {};
  if (::statvfs(folder.c_str(), &status) != 0) return 0;
  return static_cast<std::uint64_t>(status.f_bavail) * status.f_frsize;
}

std::uint64_t unpacked_max(const ServiceLimits& limits, const std::filesystem::path& data) {
  const auto free = std::max<std::uint64_t>(free_bytes(data), 1);
  return limits.disk_bytes == 0 ? free : std::min(free, limits.disk_bytes);
}

std::optional<proto::Problem> check_costs(const Cloud& cloud, const JobOptions& options, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate) {
  const auto points = expected_points(cloud.files());
  estimate.set_points(points);
  if (limits.points > 0 && points > limits.points) {
    return problem(422,
                   "inputs: hold " + grouped(points) + " points; a job may have " + grouped(limits.points) + " here",
                   Errc::memory);
  }
  const auto limit = tile_limit(options, cloud);
  if (!limit) return problem_of(limit.error());
  auto cost =
      tessera::estimate(options.cloud.dimension, options.kernel, points, limit.value(), options.neighbors,
                        row_bytes(cloud.schema()), {.memory_bytes = options.memory_bytes, .threads = options.threads});
  for (const auto& file : cloud.files())
    if (!file.packing.empty()) cost.temporary_bytes += file.content_bytes;
  estimate.set_cells(cost.cells);
  estimate.set_tiles(options.tiles > 0 ? options.tiles : points / std::max<std::uint64_t>(1, limit.value()) + 1);
  estimate.set_memory_bytes(cost.memory_bytes);
  estimate.set_result_bytes(cost.result_bytes);
  estimate.set_temporary_bytes(cost.temporary_bytes);
  estimate.set_seconds(cost.seconds);
  const auto disk = cost.result_bytes + cost.temporary_bytes;
  const auto needs = [&] {
    return "inputs: " + grouped(points) + " points need " + human_bytes(cost.result_bytes) +
           " of disk for the result and " + human_bytes(cost.temporary_bytes) + " while it is made; ";
  };
  if (limits.disk_bytes > 0 && disk > limits.disk_bytes)
    return problem(422, needs() + "a job may have " + human_bytes(limits.disk_bytes) + " here", Errc::memory);
  if (const auto free = free_bytes(data); disk > free)
    return problem(507, needs() + "there are " + human_bytes(free), Errc::io);
  return std::nullopt;
}

Result<bool> any_packed(const std::vector<std::string>& files) {
  for (const auto& file : files) {
    BOOST_OUTCOME_TRY(handle, open_handle(file, O_RDONLY | O_NONBLOCK));
    std::array<std::byte, format_bytes> begin{};
    BOOST_OUTCOME_TRY(count, read_up_to(handle.get(), begin, 0, file));
    const auto format = format_of(std::span(begin).first(count), file);
    if (format == FileFormat::gzip || format == FileFormat::zstd) return true;
  }
  return false;
}

}  // namespace tessera
