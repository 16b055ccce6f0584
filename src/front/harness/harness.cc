// tessera-harness: runs the real actors under a deterministic scheduler, for one random seed after the other, and
// compares the results with CGAL's. A program for those who change Tessera; it is not installed.
#include "actors/harness/harness.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/front/apps/interrupt.h"
#include "src/geometry/reference/clouds.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"
#include "src/tiling/partition.h"

namespace tessera::apps {
namespace {

constexpr std::int64_t points_max = 1'000'000;  // the comparison needs every cell in memory
constexpr std::int64_t harness_tiles_max = 4096;
constexpr std::int64_t nodes_max = 64;

// Parses "17" or "1..1000". Both ends are included.
Result<std::pair<std::uint64_t, std::uint64_t>> parse_seeds(const std::string& text) {
  constexpr auto highest = std::numeric_limits<std::int64_t>::max() - 1;
  const auto dots = text.find("..");
  auto first = parse_integer(text.substr(0, dots), 0, highest);
  auto last = dots == std::string::npos ? first : parse_integer(text.substr(dots + 2), 0, highest);
  if (!first || !last || first.value() > last.value()) {
    return error(Errc::usage, "'" + text + "' is not a range of seeds like 1..1000");
  }
  return std::pair(static_cast<std::uint64_t>(first.value()), static_cast<std::uint64_t>(last.value()));
}

constexpr const char* fault_names = "storage, kill, pause, join, coordinator, leave, last, all";

// Parses a list like "kill,join".
Result<HarnessFaults> parse_faults(const std::string& text) {
  HarnessFaults faults;
  std::istringstream in(text);
  for (std::string name; std::getline(in, name, ',');) {
    bool* const fault = name == "storage"       ? &faults.storage
                        : name == "kill"        ? &faults.kill
                        : name == "pause"       ? &faults.pause
                        : name == "join"        ? &faults.join
                        : name == "coordinator" ? &faults.coordinator
                        : name == "leave"       ? &faults.leave
                        : name == "last"        ? &faults.last
                        : name == "all"         ? &faults.all
                                                : nullptr;
    if (!fault) return error(Errc::usage, "'" + name + "' is not a fault; the faults are " + std::string(fault_names));
    *fault = true;
  }
  return faults;
}

std::string kinds() {
  std::string names;
  for (const auto& kind : cloud_kinds()) names += (names.empty() ? "" : ", ") + kind;
  return names;
}

// The options as they are given.
struct Given {
  std::string kind = "uniform", partition, seeds, faults;
  std::optional<std::int64_t> dimension, points, tiles, nodes, mail, seed;
  bool periodic = false, restarts = false, trace = false, json = false, quiet = false;
};

Status check_range(const char* name, const std::optional<std::int64_t>& value, std::int64_t lowest,
                   std::int64_t highest) {
  if (!value || (lowest <= *value && *value <= highest)) return success();
  return error(Errc::usage, std::string(name) + ": " + std::to_string(*value) + " is not from " +
                                std::to_string(lowest) + " to " + std::to_string(highest));
}

Result<HarnessOptions> read_options(const Given& given) {
  HarnessOptions options;
  if (given.seed && !given.seeds.empty()) return error(Errc::usage, "give --seed or --seeds, not both");
  options.kind = given.kind;
  if (std::find(cloud_kinds().begin(), cloud_kinds().end(), options.kind) == cloud_kinds().end())
    return error(Errc::usage, "--kind: '" + options.kind + "' is not a kind of cloud; the kinds are " + kinds());
  BOOST_OUTCOME_TRYV(check_range("--dim", given.dimension, 2, 3));
  options.dimension = static_cast<int>(given.dimension.value_or(options.dimension));
  BOOST_OUTCOME_TRYV(check_range("--points", given.points, options.dimension + 1, points_max));
  BOOST_OUTCOME_TRYV(check_range("--tiles", given.tiles, 1, harness_tiles_max));
  BOOST_OUTCOME_TRYV(check_range("--nodes", given.nodes, 1, nodes_max));
  BOOST_OUTCOME_TRYV(check_range("--mail", given.mail, 0, std::int64_t{1} << 40));
  BOOST_OUTCOME_TRYV(check_range("--seed", given.seed, 0, std::numeric_limits<std::int64_t>::max() - 1));
  if (given.points) options.points = static_cast<std::size_t>(*given.points);
  if (given.tiles) options.tiles = static_cast<std::uint32_t>(*given.tiles);
  if (given.nodes) options.nodes = static_cast<std::uint32_t>(*given.nodes);
  if (given.mail) options.mail_bytes_max = static_cast<std::uint64_t>(*given.mail);
  if (!given.faults.empty()) {
    BOOST_OUTCOME_TRY(faults, parse_faults(given.faults));
    options.faults = faults;
  }
  options.periodic = given.periodic;
  options.restarts = given.restarts;
  if (!given.partition.empty()) {
    BOOST_OUTCOME_TRY(partition, parse_partition_kind(given.partition));
    options.partition = partition;
  }
  if (!given.seeds.empty()) {
    BOOST_OUTCOME_TRY(seeds, parse_seeds(given.seeds));
    std::tie(options.first_seed, options.last_seed) = seeds;
  }
  if (given.seed) options.first_seed = options.last_seed = static_cast<std::uint64_t>(*given.seed);
  if (given.trace) options.trace = [](const std::string& step) { std::printf("%s\n", step.c_str()); };
  return options;
}

Result<HarnessReport> run_seeds(const HarnessOptions& options) {
  const Interrupt interrupt;
  HarnessReport sum;
  for (auto seed = options.first_seed; seed <= options.last_seed && !sum.failed_seed; ++seed) {
    auto one = options;
    one.first_seed = one.last_seed = seed;
    one.stop = interrupt.token();
    auto report = run_harness(one);
    if (one.stop.stop_requested() && report.seeds == 0 && !report.failed_seed) {
      return error(Errc::interrupted, "interrupted at seed " + std::to_string(seed) + "; all seeds before it passed");
    }
    sum.seeds += report.seeds;
    sum.steps += report.steps;
    sum.updates += report.updates;
    sum.waves += report.waves;
    sum.sleeps += report.sleeps;
    sum.spills += report.spills;
    sum.failures += report.failures;
    sum.restarts += report.restarts;
    sum.settled_restarts += report.settled_restarts;
    sum.epochs += report.epochs;
    sum.failed_seed = report.failed_seed;
    sum.failure = std::move(report.failure);
  }
  return sum;
}

Status run_given(const Given& given) {
  BOOST_OUTCOME_TRY(options, read_options(given));
  BOOST_OUTCOME_TRY(report, run_seeds(options));
  if (report.failed_seed) {
    return error(Errc::not_delaunay, "seed " + std::to_string(*report.failed_seed) + ": " + report.failure +
                                         "; replay it with --seed " + std::to_string(*report.failed_seed) + " --trace");
  }
  if (given.json) {
    const nlohmann::ordered_json object{{"event", "harness"},          {"seeds", report.seeds},
                                        {"steps", report.steps},       {"messages", report.updates},
                                        {"waves", report.waves},       {"sleeps", report.sleeps},
                                        {"spills", report.spills},     {"failures", report.failures},
                                        {"restarts", report.restarts}, {"epochs", report.epochs}};
    std::printf("%s\n", json_text(object).c_str());
  } else if (!given.quiet) {
    std::printf(
        "%s seeds passed: %s steps, %s messages with points, %s collections of counters, %s sleeps, "
        "%s spills of mail, %s runs ended by faults, %s resumed (%s settled), %s times nodes were lost or joined, or a "
        "coordinator was replaced\n",
        grouped(report.seeds).c_str(), grouped(report.steps).c_str(), grouped(report.updates).c_str(),
        grouped(report.waves).c_str(), grouped(report.sleeps).c_str(), grouped(report.spills).c_str(),
        grouped(report.failures).c_str(), grouped(report.restarts).c_str(), grouped(report.settled_restarts).c_str(),
        grouped(report.epochs).c_str());
  }
  return success();
}

int harness_main(int argc, char** argv) {
  CLI::App app("Runs the actors in seeded random schedules and compares the results with CGAL's.", "tessera-harness");
  app.footer(
      "Examples:\n"
      "  tessera-harness --kind lattice -n 40 --tiles 7 --seeds 1..1000\n"
      "  tessera-harness --kind lattice -n 40 --tiles 7 --seed 17 --trace      (replays one)");
  Given given;
  app.add_option("--kind", given.kind, kinds() + "; default: uniform");
  app.add_option("-n,--points", given.points, "about how many points; default: 40");
  app.add_option("--dim", given.dimension, "the dimension, 2 or 3; default: 3");
  app.add_option("--tiles", given.tiles, "the number of tiles; default: 7");
  app.add_option("--partition", given.partition, "kdtree (default), grid, octree or random");
  app.add_flag("--periodic", given.periodic, "draw periods for each seed, along some axes or all");
  app.add_option("--seeds", given.seeds, "run these seeds, A..B, up to the first that fails; default: 1..1");
  app.add_option("--seed", given.seed, "run this seed alone");
  app.add_option("--nodes", given.nodes, "the number of nodes that the tiles are spread over; default: random, 1 to 3");
  app.add_option("--mail", given.mail, "how many bytes of waiting messages a tile keeps in memory; default: random");
  app.add_option("--faults", given.faults,
                 "a list of what goes wrong in each run: storage (it fails once, and the run is resumed), kill (nodes "
                 "are killed), pause (nodes are silent for longer than their lease), join (nodes join later), "
                 "coordinator (it is killed), leave (nodes leave in order), last (all nodes are lost one after the "
                 "other, and another one joins), all (all nodes are lost at once, and others join)");
  app.add_flag("--restarts", given.restarts, "kill or cancel the processes, and resume the run");
  app.add_flag("--trace", given.trace, "print every step");
  app.add_flag("--json", given.json, "print one JSON object at the end");
  app.add_flag("--quiet", given.quiet, "print nothing unless a run fails");
  CLI11_PARSE(app, argc, argv);
  const Status status = run_given(given);
  if (status) return 0;
  std::fprintf(stderr, "tessera-harness: %s\n", in_plain_words(status.error().where).c_str());
  return static_cast<int>(status.error().code);
}

}  // namespace
}  // namespace tessera::apps

int main(int argc, char** argv) {
  try {
    return tessera::apps::harness_main(argc, argv);
  } catch (const std::exception& thrown) {
    std::fprintf(stderr, "tessera-harness: unexpected: %s\n", thrown.what());
    return static_cast<int>(tessera::Errc::internal);
  }
}
