// The nodes that have, or had, a share of a job, by their numbers in the job, with the state of each. A plain object
// without I/O and threads: addresses and connections are known elsewhere.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/exchange/placements.h"

namespace tessera {

class Roster {
 public:
  enum class Standing : std::uint8_t {
    asked,    // was asked to open its share, and has not answered
    there,    // its share is open
    ended,    // its share has ended, as all do at the end of a job
    refused,  // it could not open its share; this state and the next two mean that the node is gone
    lost,
    left  // in order
  };
  // What the node's share has said of the present stage since the last table.
  enum class Reached : std::uint8_t { nothing, settled, collected };

  struct Node {
    Standing standing = Standing::asked;
    Reached reached = Reached::nothing;
    bool begun = false;      // all its tiles have begun the stage
    bool dismissed = false;  // it was told that it may end before the others
    std::uint32_t threads = 1;
    std::uint64_t memory_bytes = 0;
    std::string name;         // known once its share is open
    std::uint32_t tiles = 0;  // when they were last counted

    // Returns whether the node has no share any more; nothing that it says counts.
    bool gone() const { return standing >= Standing::refused; }
    bool there() const { return standing == Standing::there; }
    // Returns whether its share is no longer open, or never will be.
    bool over() const { return standing >= Standing::ended; }
  };

  std::size_t size() const { return nodes_.size(); }
  Node& operator[](NodeId node) { return nodes_.at(node.value); }
  const Node& operator[](NodeId node) const { return nodes_.at(node.value); }
  const std::vector<Node>& nodes() const { return nodes_; }

  // Adds a node and returns its number, which is the next free one.
  NodeId add() {
    nodes_.emplace_back();
    return NodeId{static_cast<std::uint32_t>(nodes_.size() - 1)};
  }
  // Takes the first `numbers` numbers, for nodes of which nothing is known. These nodes count as lost until they are
  // found.
  void take_numbers(std::size_t numbers) {
    nodes_.assign(numbers, Node());
    for (Node& node : nodes_) node.standing = Standing::lost;
  }

  // What a node gives the job, and its name.
  struct Offer {
    std::uint32_t threads = 1;
    std::uint64_t memory_bytes = 0;
    std::string name;
  };
  // A node has opened its share. `settled` says whether an earlier process has settled all tiles of the share. A node
  // that is gone stays gone.
  void open(NodeId number, bool settled, Offer offer) {
    Node& node = nodes_.at(number.value);
    if (!node.gone()) node.standing = Standing::there;
    if (settled) node.reached = Reached::settled;
    take(node, std::move(offer));
  }
  // A share of an earlier coordinator is found.
  void find(NodeId number, bool begun, Offer offer) {
    Node& node = nodes_.at(number.value);
    node.standing = Standing::there;
    node.begun = begun;
    take(node, std::move(offer));
  }

  bool has(NodeId node) const { return node.value < nodes_.size() && !nodes_[node.value].gone(); }
  // Returns whether no share is open and none is being opened.
  bool nobody() const {
    return all([](const Node&) { return false; });
  }
  bool all_refused() const {
    return std::all_of(nodes_.begin(), nodes_.end(),
                       [](const Node& node) { return node.standing == Standing::refused; });
  }
  // Returns whether `is` holds for every node that is not gone.
  template <class Is>
  bool all(Is is) const {
    return std::all_of(nodes_.begin(), nodes_.end(), [&](const Node& node) { return node.gone() || is(node); });
  }
  // Returns whether the shares of all nodes that are not gone and have opened their shares have reached `what`.
  bool all_reached(Reached what) const {
    return all([&](const Node& node) { return node.standing == Standing::asked || node.reached == what; });
  }
  // Returns whether all nodes that were asked to open their shares have answered.
  bool all_have_answered() const {
    return all([](const Node& node) { return node.standing != Standing::asked; });
  }
  bool all_are_over() const {
    return all([](const Node& node) { return node.over(); });
  }
  // Returns whether a node of this name has had a share, and has a name.
  bool knows(const std::string& name) const {
    return !name.empty() &&
           std::any_of(nodes_.begin(), nodes_.end(), [&](const Node& node) { return node.name == name; });
  }
  // Returns the memory that all nodes have given the job, together.
  std::uint64_t memory_bytes() const {
    std::uint64_t sum = 0;
    for (const Node& node : nodes_) sum += node.memory_bytes;
    return sum;
  }
  bool all_have_begun() const {
    return all([](const Node& node) { return node.standing == Standing::asked || node.begun; });
  }
  bool any_has_begun() const {
    return std::any_of(nodes_.begin(), nodes_.end(), [](const Node& node) { return node.begun; });
  }
  // There is a new table, so what shares have said before does not count any more.
  void forget_reached() {
    for (Node& node : nodes_) node.reached = Reached::nothing;
  }
  void begin_stage() {
    for (Node& node : nodes_) node.begun = false;
  }
  // Counts the tiles of each node, unless they were counted by the same table before.
  void count_tiles(const Placements& placements) {
    if (counted_ == placements.table().epoch) return;
    counted_ = placements.table().epoch;
    const std::vector<std::uint32_t> tiles = placements.tiles(nodes_.size());
    for (std::size_t n = 0; n < tiles.size(); ++n) nodes_[n].tiles = tiles[n];
  }

 private:
  static void take(Node& node, Offer offer) {
    node.threads = offer.threads;
    node.memory_bytes = offer.memory_bytes;
    node.name = std::move(offer.name);
  }

  std::vector<Node> nodes_;
  std::optional<Epoch> counted_;
};

}  // namespace tessera
