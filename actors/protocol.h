// What actors say to each other. Nothing here holds a double: CAF's codec for them is not exact (-0, denormals) and
// does not end on infinity; coordinates travel as raw bytes, times as whole microseconds.
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "actors/tile_state.h"
#include "src/base/result.h"
#include "src/store/tile_store.h"

namespace tessera {

// node -> tile: do this now; answered by a TileReport.
enum class Work : std::uint8_t { triangulate, splay, sleep, collect };

constexpr const char* name_of(Work work) {
  constexpr const char* names[] = {"triangulate", "splay", "sleep", "collect"};
  return names[static_cast<int>(work)];
}

struct Grant {
  Work work = Work::splay;
};

// tile -> node: mail has come.
struct MailNotice {
  std::uint32_t tile = 0;
  std::uint64_t points = 0;
};

// tile -> node: the work is done, or has failed.
struct TileReport {
  std::uint32_t tile = 0;
  Work work = Work::splay;
  std::uint8_t failed = 0;  // an Errc, or 0
  std::string failure;
  std::uint64_t memory = 0;
  std::uint64_t sent = 0, processed = 0;
  std::uint64_t waiting = 0;  // points of mail that came meanwhile
  std::uint64_t microseconds = 0;
  std::uint32_t hops = 0;
  std::uint64_t received = 0, inserted = 0, kept = 0, points_sent = 0;
  // After triangulate:
  std::vector<std::uint64_t> duplicates;  // duplicate, kept, duplicate, kept, ...
  std::uint64_t own_points = 0;
};

// tile -> node, some time after it has been collected: its mesh is in the store, or could not be stored.
struct TileStored {
  std::uint32_t tile = 0;
  std::uint8_t failed = 0;  // an Errc, or 0
  std::string failure;
  std::vector<std::uint64_t> entry;  // the fields of TileEntry
};

// node -> coordinator
struct IdleNotice {
  std::uint32_t node = 0;
};
struct NodeTally {
  std::uint32_t node = 0;
  std::uint64_t wave = 0;
  bool idle = false;
  std::uint64_t sent = 0, processed = 0;
};
struct NodeFinished {
  std::uint32_t node = 0;
};
struct NodeFailed {
  std::uint32_t node = 0;
  std::uint8_t code = 0;
  std::string text;
};

// coordinator -> node
struct Start {};
struct Probe {
  std::uint64_t wave = 0;
};
struct CollectAll {};

// coordinator -> whoever runs the job
struct RunQuiet {
  std::uint64_t waves = 0;
};
struct RunEnded {
  std::uint8_t code = 0;  // an Errc; ok when all tiles are stored
  std::string text;
  std::uint64_t waves = 0;
};

template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, Grant& x) {
  return f(caf::meta::type_name("Grant"), x.work);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, MailNotice& x) {
  return f(caf::meta::type_name("MailNotice"), x.tile, x.points);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, TileReport& x) {
  return f(caf::meta::type_name("TileReport"), x.tile, x.work, x.failed, x.failure, x.memory, x.sent, x.processed,
           x.waiting, x.microseconds, x.hops, x.received, x.inserted, x.kept, x.points_sent, x.duplicates,
           x.own_points);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, TileStored& x) {
  return f(caf::meta::type_name("TileStored"), x.tile, x.failed, x.failure, x.entry);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, IdleNotice& x) {
  return f(caf::meta::type_name("IdleNotice"), x.node);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, NodeTally& x) {
  return f(caf::meta::type_name("NodeTally"), x.node, x.wave, x.idle, x.sent, x.processed);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, NodeFinished& x) {
  return f(caf::meta::type_name("NodeFinished"), x.node);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, NodeFailed& x) {
  return f(caf::meta::type_name("NodeFailed"), x.node, x.code, x.text);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, Start&) {
  return f(caf::meta::type_name("Start"));
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, Probe& x) {
  return f(caf::meta::type_name("Probe"), x.wave);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, CollectAll&) {
  return f(caf::meta::type_name("CollectAll"));
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, RunQuiet& x) {
  return f(caf::meta::type_name("RunQuiet"), x.waves);
}
template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, RunEnded& x) {
  return f(caf::meta::type_name("RunEnded"), x.code, x.text, x.waves);
}

// Batches: numbers, then the points as one block of raw bytes (20 times faster than one by one, and exact).
inline constexpr std::uint64_t batch_points_max = std::uint64_t{1} << 24;
inline caf::error inspect(caf::serializer& f, Batch& x) {
  std::uint64_t n = x.points.size();
  if (auto failed = f(x.from.tile.value, x.from.incarnation, x.to.tile.value, x.to.incarnation, x.hops, n))
    return failed;
  return n > 0 ? f.apply_raw(n * sizeof(SharedPoint), x.points.data()) : caf::error{};
}
inline caf::error inspect(caf::deserializer& f, Batch& x) {
  std::uint64_t n = 0;
  if (auto failed = f(x.from.tile.value, x.from.incarnation, x.to.tile.value, x.to.incarnation, x.hops, n))
    return failed;
  if (n > batch_points_max) return caf::sec::invalid_argument;
  x.points.resize(n);
  return n > 0 ? f.apply_raw(n * sizeof(SharedPoint), x.points.data()) : caf::error{};
}
inline std::string to_string(const Batch& x) {
  return "Batch(" + std::to_string(x.from.tile.value) + " -> " + std::to_string(x.to.tile.value) + ", " +
         std::to_string(x.points.size()) + " points, hop " + std::to_string(x.hops) + ")";
}

std::vector<std::uint64_t> to_numbers(const TileEntry& entry);
TileEntry entry_from_numbers(const std::vector<std::uint64_t>& numbers);

}  // namespace tessera

CAF_BEGIN_TYPE_ID_BLOCK(tessera, first_custom_type_id)
CAF_ADD_TYPE_ID(tessera, (tessera::Batch))
CAF_ADD_TYPE_ID(tessera, (tessera::CollectAll))
CAF_ADD_TYPE_ID(tessera, (tessera::Grant))
CAF_ADD_TYPE_ID(tessera, (tessera::IdleNotice))
CAF_ADD_TYPE_ID(tessera, (tessera::MailNotice))
CAF_ADD_TYPE_ID(tessera, (tessera::NodeFailed))
CAF_ADD_TYPE_ID(tessera, (tessera::NodeFinished))
CAF_ADD_TYPE_ID(tessera, (tessera::NodeTally))
CAF_ADD_TYPE_ID(tessera, (tessera::Probe))
CAF_ADD_TYPE_ID(tessera, (tessera::RunEnded))
CAF_ADD_TYPE_ID(tessera, (tessera::RunQuiet))
CAF_ADD_TYPE_ID(tessera, (tessera::Start))
CAF_ADD_TYPE_ID(tessera, (tessera::TileReport))
CAF_ADD_TYPE_ID(tessera, (tessera::TileStored))
CAF_END_TYPE_ID_BLOCK(tessera)
