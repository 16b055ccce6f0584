// Figures about the exchange of a job. Tiles count them, nodes and the coordinator add them up, and summary, manifest
// and report show them.
#pragma once

#include <algorithm>
#include <cstdint>

#include "src/base/phases.h"

namespace tessera {

// What tiles told each other, in items of their program. In a triangulation the items are points.
struct ExchangeCounts {
  std::uint64_t received = 0;  // including repeats
  std::uint64_t inserted = 0;
  std::uint64_t refused = 0;  // items that were of no use when they came: points in conflict with no local star
  std::uint64_t sent = 0;     // items that were put into updates
  std::uint64_t useful = 0;   // items that were of use in the end: foreign vertices of cells with a local vertex

  ExchangeCounts& operator+=(const ExchangeCounts& other) {
    received += other.received;
    inserted += other.inserted;
    refused += other.refused;
    sent += other.sent;
    useful += other.useful;
    return *this;
  }
  ExchangeCounts& operator-=(const ExchangeCounts& other) {
    received -= other.received;
    inserted -= other.inserted;
    refused -= other.refused;
    sent -= other.sent;
    useful -= other.useful;
    return *this;
  }
};

// The seconds that the steps of the tiles' program took.
struct StepSeconds {
  double begin = 0, exchange = 0, store = 0;

  double of(StageStep step) const {
    switch (step) {
      case StageStep::begin:
        return begin;
      case StageStep::exchange:
        return exchange;
      case StageStep::store:
        return store;
      case StageStep::none:
        break;
    }
    return 0;
  }
};

// The figures of a whole job.
struct ExchangeFigures {
  ExchangeCounts points;
  std::uint64_t updates = 0;        // messages with points, from tile to tile
  std::uint64_t hops = 0;           // the length of the longest chain of updates that caused one another
  std::uint64_t most_received = 0;  // the most points that any one tile was told of, including repeats
  std::uint64_t waves = 0;          // collections of counters until quiescence was proved
  std::uint64_t sleeps = 0;         // how often a tile was put to sleep on disk
  StepSeconds work;                 // summed over threads
  // The following are for jobs on a cluster.
  std::uint64_t nodes = 0, nodes_lost = 0;
  std::uint64_t tiles_again = 0;    // tiles that began again because a node was lost
  std::uint64_t bytes_between = 0;  // bytes sent between nodes
  std::uint64_t credit_waits = 0;   // how often data had to wait until another node had taken what it was sent before
};

}  // namespace tessera
