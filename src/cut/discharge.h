// A region's side of a cut over many regions: flow goes on inside of it and across its borders until none can.
//
// Asynchronous region discharge, after A. Shekhovtsov and V. Hlavac, A distributed mincut/maxflow algorithm combining
// path augmentation and push-relabel, IJCV 2013. What a region tells of a border are its counter of all that it has
// ever sent across, and a label: a lower bound of how many borders lie between its cell and a deficit. Counters and
// labels only rise, so news may come in any order and twice. What a region knows of the other's counter lags behind, so
// that no capacity is ever exceeded. Labels and the bound of labels can only cost time: a flood proves the end
// (flood.h, docs/surfaces.md).
#pragma once

#include <cstdint>
#include <vector>

#include "src/cut/cut_graph.h"

namespace tessera::cut {

class Discharge {
 public:
  // Of a border: what has been sent across it since the beginning, and the label of the cell there.
  struct News {
    std::uint32_t border = 0;
    std::uint64_t sent = 0;
    std::uint32_t label = 0;
    friend bool operator==(const News&, const News&) = default;
  };

  // `graph` outlives this, and nobody else changes it. `bound`: no cell has a greater label.
  Discharge(CutGraph& graph, std::uint32_t bound);

  // Of the other side of a border, which has the same number here. Whether anything is new.
  bool receive(const News& news);
  // Sends as much excess as can go to deficits and across borders; then the news that were not told yet.
  std::vector<News> run();

  // Raises the bound; labels stay, as they are lower bounds still.
  void set_bound(std::uint32_t bound) { bound_ = bound; }
  // When regions have been lost, labels may be none any more.
  void forget_labels();
  // The other side has lost all, or this one: what the one that was not lost knows. To be called before anything else
  // for each such border, in a region that begins; a region that goes on calls it for borders to regions that begin
  // only to learn nothing new.
  void restore(std::uint32_t border, std::uint64_t sent, std::uint64_t received);

  std::uint64_t sent(std::uint32_t border) const { return borders_[border].sent; }
  std::uint64_t received(std::uint32_t border) const { return borders_[border].received; }

 private:
  struct State {
    std::uint64_t sent = 0, received = 0;
    std::uint32_t label = 0;   // of the cell here
    std::uint32_t across = 0;  // greatest label heard of the cell there
    std::uint64_t told_sent = 0;
    std::uint32_t told_label = 0;
  };

  std::vector<std::uint32_t> stages() const;
  void send_at(std::uint32_t stage);
  void relabel(const std::vector<std::uint32_t>& stages);
  Arc arc(std::uint32_t border) const { return graph_.borders[border].arc; }

  CutGraph& graph_;
  std::uint32_t bound_;
  std::vector<State> borders_;
};

}  // namespace tessera::cut
