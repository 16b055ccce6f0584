#include "actors/harness/harness.h"

#include <algorithm>
#include <random>
#include <utility>

#include "actors/harness/life.h"
#include "actors/harness/memory_storage.h"
#include "actors/harness/setting.h"
#include "src/geometry/reference/periodic_reference.h"
#include "src/geometry/reference/reference.h"

namespace tessera {
namespace {

StorageFault draw_fault(std::mt19937_64& rng) {
  StorageFault fault;
  fault.call = static_cast<StorageFault::Call>(rng() % 6);
  fault.how = static_cast<StorageFault::How>(rng() % 3);
  fault.countdown = rng() % 12;
  return fault;
}

std::size_t tiles_with_points(const Setting& setting) {
  return static_cast<std::size_t>(
      std::count_if(setting.tiles.begin(), setting.tiles.end(), [](const auto& tile) { return !tile.empty(); }));
}

void run_seed(const HarnessOptions& options, std::uint64_t seed, HarnessReport& report) {
  std::mt19937_64 rng(seed);
  const Setting setting = make_setting(options, seed, rng);
  MemoryStorage storage(options.dimension, setting.tiles);
  storage.late_stores = setting.late_stores;
  storage.many_nodes = setting.context.many_nodes;
  storage.memory_faults = options.memory_faults;
  if (options.faults.storage) storage.fault = draw_fault(rng);
  const auto later = options.later_stages ? options.later_stages() : nullptr;
  const auto fail = [&](const std::string& failure) {
    report.failed_seed = seed;
    report.failure = failure;
  };
  const auto allocations_failed = [&] { return options.memory_faults ? options.memory_faults->failed() : 0; };
  // The last life is not ended early.
  const std::uint64_t ends = options.restarts ? 1 + rng() % 2 : 0;
  std::uint64_t lives_max = ends + 3, damages = 0, mended = 0;
  for (std::uint64_t life = 0;; ++life) {
    const End end = life >= ends ? End::never : rng() % 2 == 0 ? End::cancel : End::kill;
    const std::uint64_t failed_before = allocations_failed();
    const Outcome outcome = Life(options, setting, storage, later.get(), rng)
                                .live(end, rng() % (later ? 1500 + 1500 * later->count() : 1500));
    const bool out_of_memory = allocations_failed() > failed_before;
    if (out_of_memory) ++lives_max;
    report.steps += outcome.steps;
    report.updates += outcome.updates;
    report.epochs += outcome.epochs;
    if (options.stop.stop_requested()) return;
    if (!outcome.failure.empty()) return fail(outcome.failure);
    if (outcome.ended) {
      report.waves += outcome.ended->waves;
      report.sleeps += outcome.ended->sum.sleeps;
      if (!outcome.ended->failure) {
        report.nodes_lost += outcome.ended->nodes_lost;
        break;
      }
      if (outcome.ended->again && ++mended <= damages) {
        ++lives_max;
        continue;
      }
      const auto code = static_cast<Errc>(outcome.ended->failure.code);
      const bool cancelled = end == End::cancel && code == Errc::interrupted;
      const bool faulty = (options.faults.storage && !storage.fault) || (out_of_memory && code == Errc::memory);
      if (!cancelled && !faulty) return fail(outcome.ended->failure.text);
      if (!cancelled) ++report.failures;
    }
    if (life >= lives_max) return fail("a run that was resumed fails again: " + outcome.ended->failure.text);
    ++report.restarts;
    if (storage.settled > 0) ++report.settled_restarts;
    if (later && storage.meshes().size() == tiles_with_points(setting)) ++report.later_restarts;
    if (options.restarts && rng() % 4 == 0) {
      storage.damage(rng);
      ++damages;
    }
  }
  report.spills += storage.spills();
  report.mended += mended;
  if (storage.holds_mail()) return fail("mail is left on scratch");
  std::vector<TileMesh> meshes;
  for (const auto& [tile, mesh] : storage.meshes()) meshes.push_back(mesh);
  const std::string wrong = options.periodic
                                ? difference(periodic_delaunay({options.dimension, setting.period, setting.cloud}),
                                             periodic_main_cells(meshes))
                                : difference(global_delaunay(setting.cloud, options.dimension), main_cells(meshes));
  if (!wrong.empty()) return fail(wrong);
  if (const std::string differs = later ? later->wrong(storage.meshes()) : ""; !differs.empty()) return fail(differs);
  ++report.seeds;
}

}  // namespace

HarnessReport run_harness(const HarnessOptions& options) {
  HarnessReport report;
  for (std::uint64_t seed = options.first_seed; seed <= options.last_seed && !report.failed_seed; ++seed) {
    if (options.stop.stop_requested()) break;
    run_seed(options, seed, report);
  }
  return report;
}

}  // namespace tessera
