// The options of `tessera triangulate`. Reading and checking them touches no input or output.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/command.h"
#include "src/front/apps/settings.h"
#include "src/job/job_options.h"

namespace tessera::apps {

struct TriangulateOptions {
  std::vector<std::string> inputs;
  std::filesystem::path out;
  JobOptions job;
  bool resume = false, overwrite = false;
  OutputOptions output;
};

// Adds options that say how objects in stores are asked for: s3://bucket/folder.
void add_store_options(Command& command);
// Adds the options above, and those that say which points of which files are taken.
void add_source_options(Command& command);
void add_dimension(Command& command);  // --dim
// Adds the two groups above, and the options about resources and about what a result stores.
void add_point_options(Command& command);
// Adds add_point_options(), and the options about tiles and the crop box. `info` has these options, too.
void add_cloud_options(Command& command);
// Reads those of the options above that the command has.
Status read_cloud_options(Settings& settings, JobOptions& options);

void add_triangulate_options(Command& command);
Result<TriangulateOptions> read_triangulate_options(Settings& settings, std::vector<std::string> inputs);

// Returns whether the points come from standard input, which cannot be read again.
bool reads_standard_input(const TriangulateOptions& options);

}  // namespace tessera::apps
