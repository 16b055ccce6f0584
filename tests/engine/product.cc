// Runs the real engine over sets x dimensions x partitions x tiles x threads and compares with CGAL, cell for cell.
//
//   engine_product SETS REAL representative [SHARD SHARDS]   every small set once in each dimension, with combinations
//                                                            in turn: each of the 48 occurs
//   engine_product SETS REAL nightly [SHARD SHARDS]          everything, smallest sets first: takes many hours
//   engine_product SETS REAL only NAME [DIMENSION]           one set with all combinations
//
// SETS: the folder of `gen.py all`. REAL: folders of real point files, with : between them, of which some need not
// exist. One line a case tells all that repeats it; the exit status is 0 when none failed.
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/base/option.h"
#include "tests/engine/checks.h"
#include "tests/engine/engine_run.h"
#include "tests/engine/sets.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::array partitions{PartitionKind::kdtree, PartitionKind::grid, PartitionKind::octree,
                                PartitionKind::random};
constexpr std::array<std::uint32_t, 4> tile_numbers{1, 2, 7, 64};
constexpr std::array<std::uint32_t, 3> thread_numbers{1, 2, 4};
constexpr std::size_t combinations = partitions.size() * tile_numbers.size() * thread_numbers.size();

constexpr std::uint64_t plenty = std::uint64_t{4} << 30;

// What the representative part leaves to the nightly one.
constexpr std::uintmax_t small_generated = 50'000 * 24, small_real = 30'000 * 24;

// A budget that makes tiles sleep: whenever they may with few points, two thirds of them with many. With a random
// partition every tile knows a good part of all points, and many points would be written over and over for hours.
std::uint64_t tight_memory(PartitionKind partition, std::uint64_t points) {
  if (points <= 5'000) return 1;
  return partition == PartitionKind::random ? plenty : points * 200;
}

// `round` alternates what is not part of the product: how tiles keep their triangulation, and their memory.
EngineOptions combination(std::size_t index, int dimension, std::size_t round, std::uint64_t points) {
  EngineOptions options;
  options.dimension = dimension;
  options.partition = partitions[index % 4];
  options.tiles = tile_numbers[index / 4 % 4];
  options.threads = thread_numbers[index / 16];
  options.keep = round % 2 == 0 ? TileRetention::whole : TileRetention::reduced;
  options.memory_bytes = round / 2 % 2 == 0 ? plenty : tight_memory(options.partition, points);
  return options;
}

// A refusal is one sentence that names the file, and leaves nothing to resume.
std::string wrong_with_refusal(const Result<EngineRun>& run, const fs::path& input, const fs::path& out) {
  if (run) return "not refused";
  const Error& error = run.error();
  if (error.code != Errc::bad_input) return "refused with another code: " + error.where;
  if (error.where.find(input.filename().string()) == std::string::npos) return "the file is not named: " + error.where;
  if (error.where.find('\n') != std::string::npos) return "more than a sentence: " + error.where;
  if (fs::exists(out / ".run" / "plan.json") || fs::exists(out / "tiles")) return "something is left behind";
  return "";
}

std::string wrong_case(const fs::path& input, const Expected& expected, const EngineOptions& options) {
  const TemporaryFolder scratch = TemporaryFolder::make().value();
  const fs::path out = scratch.path() / "out";
  const auto run = run_engine(input, out, options);
  if (expected.cells.empty() || (expected.invalid > 0 && !options.skip_invalid)) {
    return wrong_with_refusal(run, input, out);
  }
  return run ? wrong_with(run.value(), out, expected) : run.error().where;
}

class Product {
 public:
  // One line and its verdict.
  void run(const CloudSet& set, const fs::path& input, const Expected& expected, EngineOptions options) {
    for (const bool skip : {false, true}) {
      if (skip && expected.invalid == 0) break;
      options.skip_invalid = skip;
      std::printf("%s %s: ", set.name.c_str(), text_of(options).c_str());
      std::fflush(stdout);
      const auto begin = std::chrono::steady_clock::now();
      const std::string wrong = wrong_case(input, expected, options);
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      std::printf("%s (%.2f s)\n", wrong.empty() ? "ok" : ("WRONG: " + wrong).c_str(), seconds.count());
      std::fflush(stdout);
      ++cases_;
      failed_ += wrong.empty() ? 0 : 1;
    }
  }

  // Tells what goes wrong outside a case.
  void fail(const CloudSet& set, const Error& error) {
    std::printf("%s: %s\n", set.name.c_str(), in_plain_words(error.where).c_str());
    ++failed_;
  }

  int end() const {
    std::printf("%zu cases, %zu failed\n", cases_, failed_);
    return failed_ == 0 && cases_ > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
  }

 private:
  std::size_t cases_ = 0, failed_ = 0;
};

// The combinations that a set gets in one dimension.
struct Choice {
  bool all = false;
  std::size_t turn = 0;
};

void run_set(Product& product, const CloudSet& set, int dimension, Choice choice) {
  const TemporaryFolder scratch = TemporaryFolder::make().value();
  const auto input = readable_file(set, scratch.path());
  if (!input) return product.fail(set, input.error());
  auto points = read_points(set, dimension);
  if (!points) return product.fail(set, points.error());
  const Expected expected = expected_of(std::move(points.value()), dimension);
  if (!choice.all) {
    // 29 has no factor in common with 48: neighbouring sets differ in everything.
    return product.run(set, input.value(), expected,
                       combination(choice.turn * 29 % combinations, dimension, choice.turn, expected.points.size()));
  }
  for (std::size_t i = 0; i < combinations; ++i) {
    product.run(set, input.value(), expected,
                combination(i, dimension, i + i / 4 + choice.turn, expected.points.size()));
  }
}

std::vector<fs::path> folders_of(const std::string& list) {
  std::vector<fs::path> folders;
  std::istringstream in(list);
  for (std::string folder; std::getline(in, folder, ':');) folders.emplace_back(folder);
  return folders;
}

int run_product(const std::vector<std::string>& arguments) {
  const std::string part = arguments[2];
  const bool sharded = part != "only" && arguments.size() == 5;
  const std::size_t shard = sharded ? std::stoul(arguments[3]) : 0, shards = sharded ? std::stoul(arguments[4]) : 1;
  Product product;
  std::size_t turn = 0;
  for (const CloudSet& set : cloud_sets(arguments[0], folders_of(arguments[1]))) {
    for (const int dimension : set.dimensions) {
      if (part == "only") {
        if (set.name != arguments[3] || (arguments.size() > 4 && std::to_string(dimension) != arguments[4])) continue;
      } else if (part == "representative" && set.weight > (set.generated ? small_generated : small_real)) {
        continue;
      }
      if (turn++ % shards == shard) run_set(product, set, dimension, {part != "representative", turn - 1});
    }
  }
  return product.end();
}

}  // namespace
}  // namespace tessera::testing

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto is = [&](const char* part, std::size_t least, std::size_t most) {
    return arguments.size() >= least && arguments.size() <= most && arguments[2] == part;
  };
  if (!is("representative", 3, 5) && !is("nightly", 3, 5) && !is("only", 4, 5)) {
    std::fputs("usage: engine_product SETS REAL representative|nightly [SHARD SHARDS] | only NAME [DIMENSION]\n",
               stderr);
    return EXIT_FAILURE;
  }
  return tessera::testing::run_product(arguments);
}
