// How fast a result answers: points located and interpolated a second, the cells of a box, stars. One line of JSON for
// each, for bench_query.py, which sets SciPy beside it. The points are read from a file of doubles, so that both are
// asked the same.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "src/base/option.h"
#include "src/result/query/stored_triangulation.h"

namespace {

using namespace tessera;
using Clock = std::chrono::steady_clock;

template <class T>
T value(Result<T> result) {
  if (result) return std::move(result).value();
  std::cerr << "bench_query: " << in_plain_words(result.error().where) << "\n";
  std::exit(1);
}

// From its making on: the time on the wall, and that of all processors, which others who work at once do not lengthen.
class Watch {
 public:
  void print(const char* what, const char* state, std::size_t amount) const {
    const double cpu = static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC;
    std::printf("{\"what\":\"%s\",\"state\":\"%s\",\"amount\":%zu,\"seconds\":%.6f,\"cpu_seconds\":%.6f}\n", what,
                state, amount, std::chrono::duration<double>(Clock::now() - begin_).count(), cpu);
  }

 private:
  Clock::time_point begin_ = Clock::now();
  std::clock_t cpu_ = std::clock();
};

}  // namespace

int main(int argc, char** argv) {
  std::string folder, points_file, attribute;
  unsigned threads = 2;
  CLI::App app("Asks a result folder");
  app.add_option("result", folder)->required();
  app.add_option("points", points_file, "raw doubles, as many a point as the result has dimensions")->required();
  app.add_option("--threads", threads);
  app.add_option("--value", attribute, "attribute to interpolate");
  CLI11_PARSE(app, argc, argv);

  const auto open = [&] {
    return value(query::StoredTriangulation::open(folder, {.memory_bytes = std::uint64_t{16} << 30}));
  };
  const auto result = open();
  const int d = result.manifest().dimension;
  std::vector<Point> points;
  {
    std::ifstream file(points_file, std::ios::binary);
    double at[3];
    while (file.read(reinterpret_cast<char*>(at), static_cast<std::streamsize>(sizeof(double) * d)))
      points.push_back({at[0], at[1], d == 3 ? at[2] : 0});
  }
  const query::AskOptions ask{.threads = threads};
  for (const char* state : {"cold", "warm", "warm"}) {
    const Watch watch;
    value(result.locate(points, ask));
    watch.print("locate", state, points.size());
  }
  if (!attribute.empty()) {
    for (const auto& [name, method] :
         {std::pair("linear", query::Method::linear), std::pair("natural", query::Method::natural)}) {
      for (const char* state : {"cold", "warm"}) {
        const Watch watch;
        value(result.interpolate(points, {.value = attribute, .method = method}, ask));
        if (state[0] == 'w') watch.print(name, state, points.size());
      }
    }
  }
  // A box in the middle with some 10,000 cells, found by halving.
  const Bounds& all = result.manifest().bounds;
  const auto box_of = [&](double part) {
    Bounds box;
    for (int axis = 0; axis < d; ++axis) {
      const double middle = (all.lo[axis] + all.hi[axis]) / 2, half = (all.hi[axis] - all.lo[axis]) / 2 * part;
      box.lo[axis] = middle - half;
      box.hi[axis] = middle + half;
    }
    if (d == 2) box.lo.z = box.hi.z = 0;
    return box;
  };
  double low = 0, high = 1;
  for (int i = 0; i < 12; ++i) {
    const double part = (low + high) / 2;
    const auto found = value(result.cells({.box = box_of(part)}, {.bytes_max = std::uint64_t{16} << 30}, ask));
    (found.tiles.size() < 10'000 ? low : high) = part;
  }
  const query::Area area{.box = box_of(high)};
  const auto fresh = open();
  for (const char* state : {"cold", "warm", "warm"}) {
    const Watch watch;
    const auto found = value(fresh.cells(area, {.bytes_max = std::uint64_t{16} << 30}, ask));
    watch.print("cells", state, found.tiles.size());
  }
  return 0;
}
