#include "src/result/voids/tile_flow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

#include "src/base/files/disk_file.h"

namespace tessera::voids {

namespace fs = std::filesystem;

namespace {

struct ForeignVertex {
  PointId id;
  TileId owner;
  double level = 0;
  std::size_t vertex = 0;
};

class Flowing {
 public:
  Flowing(const TileSource& source, std::size_t index, const TileMesh& mesh, const TileDensities& densities,
          const std::stop_token& stop)
      : source_(source), index_(index), mesh_(mesh), densities_(densities), stop_(stop) {}

  Result<TileFlow> run() {
    BOOST_OUTCOME_TRYV(number());
    BOOST_OUTCOME_TRYV(find_roots());
    fill_basins();
    BOOST_OUTCOME_TRYV(find_saddles());
    return std::move(flow_);
  }

 private:
  Error contradiction(PointId id) const {
    return error(Errc::corrupt, source_.file(index_).string() + ": the images of point " + to_string(id) +
                                    " contradict each other; compute the columns again");
  }

  // Numbers the vertices. Foreign vertices that the tile owns are images of its own points.
  Status number() {
    const std::size_t vertices = mesh_.ids.size();
    flow_.nodes.assign(vertices, no_node);
    flow_.is_foreign = mesh_.point_ghost;
    std::vector<ForeignVertex> foreign, images;
    std::vector<std::pair<PointId, Node>> own;
    const TileId self = source_.entry(index_).tile;
    for (std::size_t v = 0; v < vertices; ++v) {
      const ForeignVertex one{mesh_.ids[v], mesh_.owners[v], densities_.levels[v], v};
      if (mesh_.point_ghost[v] != 0) {
        (mesh_.owners[v] == self ? images : foreign).push_back(one);
        continue;
      }
      flow_.nodes[v] = static_cast<Node>(flow_.ids.size());
      if (!mesh_.offsets.empty()) own.emplace_back(one.id, flow_.nodes[v]);
      flow_.ids.push_back(one.id);
      flow_.levels.push_back(one.level);
    }
    flow_.own = flow_.ids.size();
    std::sort(own.begin(), own.end());
    for (const ForeignVertex& one : images) {
      const auto found = std::lower_bound(own.begin(), own.end(), std::pair(one.id, Node{0}));
      if (found == own.end() || found->first != one.id || !same_level(flow_.levels[found->second], one.level))
        return contradiction(one.id);
      flow_.nodes[one.vertex] = found->second;
    }
    std::sort(foreign.begin(), foreign.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    for (const ForeignVertex& one : foreign) {
      const bool known = flow_.ids.size() > flow_.own && flow_.ids.back() == one.id;
      if (known && (!same_level(flow_.levels.back(), one.level) || flow_.owners.back() != one.owner))
        return contradiction(one.id);
      if (!known) {
        flow_.ids.push_back(one.id);
        flow_.levels.push_back(one.level);
        flow_.owners.push_back(one.owner);
      }
      flow_.nodes[one.vertex] = static_cast<Node>(flow_.ids.size() - 1);
    }
    return success();
  }

  bool is_outside(Node node) const { return std::isnan(flow_.levels[node]); }
  Level level(Node node) const { return {flow_.levels[node], flow_.ids[node]}; }

  // Calls `take(a, b)` for the edges of all cells between vertices that are in zones, several times for each edge. One
  // end at least is an own vertex.
  template <class Take>
  Status for_each_edge(const Take& take) const {
    constexpr std::size_t cells_a_look = 4096;
    const std::size_t corners = static_cast<std::size_t>(mesh_.dimension) + 1;
    std::array<Node, 4> at{};
    for (std::size_t cell = 0; cell < mesh_.cell_ghost.size(); ++cell) {
      if (cell % cells_a_look == 0 && stop_.stop_requested())
        return error(Errc::interrupted, "interrupted while looking for voids");
      for (std::size_t k = 0; k < corners; ++k)
        at[k] = flow_.nodes[static_cast<std::size_t>(mesh_.cells[cell * corners + k])];
      for (std::size_t i = 0; i < corners; ++i) {
        if (is_outside(at[i])) continue;
        for (std::size_t j = 0; j < i; ++j) {
          const bool known = at[i] < flow_.own || at[j] < flow_.own;
          if (known && at[i] != at[j] && !is_outside(at[j])) take(at[i], at[j]);
        }
      }
    }
    return success();
  }

  Status find_roots() {
    std::vector<Node>& lowest = flow_.roots;
    lowest.resize(flow_.own);
    for (Node node = 0; node < flow_.own; ++node) lowest[node] = is_outside(node) ? no_node : node;
    BOOST_OUTCOME_TRYV(for_each_edge([&](Node a, Node b) {
      if (level(b) < level(a)) std::swap(a, b);  // b may flow to a
      if (b < flow_.own && level(a) < level(lowest[b])) lowest[b] = a;
    }));
    // Each vertex of a chain gets the root of the chain.
    std::vector<Node> chain;
    for (Node node = 0; node < flow_.own; ++node) {
      if (lowest[node] == no_node) continue;
      Node end = node;
      while (end < flow_.own && lowest[end] != end) {
        chain.push_back(end);
        end = lowest[end];
      }
      for (const Node passed : chain) lowest[passed] = end;
      chain.clear();
    }
    return success();
  }

  void fill_basins() {
    std::vector<Node> place(flow_.ids.size(), no_node);
    for (std::size_t v = 0; v < mesh_.ids.size(); ++v) {
      if (mesh_.point_ghost[v] != 0 || flow_.roots[flow_.nodes[v]] == no_node) continue;
      const Node root = flow_.roots[flow_.nodes[v]];
      if (place[root] == no_node) {
        place[root] = static_cast<Node>(flow_.basins.size());
        flow_.basins.push_back({.root = root, .points = 0, .volume = {}});
      }
      Basin& basin = flow_.basins[place[root]];
      basin.points += static_cast<std::uint64_t>(densities_.points[v]);
      basin.volume.add(ScaledDouble::of(densities_.volumes[v]));
    }
  }

  Status find_saddles() {
    std::vector<TileSaddle>& saddles = flow_.saddles;
    std::size_t sorted = 0;
    const auto keep_lowest = [&] {
      std::sort(saddles.begin(), saddles.end(), [](const TileSaddle& x, const TileSaddle& y) {
        return std::pair(x.a, x.b) != std::pair(y.a, y.b) ? std::pair(x.a, x.b) < std::pair(y.a, y.b)
                                                          : x.level < y.level;
      });
      const auto same = [](const TileSaddle& x, const TileSaddle& y) { return x.a == y.a && x.b == y.b; };
      saddles.erase(std::unique(saddles.begin(), saddles.end(), same), saddles.end());
      sorted = saddles.size();
    };
    const auto root = [&](Node node) { return node < flow_.own ? flow_.roots[node] : node; };
    BOOST_OUTCOME_TRYV(for_each_edge([&](Node a, Node b) {
      const Node of_a = root(a), of_b = root(b);
      if (of_a == of_b) return;
      saddles.push_back({std::min(of_a, of_b), std::max(of_a, of_b), std::max(level(a), level(b))});
      // The same pair comes many times. Sorting now and then keeps the list at most about twice as long as its final
      // length.
      if (saddles.size() > 2 * sorted + (std::size_t{1} << 18)) keep_lowest();
    }));
    keep_lowest();
    return success();
  }

  const TileSource& source_;
  const std::size_t index_;
  const TileMesh& mesh_;
  const TileDensities& densities_;
  const std::stop_token& stop_;
  TileFlow flow_;
};

template <class T>
Status write_array(DiskFile& file, const std::vector<T>& array) {
  const std::uint64_t size = array.size();
  BOOST_OUTCOME_TRYV(file.write(std::as_bytes(std::span(&size, 1))));
  return file.write(std::as_bytes(std::span(array)));
}

template <class T>
Status read_array(DiskFile& file, const fs::path& path, std::vector<T>& array) {
  const auto cut_off = [&] { return error(Errc::io, path.string() + ": is shorter than it was"); };
  BOOST_OUTCOME_TRY(file_bytes, file.size());
  std::uint64_t size = 0;
  BOOST_OUTCOME_TRY(read, file.read(std::as_writable_bytes(std::span(&size, 1))));
  if (read != sizeof size || size > file_bytes / sizeof(T)) return cut_off();
  array.resize(size);
  BOOST_OUTCOME_TRY(got, file.read(std::as_writable_bytes(std::span(array))));
  if (got != size * sizeof(T)) return cut_off();
  return success();
}

}  // namespace

Result<TileFlow> TileFlow::of(const TileSource& source, std::size_t index, const TileMesh& mesh,
                              const TileDensities& densities, const std::stop_token& stop) {
  return Flowing(source, index, mesh, densities, stop).run();
}

Status TileFlow::write(const fs::path& path) const {
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::replace));
  BOOST_OUTCOME_TRYV(write_array(file, nodes));
  BOOST_OUTCOME_TRYV(write_array(file, is_foreign));
  BOOST_OUTCOME_TRYV(write_array(file, ids));
  BOOST_OUTCOME_TRYV(write_array(file, levels));
  BOOST_OUTCOME_TRYV(write_array(file, owners));
  BOOST_OUTCOME_TRYV(write_array(file, roots));
  BOOST_OUTCOME_TRYV(write_array(file, basins));
  BOOST_OUTCOME_TRYV(write_array(file, saddles));
  return file.close();
}

Result<TileFlow> TileFlow::read(const fs::path& path) {
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  TileFlow flow;
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.nodes));
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.is_foreign));
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.ids));
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.levels));
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.owners));
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.roots));
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.basins));
  BOOST_OUTCOME_TRYV(read_array(file, path, flow.saddles));
  flow.own = flow.roots.size();
  return flow;
}

}  // namespace tessera::voids
