// How fast a result that is kept in memory changes, and how fast it is read meanwhile: points a second, how long a
// batch takes, points located a second alone and beside batches, memory. With --cgal also CGAL's insertion of the same
// batches into one triangulation of all points.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bench/live/cgal_batches.h"
#include "src/base/files/folder.h"
#include "src/base/files/live_names.h"
#include "src/base/option.h"
#include "src/delaunay/live/live_result.h"

namespace {

using namespace tessera;
using Clock = std::chrono::steady_clock;
using Rng = std::mt19937_64;

struct Arguments {
  std::string result;
  std::size_t batches = 200, batch = 1000;
  std::uint64_t seed = 1;
  unsigned threads = 1, readers = 1;
  double memory_gb = 8, pace = 100'000, removed = 0;
  bool cgal = false;
};

template <class T>
T value(Result<T> result) {
  if (result) return std::move(result).value();
  std::cerr << "bench_live: " << in_plain_words(result.error().where) << "\n";
  std::exit(1);
}

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// The time that the processor has given to this thread, which others who work at once do not lengthen.
double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Points around a vertex, where some twice as many are already, inside the bounds.
std::vector<Point> nearby(const std::vector<Point>& points, const Bounds& bounds, int dimension, std::size_t count,
                          Rng& rng) {
  const Point center = points[rng() % points.size()];
  const double share = std::pow(2.0 * static_cast<double>(count) / static_cast<double>(points.size()), 1.0 / dimension);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::vector<Point> out(count);
  for (Point& p : out) {
    p = center;
    for (int i = 0; i < dimension; ++i) {
      p[i] = std::clamp(p[i] + place(rng) * share * (bounds.hi[i] - bounds.lo[i]), bounds.lo[i], bounds.hi[i]);
    }
  }
  return out;
}

struct Rate {
  double points = 0, cpu_points = 0;  // a second, and a second of the processor's time
};

// Locates points all over the bounds until `done`.
Rate locate(const LiveResult& live, const Bounds& bounds, int dimension, const std::atomic<bool>& done,
            std::uint64_t seed) {
  Rng rng(seed);
  std::uniform_real_distribution<double> place(0, 1);
  std::uint64_t count = 0, inside = 0;
  const auto begin = Clock::now();
  const double cpu = cpu_seconds();
  while (!done) {
    const auto version = live.current();
    for (int k = 0; k < 16; ++k, ++count) {
      Point p;
      for (int i = 0; i < dimension; ++i) p[i] = bounds.lo[i] + place(rng) * (bounds.hi[i] - bounds.lo[i]);
      inside += version->locate(p) ? 1 : 0;
    }
  }
  const auto all = static_cast<double>(count);
  const Rate rate{all / seconds_since(begin), all / (cpu_seconds() - cpu)};
  if (inside == 0) std::cerr << "bench_live: no point was inside\n";
  return rate;
}

struct Written {
  double seconds = 0;             // of all, pauses included
  std::vector<double> latencies;  // of each batch, ascending
  std::uint64_t awake = 0;
};

Written write(LiveResult& live, const std::vector<std::vector<Point>>& batches, std::size_t width, double pace,
              double removed) {
  Written out;
  std::vector<std::pair<std::uint64_t, std::size_t>> added;
  const auto begin = Clock::now();
  double due = 0;
  for (const auto& points : batches) {
    if (pace > 0) {
      while (seconds_since(begin) < due) std::this_thread::sleep_for(std::chrono::microseconds(100));
      due += static_cast<double>(points.size()) / pace;
    }
    ResultChange change{.add = points, .rows = std::vector<std::byte>(points.size() * width)};
    if (removed > 0 && !added.empty()) {
      const auto [first, count] = added.front();
      added.erase(added.begin());
      const auto most = static_cast<std::size_t>(removed * static_cast<double>(count));
      for (std::size_t k = 0; k < most; ++k) change.remove.push_back(PointId{first + k});
    }
    const auto from = Clock::now();
    const auto applied = value(live.apply(change));
    out.latencies.push_back(seconds_since(from));
    out.awake += applied.awake;
    added.emplace_back(applied.first_new, points.size());
  }
  out.seconds = seconds_since(begin);
  std::sort(out.latencies.begin(), out.latencies.end());
  return out;
}

void print(const char* what, const Written& written, std::size_t points) {
  const auto at = [&](double share) {
    return 1000 *
           written.latencies[static_cast<std::size_t>(share * static_cast<double>(written.latencies.size() - 1))];
  };
  std::printf("%s: %.0f points/s, batch median %.1f ms, 99th percentile %.1f ms, longest %.1f ms, %.1f tiles awake\n",
              what, static_cast<double>(points) / written.seconds, at(0.5), at(0.99), at(1),
              static_cast<double>(written.awake) / static_cast<double>(written.latencies.size()));
}

void run(const Arguments& args) {
  auto begin = Clock::now();
  const auto live = value(LiveResult::open(
      args.result, {.threads = args.threads, .memory_bytes = static_cast<std::uint64_t>(args.memory_gb * 1e9)}));
  const auto first = live->current();
  const int dimension = first->partition().dimension();
  const Manifest manifest = live->source().manifest();
  const Bounds bounds = manifest.bounds;
  const std::size_t width = row_bytes(manifest.schema);
  std::printf("seed %llu, %llu points in %zu tiles, %uD: opened in %.1f s, %.0f MB, %.0f bytes a point\n",
              static_cast<unsigned long long>(args.seed), static_cast<unsigned long long>(first->vertices()),
              first->tiles().size(), dimension, seconds_since(begin), static_cast<double>(first->memory()) / 1e6,
              static_cast<double>(first->memory()) / static_cast<double>(first->vertices()));
  std::vector<Point> points;
  for (const auto& tile : first->tiles()) {
    if (!tile) continue;
    for (const LocalPoint& p : tile->triangulation().own()) points.push_back(p.at);
  }
  Rng rng(args.seed);
  std::vector<std::vector<Point>> batches(2 * args.batches);
  for (auto& batch : batches) batch = nearby(points, bounds, dimension, args.batch, rng);
  const auto half = batches.begin() + static_cast<std::ptrdiff_t>(args.batches);
  const std::vector<std::vector<Point>> alone(batches.begin(), half), beside(half, batches.end());
  const std::size_t all = args.batches * args.batch;

  const auto readers = [&](const auto& meanwhile) {
    std::atomic<bool> done{false};
    std::mutex mutex;
    Rate rate;
    {
      std::vector<std::jthread> threads;
      for (unsigned t = 0; t < args.readers; ++t) {
        threads.emplace_back([&, t] {
          const Rate one = locate(*live, bounds, dimension, done, args.seed + t);
          const std::lock_guard lock(mutex);
          rate.points += one.points;
          rate.cpu_points += one.cpu_points;
        });
      }
      meanwhile();
      done = true;
    }
    return rate;
  };
  print("writes alone", write(*live, alone, width, 0, args.removed), all);
  const Rate read_alone = readers([] { std::this_thread::sleep_for(std::chrono::seconds(3)); });
  std::printf("reads alone: %.0f points located/s, %.0f a second of processor time, %u threads\n", read_alone.points,
              read_alone.cpu_points, args.readers);
  Written written;
  const Rate read_beside = readers([&] { written = write(*live, beside, width, args.pace, args.removed); });
  print("writes beside reads", written, all);
  std::printf("reads beside writes: %.0f points located/s, %.2f of alone; %.2f of alone by processor time\n",
              read_beside.points, read_beside.points / read_alone.points,
              read_beside.cpu_points / read_alone.cpu_points);
  std::printf("log: %.1f MB; now %.0f MB in memory\n", static_cast<double>(live->log_bytes()) / 1e6,
              static_cast<double>(live->current()->memory()) / 1e6);
  if (args.cgal) {
    CgalBatches cgal(points, dimension);
    begin = Clock::now();
    for (const auto& batch : alone) cgal.insert(batch);
    std::printf("CGAL, insertion into one triangulation in memory: %.0f points/s\n",
                static_cast<double>(all) / seconds_since(begin));
  }
}

}  // namespace

int main(int argc, char** argv) {
  Arguments args;
  CLI::App app("How fast a result that is kept in memory changes");
  app.add_option("result", args.result, "a result folder; the log beside it is removed afterwards")->required();
  app.add_option("--batches", args.batches, "of each measurement");
  app.add_option("--batch", args.batch, "points of a batch");
  app.add_option("--seed", args.seed);
  app.add_option("--threads", args.threads, "for a batch");
  app.add_option("--readers", args.readers, "threads that read");
  app.add_option("--memory", args.memory_gb, "GB");
  app.add_option("--pace", args.pace, "points a second that are written while others read; 0: as many as can be");
  app.add_option("--removed", args.removed, "how much of an earlier batch each batch removes, 0 to 1");
  app.add_flag("--cgal", args.cgal, "compare with CGAL");
  CLI11_PARSE(app, argc, argv);
  run(args);
  return remove_whole(live_folder(args.result)) ? 0 : 1;
}
