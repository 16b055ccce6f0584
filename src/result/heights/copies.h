// Copies of all files of a block, with heights above one surface.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/result/heights/heights.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera {

// A file, and where its copy is written.
struct HeightsFile {
  std::filesystem::path from, to;
  std::uint64_t bytes = 0;  // of the file
  HeightsCopy copy = {};    // after write_copies()
};

Result<LasPacking> parse_las_packing(const std::string& text);

// Finds the LAS and LAZ files that `inputs` mean (src/input/cloud), and gives each copy the name of its file, in
// `folder`; the ending is that of the packing. Checks all files before any is written. Errors: those of Cloud::open();
// bad_input for a file of another format, or one that gzip or zstd has compressed; usage for two files of one name, and
// for a copy that exists already, unless `overwrite`.
Result<std::vector<HeightsFile>> plan_copies(const std::vector<std::string>& inputs,
                                             const std::filesystem::path& folder, const HeightsOptions& options,
                                             bool overwrite);

// Writes the copies, one after the other. `progress` gets the fraction of bytes that is done, 0 to 1; may be null. An
// error is that of copy_with_heights(); the copies before it stay.
Status write_copies(const query::StoredTriangulation& ground, std::vector<HeightsFile>& files,
                    const HeightsOptions& options, const std::function<void(double)>& progress);

// The sum over all files.
HeightsCopy all_copies(const std::vector<HeightsFile>& files);
// One line of JSON.
std::string to_json(const std::vector<HeightsFile>& files);

}  // namespace tessera
