// Products of point files in one step: what a command makes of a result, it makes of points, too, of each tile as it
// comes to its end, or by way of a result that is kept as points.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/front/apps/command.h"
#include "src/job/job.h"

namespace tessera {

// The argument: a result folder, or point files; and the options that say which points of them. `dimension`: of the
// triangulation; 0: the option --dim says it. REQUIRES: the command has the options memory and threads already, or
// needs none.
std::shared_ptr<std::vector<std::string>> add_sources(Command& command, int dimension);

struct OneStep {
  std::vector<std::string> sources;
  int dimension = 2;
  std::string beside;  // what is made: the result stands beside it meanwhile, unless it is kept elsewhere
  std::vector<std::string> command_line;
  bool carry_all = false;  // all attributes of points, unless --attributes says which
};
// Calls `use` with the result folder, which is made first when the sources are point files, and removed afterwards
// unless --keep-result says where it shall stay. Errors: usage, those of a job, those of `use`.
Status on_result(Settings& settings, const OneStep& what, const OutputOptions& output,
                 const std::function<Status(const std::string& folder)>& use);

// What is made of each tile as it comes to its end, so that no result is made.
struct TileProduct {
  std::function<Result<TileConsumer*>(const Manifest& manifest, const std::stop_token& stop)> make;
  std::function<Status()> finish;  // prints nothing
  std::uint64_t memory_bytes = 0;  // what the product takes of the memory that the command has
};
// The same, but that point files go to `product`, unless --keep-result asks for a result of them.
Status on_tiles(Settings& settings, const OneStep& what, const OutputOptions& output, const TileProduct& product,
                const std::function<Status(const std::string& folder)>& use);

}  // namespace tessera
