// The inside of the option classes of the public library, and the options of the engine that are made of it.
#pragma once

#include "src/input/remote/s3.h"
#include "src/job/job_options.h"
#include "src/result/export/export.h"
#include "src/result/measure/measure.h"
#include "src/result/verify/verify.h"
#include "tessera/options.h"

namespace tessera {

struct TriangulationOptions::Impl {
  JobOptions job;  // as the program set it; 0 threads and 0 bytes let the library choose
  std::string partition = name_of(PartitionKind::kdtree), crs, returns = "all", keep = "first", store = "auto",
              periodic_snap = "yes";
  remote::S3Options s3;
  std::vector<double> crop;
  std::vector<std::string> particles;
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
  MeasureOptions options;  // 0 threads and 0 bytes let the library choose
  std::stop_token stop;
};

// Gives the library access to the inside of option classes, which name it as a friend.
struct OptionsInside {
  template <class Options>
  static const auto& of(const Options& options) {
    return *options.impl_;
  }
};

// Returns the checked options of a job, with all choices of the library made. Throws Failure: usage; io for a file with
// a coordinate system that cannot be read.
JobOptions job_options(const TriangulationOptions& options);

}  // namespace tessera
