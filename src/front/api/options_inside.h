// What the option classes of the public library hold, and what the library makes of it.
#pragma once

#include "src/job/job_options.h"
#include "src/result/export/export.h"
#include "src/result/measure/measure.h"
#include "src/result/verify/verify.h"
#include "tessera/options.h"

namespace tessera {

struct TriangulationOptions::Impl {
  JobOptions job;  // as it was set; 0 threads and 0 bytes stand for a choice of the library
  std::string partition = name_of(PartitionKind::kdtree), crs, returns = "all", keep = "first", store = "auto";
  std::vector<double> crop;
  std::filesystem::path folder;
  bool overwrite = false, resume = false;
  std::function<void(const JobProgress&)> progress;
  std::function<void(const std::string&)> warning;
  std::stop_token stop;
};

struct ExportRequest::Impl {
  ExportOptions options;
  std::stop_token stop;
};

struct VerifyRequest::Impl {
  VerifyOptions options{.memory_bytes = 0, .scratch = {}, .against_cgal = false};
  std::stop_token stop;
};

struct MeasureRequest::Impl {
  MeasureOptions options;  // 0 threads and 0 bytes stand for a choice of the library
  std::stop_token stop;
};

struct OptionsInside {
  template <class Options>
  static const auto& of(const Options& options) {
    return *options.impl_;
  }
};

// Checked, and all choices made. Throws Failure (usage; io for a file with a coordinate system).
JobOptions job_options(const TriangulationOptions& options);

}  // namespace tessera
