// What `tessera triangulate` was asked to do, checked; no file has been touched yet.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/apps/command.h"
#include "src/apps/settings.h"
#include "src/base/result.h"
#include "src/job/job_options.h"

namespace tessera {

struct TriangulateOptions {
  std::vector<std::string> inputs;
  std::filesystem::path out;
  JobOptions job;
  bool resume = false, overwrite = false;
  OutputOptions output;
};

// Options that say what the cloud and the tiles are: `info` has them too.
void add_cloud_options(Command& command);
Status read_cloud_options(Settings& settings, JobOptions& options);

void add_triangulate_options(Command& command);
Result<TriangulateOptions> read_triangulate_options(Settings& settings, std::vector<std::string> inputs);

}  // namespace tessera
