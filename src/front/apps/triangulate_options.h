// What `tessera triangulate` was asked to do, checked; no file has been touched yet.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/front/apps/settings.h"
#include "src/job/job_options.h"

namespace tessera {

struct TriangulateOptions {
  std::vector<std::string> inputs;
  std::filesystem::path out;
  JobOptions job;
  bool resume = false, overwrite = false;
  OutputOptions output;
};

// Options that say which points of which files; the dimension; what else the cloud is; and also what the tiles are:
// `info` has them too.
void add_source_options(Command& command);
void add_dimension(Command& command);
void add_point_options(Command& command);
void add_cloud_options(Command& command);
// Of those options that the command has.
Status read_cloud_options(Settings& settings, JobOptions& options);

void add_triangulate_options(Command& command);
Result<TriangulateOptions> read_triangulate_options(Settings& settings, std::vector<std::string> inputs);

// Whether the points come from standard input, which cannot be read again.
bool reads_standard_input(const TriangulateOptions& options);

}  // namespace tessera
