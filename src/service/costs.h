// What a triangulation would cost, and whether it may.
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
#include "src/result/export/export.h"
#include "src/result/store/tile_store.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/dem.h"
#include "src/service/service.h"
#include "src/tiling/budget/budget.h"

namespace tessera {

// What one job may take, of whatever kind it is: the bound of disk, and what has to stay free.
Ledger::Bounds bounds_of_job(const ServiceLimits& limits, const std::filesystem::path& data);

// The problem of a job that costs too much: 422 for points, memory and disk beyond its limits, 507 for a disk that is
// full now. `nodes`: what each of a cluster gives a job; none: it is not known. `estimate` is filled in as far as is
// known, also when the job is refused.
std::optional<proto::Problem> check_costs(const Cloud& cloud, const JobOptions& options, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate,
                                          std::span<const budget::NodeShare> nodes = {});

// The same of a raster, lines or an export of a result, which is in `out`.
std::optional<proto::Problem> check_costs(const Manifest& manifest, const DemOptions& options,
                                          const ServiceLimits& limits, const std::filesystem::path& data,
                                          proto::Estimate& estimate);
std::optional<proto::Problem> check_costs(const Manifest& manifest, const ContourOptions& options,
                                          const std::filesystem::path& out, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate);
std::optional<proto::Problem> check_costs(const Manifest& manifest, const ExportOptions& options,
                                          const std::string& output, const ServiceLimits& limits,
                                          const std::filesystem::path& data, proto::Estimate& estimate);
// The problem of a job that needs so much disk; `needs`: the begin of the sentence, which ends in "; ".
std::optional<proto::Problem> check_disk(const std::string& needs, std::uint64_t bytes, const ServiceLimits& limits,
                                         const std::filesystem::path& data);

// Whether one of these files has to be unpacked to be looked into: that is done when the job runs, and not before.
// Error io for one that cannot be read.
Result<bool> any_packed(const std::vector<std::string>& files);

// How much may be unpacked for one job.
std::uint64_t unpacked_max(const ServiceLimits& limits, const std::filesystem::path& data);

}  // namespace tessera
