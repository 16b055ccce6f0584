// What the exchange of a job costs: counted by tiles, added up by nodes and coordinator, shown by summary, manifest and
// report.
#pragma once

#include <algorithm>
#include <cstdint>

#include "src/base/phases.h"

namespace tessera {

// What tiles told each other, in items of their program: points, in a triangulation.
struct ExchangeCounts {
  std::uint64_t received = 0;  // repeats included
  std::uint64_t inserted = 0;
  std::uint64_t refused = 0;  // of no use when they came: points in conflict with no local star
  std::uint64_t sent = 0;     // put into updates
  std::uint64_t kept = 0;     // of use in the end: foreign vertices of cells with a local vertex

  ExchangeCounts& operator+=(const ExchangeCounts& other) {
    received += other.received;
    inserted += other.inserted;
    refused += other.refused;
    sent += other.sent;
    kept += other.kept;
    return *this;
  }
  ExchangeCounts& operator-=(const ExchangeCounts& other) {
    received -= other.received;
    inserted -= other.inserted;
    refused -= other.refused;
    sent -= other.sent;
    kept -= other.kept;
    return *this;
  }
};

// What the steps of the tiles' program took.
struct StepSeconds {
  double begin = 0, exchange = 0, store = 0;

  double of(ProgramStep step) const {
    switch (step) {
      case ProgramStep::begin:
        return begin;
      case ProgramStep::exchange:
        return exchange;
      case ProgramStep::store:
        return store;
      case ProgramStep::none:
        break;
    }
    return 0;
  }
};

struct ExchangeFigures {
  ExchangeCounts points;
  std::uint64_t updates = 0;        // messages with points between tiles
  std::uint64_t hops = 0;           // the longest chain of updates that caused one another
  std::uint64_t most_received = 0;  // points that any one tile was told of, repeats included
  std::uint64_t waves = 0;          // collections of counters until quiet was proved
  std::uint64_t sleeps = 0;         // times a tile was put to sleep on disk
  StepSeconds work;                 // summed over threads
  // Of a cluster's job.
  std::uint64_t nodes = 0, nodes_lost = 0;
  std::uint64_t tiles_again = 0;    // begun again when a node was lost
  std::uint64_t bytes_between = 0;  // between nodes
  std::uint64_t credit_waits = 0;   // times that something had to wait for another node to take what it was sent
};

}  // namespace tessera
