// The cut of a surface, of a 3D result in one tile: ours and Boykov and Kolmogorov's, on the same graph. Exits with 1
// when the sets differ.
#include <maxflow/graph.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/result/tile_source.h"
#include "src/surface/cut/search_trees.h"
#include "src/surface/ray_caster.h"
#include "src/surface/region.h"
#include "src/surface/sensors.h"

namespace {

using namespace tessera;

template <class T>
T value(Result<T> result) {
  if (result) return std::move(result).value();
  std::cerr << "bench_cut: " << in_plain_words(result.error().where) << "\n";
  std::exit(1);
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

surface::CutRegion region_of(const std::string& folder, const surface::Energy& energy) {
  const auto source = value(TileSource::open(folder));
  if (source.tiles() != 1) {
    std::cerr << "bench_cut: " << folder << ": has several tiles; triangulate with more memory\n";
    std::exit(1);
  }
  const auto& manifest = source.manifest();
  const auto sensors = value(surface::Sensors::make({}, manifest.schema, manifest.bounds));
  auto tile = value(
      surface::SurfaceTile::make(source.entry(0).tile, source.file(0).string(), value(source.read(0, {.rows = true}))));
  tile.begin_weights();
  surface::RayCaster caster(tile, energy, static_cast<std::uint64_t>(tile.cells()));
  const auto& stored = tile.stored();
  const std::size_t width = row_bytes(stored.schema);
  for (std::int32_t v = 0; v < tile.own_vertices(); ++v) {
    const std::byte* row = stored.rows.data() + static_cast<std::size_t>(v) * width;
    if (const auto sensor = value(sensors.of(tile.point(v), tile.id(v), row)))
      (void)caster.cast(v, sensor->at, tile.scale_of(v), surface::full_vote);
  }
  return value(surface::region_of(tile, energy, {}, {}));
}

using Bk = maxflow::Graph<int, int, int>;

// Its set of what residual arcs lead to from the source.
std::vector<bool> by_bk(const cut::CutGraph& from, double& seconds, double& bytes) {
  const auto cells = static_cast<int>(from.cells());
  const double begin = now();
  Bk graph(cells, 2 * cells);
  graph.add_node(cells);
  for (std::uint32_t cell = 0; cell < from.cells(); ++cell) {
    const auto excess = static_cast<int>(from.excess[cell]);
    graph.add_tweights(static_cast<int>(cell), std::max(excess, 0), std::max(-excess, 0));
    for (cut::Arc arc = 4 * cell; arc < 4 * cell + 4; ++arc)
      if (cut::is_inner(from.back[arc]) && arc < from.back[arc])
        graph.add_edge(static_cast<int>(cell), static_cast<int>(from.back[arc] >> 2u),
                       static_cast<int>(from.capacity[arc]), static_cast<int>(from.capacity[from.back[arc]]));
  }
  std::printf("BK: graph made in %.2f s\n", now() - begin);
  const double middle = now();
  graph.maxflow();
  seconds = now() - middle;
  std::vector<bool> source(from.cells());
  // Cells that it has left free are on the source's side only if they are said to be.
  for (int cell = 0; cell < cells; ++cell)
    source[static_cast<std::size_t>(cell)] = graph.what_segment(cell, Bk::SINK) == Bk::SOURCE;
  // A node holds 48 bytes, an arc 32 (maxflow/graph.h, on 64-bit machines).
  bytes = 48.0 * graph.get_node_num() + 32.0 * graph.get_arc_num();
  return source;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The cut of a surface, and Boykov and Kolmogorov's.");
  std::string folder;
  int rounds = 1;
  surface::Energy energy;
  app.add_option("result", folder, "a 3D result in one tile")->required();
  app.add_option("--rounds", rounds, "how often each is timed");
  app.add_option("--lambda", energy.lambda, "as of a surface");
  CLI11_PARSE(app, argc, argv);

  const surface::CutRegion region = region_of(folder, energy);
  std::printf("%u cells of %s, no seed\n", region.graph.cells(), folder.c_str());
  double least_ours = 1e99, least_bk = 1e99, bytes_bk = 0, bytes_ours = 0;
  bool same = true;
  for (int round = 0; round < rounds; ++round) {
    double seconds = 0;
    const auto source = by_bk(region.graph, seconds, bytes_bk);
    least_bk = std::min(least_bk, seconds);
    cut::CutGraph graph = region.graph;
    const double begin = now();
    cut::SearchTrees trees(graph);
    const cut::CellSet ours = trees.run();
    least_ours = std::min(least_ours, now() - begin);
    bytes_ours = static_cast<double>(graph.bytes() + trees.bytes());
    for (std::uint32_t cell = 0; cell < graph.cells(); ++cell) same = same && ours.contains(cell) == source[cell];
  }
  const double cells = region.graph.cells();
  std::printf("ours %.2f s, %.2f M cells/s, %.0f bytes a cell\n", least_ours, cells / least_ours / 1e6,
              bytes_ours / cells);
  std::printf("BK   %.2f s, %.2f M cells/s, %.0f bytes a cell\n", least_bk, cells / least_bk / 1e6, bytes_bk / cells);
  std::printf("ours / BK: time %.2f, memory %.2f\n", least_ours / least_bk, bytes_ours / bytes_bk);
  std::printf("sets are %s\n", same ? "the same" : "DIFFERENT");
  return same ? 0 : 1;
}
