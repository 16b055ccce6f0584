#include "src/cut/discharge.h"

#include <algorithm>

#include "src/base/check.h"
#include "src/cut/search_trees.h"

namespace tessera::cut {

Discharge::Discharge(CutGraph& graph, std::uint32_t bound)
    : graph_(graph), bound_(bound), borders_(graph.borders.size()) {}

void Discharge::restore(std::uint32_t border, std::uint64_t sent, std::uint64_t received) {
  State& state = borders_[border];
  std::uint32_t& capacity = graph_.capacity[arc(border)];
  std::int64_t& excess = graph_.excess[arc(border) >> 2u];
  check(state.sent == 0 && state.received == 0, "a region is told once what it had sent");
  capacity = static_cast<std::uint32_t>(capacity + received - sent);
  excess += static_cast<std::int64_t>(received) - static_cast<std::int64_t>(sent);
  state.sent = state.told_sent = sent;
  state.received = received;
}

void Discharge::forget_labels() {
  for (State& state : borders_) state.label = state.across = state.told_label = 0;
}

bool Discharge::receive(const News& news) {
  State& state = borders_[news.border];
  bool fresh = false;
  if (news.label > state.across) {
    state.across = news.label;
    fresh = true;
  }
  if (news.sent <= state.received) return fresh;
  const auto flow = static_cast<std::uint32_t>(news.sent - state.received);
  state.received = news.sent;
  graph_.capacity[arc(news.border)] += flow;
  // From farther on it would only come back: that it does so at once spares a turn.
  if (state.label > news.label + 1) {
    state.sent += flow;
    graph_.capacity[arc(news.border)] -= flow;
  } else {
    graph_.excess[arc(news.border) >> 2u] += flow;
  }
  return true;
}

// Excess goes to deficits first, then across the borders with the least labels.
std::vector<std::uint32_t> Discharge::stages() const {
  std::vector<std::uint32_t> stages{0};
  for (const State& state : borders_)
    if (state.across < bound_) stages.push_back(state.across + 1);
  std::ranges::sort(stages);
  stages.erase(std::ranges::unique(stages).begin(), stages.end());
  return stages;
}

// Borders that may be crossed are deficits meanwhile, as large as what they let through.
void Discharge::send_at(std::uint32_t stage) {
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; stage > 0 && i < borders_.size(); ++i) {
    if (borders_[i].across + 1 > stage || borders_[i].across >= bound_ || graph_.capacity[arc(i)] == 0) continue;
    open.push_back(i);
    graph_.excess[arc(i) >> 2u] -= graph_.capacity[arc(i)];
  }
  SearchTrees(graph_).run();
  // A deficit of the cell's own is filled before anything leaves it.
  for (const std::uint32_t i : open) graph_.excess[arc(i) >> 2u] += graph_.capacity[arc(i)];
  for (const std::uint32_t i : open) {
    std::int64_t& excess = graph_.excess[arc(i) >> 2u];
    const auto flow = static_cast<std::uint32_t>(std::clamp<std::int64_t>(excess, 0, graph_.capacity[arc(i)]));
    excess -= flow;
    graph_.capacity[arc(i)] -= flow;
    borders_[i].sent += flow;
  }
}

void Discharge::relabel(const std::vector<std::uint32_t>& stages) {
  std::vector<std::uint32_t> label(graph_.cells(), bound_);
  CellSet labelled(graph_.cells());
  std::vector<std::uint32_t> queue;
  const auto put = [&](std::uint32_t cell, std::uint32_t stage) {
    if (!labelled.insert(cell)) return;
    label[cell] = stage;
    queue.push_back(cell);
  };
  for (const std::uint32_t stage : stages) {
    if (stage == 0) {
      for (std::uint32_t cell = 0; cell < graph_.cells(); ++cell)
        if (graph_.excess[cell] < 0) put(cell, 0);
    }
    for (std::uint32_t i = 0; stage > 0 && i < borders_.size(); ++i)
      if (borders_[i].across + 1 == stage && graph_.capacity[arc(i)] > 0) put(arc(i) >> 2u, stage);
    while (!queue.empty()) {
      const std::uint32_t cell = queue.back();
      queue.pop_back();
      for (Arc out = 4 * cell; out < 4 * cell + 4; ++out) {
        const Arc in = graph_.back[out];
        if (is_inner(in) && graph_.capacity[in] > 0) put(in >> 2u, stage);
      }
    }
  }
  for (std::uint32_t i = 0; i < borders_.size(); ++i)
    borders_[i].label = std::max(borders_[i].label, std::min(label[arc(i) >> 2u], bound_));
}

std::vector<Discharge::News> Discharge::run() {
  const auto in_turn = stages();
  for (const std::uint32_t stage : in_turn) send_at(stage);
  relabel(in_turn);
  std::vector<News> news;
  for (std::uint32_t i = 0; i < borders_.size(); ++i) {
    State& state = borders_[i];
    if (state.sent == state.told_sent && state.label == state.told_label) continue;
    state.told_sent = state.sent;
    state.told_label = state.label;
    news.push_back({i, state.sent, state.label});
  }
  return news;
}

}  // namespace tessera::cut
