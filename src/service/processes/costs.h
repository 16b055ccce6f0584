// Estimates what a job would cost, and decides whether it is allowed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "service.pb.h"
#include "src/base/files/free_space.h"
#include "src/base/ledger.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud.h"
#include "src/job/job_options.h"
#include "src/result/density/density.h"
#include "src/result/export/export.h"
#include "src/result/store/tile_store.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/dem.h"
#include "src/service/limits.h"
#include "src/service/reply.h"
#include "src/tiling/budget/budget.h"

namespace tessera::service {

// The bounds of one job of any kind: its disk, and what must stay free.
Ledger::Bounds bounds_of_job(const ServiceLimits& limits, const std::filesystem::path& data);

// Returns a problem when the job costs too much: 422 for points, memory or disk beyond its limits, 507 for a disk that
// is full now. `nodes` has what each node of a cluster gives a job; empty when unknown. `estimate` is filled in as far
// as known, also when the job is refused.
std::optional<proto::Problem> check_costs(const Cloud& cloud, const JobOptions& options, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate,
                                          std::span<const budget::NodeShare> nodes = {});

// The same for a raster, a grid of densities, for lines, or for an export of a result; `out` is the result's folder.
std::optional<proto::Problem> check_costs(const Manifest& manifest, const DemOptions& options,
                                          const ServiceLimits& limits, const std::filesystem::path& data,
                                          proto::Estimate& estimate);
std::optional<proto::Problem> check_costs(const Manifest& manifest, const density::GridOptions& options,
                                          const ServiceLimits& limits, const std::filesystem::path& data,
                                          proto::Estimate& estimate);
std::optional<proto::Problem> check_costs(const Manifest& manifest, const ContourOptions& options,
                                          const std::filesystem::path& out, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate);
std::optional<proto::Problem> check_costs(const Manifest& manifest, const ExportOptions& options,
                                          const std::string& output, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate);
// Returns a problem when a job that needs so many bytes of disk is not allowed. `needs` is the beginning of the
// sentence, and ends in "; ".
std::optional<proto::Problem> check_disk(const std::string& needs, std::uint64_t bytes, const ServiceLimits& limits,
                                         const std::filesystem::path& data);

// True if one of these files must be unpacked before it can be looked into. Files are unpacked only when the job runs.
// Error io for a file that cannot be read.
Result<bool> any_packed(const std::vector<std::string>& files);

// The most bytes that may be unpacked for one job.
std::uint64_t unpacked_max(const ServiceLimits& limits, const std::filesystem::path& data);

}  // namespace tessera::service
