// Products of point files in one step: a command that works on a result can also get point files. Then the product is
// made of each tile when the tile is finished, or of a temporary result that is kept as points.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/front/apps/command.h"
#include "src/job/job.h"

namespace tessera::apps {

// Adds the argument, which is a result folder or point files, and the options that choose points of the files. Returns
// the vector that gets the argument. `dimension`: of the triangulation; 0: adds the option --dim for it. REQUIRES: the
// command already has the options memory and threads, or needs none.
std::shared_ptr<std::vector<std::string>> add_sources(Command& command, int dimension);

struct OneStep {
  std::vector<std::string> sources;
  int dimension = 2;
  std::string beside;  // the product; a temporary result stands beside it
  std::vector<std::string> command_line;
  bool carry_all = false;  // keep all attributes of points, unless --attributes says which
};
// Calls `use` with the result folder. If the sources are point files, the result is made first and removed afterwards;
// --keep-result names a folder in which it stays. Errors: usage, those of a job, those of `use`.
Status on_result(Settings& settings, const OneStep& what, const OutputOptions& output,
                 const std::function<Status(const std::string& folder)>& use);

// Makes the result of point files in the folder `out`, kept as points. Errors: those of a job; then nothing is left.
Status make_result_of(JobOptions job, const std::vector<std::string>& sources, const std::filesystem::path& out,
                      const OutputOptions& output);

// A product that is made of each tile when the tile is finished, without a result.
struct TileProduct {
  // Returns the consumer that gets the tiles.
  std::function<Result<TileConsumer*>(const Manifest& manifest, const std::stop_token& stop)> make;
  std::function<Status()> finish;  // prints nothing
  std::uint64_t memory_bytes = 0;  // the part of the command's memory that the product takes
};
// Does the same as on_result(), but makes `product` of point files without a result, unless --keep-result asks for one.
Status on_tiles(Settings& settings, const OneStep& what, const OutputOptions& output, const TileProduct& product,
                const std::function<Status(const std::string& folder)>& use);

}  // namespace tessera::apps
