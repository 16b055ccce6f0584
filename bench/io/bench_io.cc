// bench_io [points] [seed] [folder] [file...]: how fast one thread reads each format, from files it generates (then
// removes) and from those given, as LAZ, which it cannot write, compressed files and folders; these also with all
// processors, and with the time that opening takes, in which compressed files are unpacked.
// Best of 3 passes, file in the page cache: it measures the decoding, not the disk. Default: 5000000 points, seed 7.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "src/base/option.h"
#include "src/input/cloud/cloud.h"
#include "src/input/generate/generate.h"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// Points and bytes a second of reading `path` as a cloud.
Status measure(const std::string& label, const std::filesystem::path& path, const std::vector<std::string>& attributes,
               std::uint32_t threads = 1) {
  const auto opening = Clock::now();
  BOOST_OUTCOME_TRY(cloud, Cloud::open({path.string()}, {.attributes = attributes, .threads = threads}));
  const double opened_s = seconds_since(opening);
  double best = 1e300, check = 0;
  std::uint64_t points = 0;
  constexpr int passes = 3;
  for (int pass = 0; pass < passes; ++pass) {
    const auto begin = Clock::now();
    BOOST_OUTCOME_TRY(counts, cloud.for_each_batch([&](CloudBatch& batch) -> Status {
      for (const auto& p : batch.points) check += p.at.x;
      return success();
    }));
    best = std::min(best, seconds_since(begin));
    points = counts.read;
  }
  double bytes = 0;
  for (const auto& file : cloud.files()) bytes += static_cast<double>(file.content_bytes);
  std::printf("%-40s %8.1f MB/s %8.2f M points/s   (opened in %.3f s, checksum %.17g)\n", label.c_str(),
              bytes / best / 1e6, static_cast<double>(points) / best / 1e6, opened_s, check);
  return success();
}

// Gives a LAS file a scale of 17 digits and an offset of 11 decimals, as some scanners' software does: the integers
// then go through 128 bits.
void make_odd(const std::filesystem::path& path) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  const double header[6] = {0.0010000000000000002, 1.029520741639058e-06, 1.0000000000000006e-05,
                            393775.82306091185,    6328493.418841014,     3107.8627};
  file.seekp(131);
  file.write(reinterpret_cast<const char*>(header), sizeof header);
}

Status measure_given(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  const std::uint32_t processors = std::max(1u, std::thread::hardware_concurrency());
  BOOST_OUTCOME_TRYV(measure(name, path, {}));
  BOOST_OUTCOME_TRYV(measure(name + ", all attributes", path, {"all"}));
  return measure(name + ", " + std::to_string(processors) + " threads", path, {}, processors);
}

Status run(std::uint64_t points, std::uint64_t seed, const std::filesystem::path& folder) {
  std::printf("%llu points, seed %llu, 1 thread\n", static_cast<unsigned long long>(points),
              static_cast<unsigned long long>(seed));
  for (const char* name : {"terrain.las", "uniform.las", "terrain.npy", "terrain.ply", "terrain.xyz", "terrain.csv"}) {
    const std::filesystem::path path = folder / name;
    const auto shape = shape_named(path.stem().string());
    const auto begin = Clock::now();
    BOOST_OUTCOME_TRYV(generate({.shape = *shape, .points = points, .seed = seed}, path));
    std::printf("%-28s %8.2f s\n", ("generate " + path.filename().string()).c_str(), seconds_since(begin));
    BOOST_OUTCOME_TRYV(measure(path.filename().string(), path, {}));
    if (path.extension() == ".las") {
      BOOST_OUTCOME_TRYV(measure(path.filename().string() + ", all attributes", path, {"all"}));
      make_odd(path);
      BOOST_OUTCOME_TRYV(measure(path.filename().string() + ", odd scales", path, {}));
    }
    std::filesystem::remove(path);
  }
  return success();
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  std::uint64_t points = 5'000'000, seed = 7;
  std::string folder = ".";
  std::vector<std::string> files;
  CLI::App app("How fast files are read");
  app.add_option("points", points, "to generate; 0 for none");
  app.add_option("seed", seed, "of the generated points");
  app.add_option("folder", folder, "for the generated files");
  app.add_option("files", files, "to read besides, and folders");
  CLI11_PARSE(app, argc, argv);
  tessera::Status status = tessera::success();
  if (points > 0) status = tessera::run(points, seed, folder);
  for (std::size_t i = 0; i < files.size() && status.has_value(); ++i) status = tessera::measure_given(files[i]);
  if (status.has_error()) std::fprintf(stderr, "bench_io: %s\n", tessera::in_plain_words(status.error().where).c_str());
  return status.has_error() ? 1 : 0;
}
