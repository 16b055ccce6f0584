// The nodes that have, or had, a part of a job, by the numbers that they have in it, and how each stands. Pure: who can
// be reached how, others know.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "src/exchange/assignment.h"

namespace tessera {

class Roster {
 public:
  enum class Standing : std::uint8_t {
    asked,    // for its part, and has not answered
    there,    // its part is open
    ended,    // its part has ended, as all do at the end of a job
    refused,  // it could not open its part; it is gone, as the next two
    lost,
    left  // in order
  };
  // What its part has said of the stage at hand since the last table.
  enum class Reached : std::uint8_t { nothing, settled, collected };

  struct Node {
    Standing standing = Standing::asked;
    Reached reached = Reached::nothing;
    bool begun = false;      // all its tiles have begun the stage
    bool dismissed = false;  // has been told that it may end before the others
    std::uint32_t threads = 1;
    std::uint64_t memory_bytes = 0;
    std::string name;         // once its part is open
    std::uint32_t tiles = 0;  // when they were counted last

    // It takes no part any more, and nothing that it says counts.
    bool gone() const { return standing >= Standing::refused; }
    bool there() const { return standing == Standing::there; }
    // Its part is not open any more, or never will be.
    bool over() const { return standing >= Standing::ended; }
  };

  std::size_t size() const { return nodes_.size(); }
  Node& operator[](NodeId node) { return nodes_.at(node.value); }
  const Node& operator[](NodeId node) const { return nodes_.at(node.value); }
  const std::vector<Node>& nodes() const { return nodes_; }

  // The next number.
  NodeId add() {
    nodes_.emplace_back();
    return NodeId{static_cast<std::uint32_t>(nodes_.size() - 1)};
  }
  // Numbers up to here are taken, by nodes of which nothing is known: they are lost until they are found.
  void take_numbers(std::size_t numbers) {
    nodes_.assign(numbers, Node());
    for (Node& node : nodes_) node.standing = Standing::lost;
  }

  bool has(NodeId node) const { return node.value < nodes_.size() && !nodes_[node.value].gone(); }
  // No part is there, and none is on its way.
  bool nobody() const {
    return all([](const Node&) { return false; });
  }
  bool all_refused() const {
    return std::all_of(nodes_.begin(), nodes_.end(),
                       [](const Node& node) { return node.standing == Standing::refused; });
  }
  // Of those that are not gone.
  template <class Is>
  bool all(Is is) const {
    return std::all_of(nodes_.begin(), nodes_.end(), [&](const Node& node) { return node.gone() || is(node); });
  }
  // Of those that are not gone and whose parts are open.
  bool all_reached(Reached what) const {
    return all([&](const Node& node) { return node.standing == Standing::asked || node.reached == what; });
  }
  bool all_have_begun() const {
    return all([](const Node& node) { return node.standing == Standing::asked || node.begun; });
  }
  bool any_has_begun() const {
    return std::any_of(nodes_.begin(), nodes_.end(), [](const Node& node) { return node.begun; });
  }
  // There is a new table.
  void forget_reached() {
    for (Node& node : nodes_) node.reached = Reached::nothing;
  }
  void begin_stage() {
    for (Node& node : nodes_) node.begun = false;
  }

 private:
  std::vector<Node> nodes_;
};

}  // namespace tessera
