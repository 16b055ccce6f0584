// A node: what one process offers to jobs. Opens a part for each, within the memory it has.
//
// message      | effect                                                | answer to the coordinator, or router
// OpenShare     | read what the part needs to know, start its actor     | ShareOpened, always
// FindShare     | pass it on to the part of that job, if there is one   | ShareFound: by the part, or that there is none
// RouteSplit | a thread routes it, which stops if the router is gone | SplitRouted
// Leave        | its parts leave, too                                  | -
//
// What a part may use is free again when the part's actor and its tiles have let go of it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "actors/actor_directory.h"
#include "actors/node_meter.h"
#include "actors/prepared.h"
#include "actors/protocol.h"
#include "actors/steady_actor.h"
#include "src/exchange/share.h"

namespace tessera {

struct NodeOptions {
  std::string name = {};      // in its cluster
  std::uint32_t threads = 1;  // for all jobs together, as is the memory
  std::uint64_t memory_bytes = 0;
  std::shared_ptr<std::atomic<std::uint64_t>> used = std::make_shared<std::atomic<std::uint64_t>>();  // bytes, of parts
  std::shared_ptr<NodeMeter> meter = std::make_shared<NodeMeter>();
  std::chrono::milliseconds progress_interval{100};
  std::filesystem::path data = {};  // in which all lies that a coordinator names; none: anywhere
  Hooks hooks;
};

class NodeActor : public SteadyActor<NodeHandle, Pool::deciding> {
 public:
  NodeActor(caf::actor_config& config, NodeOptions options, std::shared_ptr<ShareSource> source);
  behavior_type make_behavior() override;

 private:
  void failed(const std::exception_ptr&) noexcept override {}
  void answer(const OpenShare& wanted);
  void prepare_answer() noexcept;
  ShareOpened open_or_say_why(const OpenShare& wanted) noexcept;
  Result<ShareOpened> open(const OpenShare& wanted);
  bool is_replaced(JobId job, Term term);
  Status check_path(const std::string& path) const;
  void leave();
  void find(const FindShare& wanted);
  void gone(const caf::down_msg& down);
  void answer_none(const FindShare& wanted);
  void route(const RouteSplit& wanted);

  NodeOptions options_;
  std::shared_ptr<ShareSource> source_;
  struct Opened {
    caf::actor_addr part;
    std::optional<FindShare> wanted;  // the last that was passed on: it may not have arrived
  };
  std::map<JobId, Opened> parts_;
  std::map<JobId, Term> terms_;   // the highest heard of: what an earlier one wants is not done any more
  Prepared<ShareOpened> answer_;  // the next one
  std::map<caf::actor_addr, std::jthread> routing_;  // by router; has ended or ends soon where that is gone
};

}  // namespace tessera
