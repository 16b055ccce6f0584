// A node: what one process offers to jobs. It opens a share for each job, within the memory that it has.
//
// message    | effect                                                     | answer to the coordinator, or router
// OpenShare  | read what the share needs to know, start its actor         | ShareOpened, always
// FindShare  | pass it on to the share of that job, if there is one       | ShareFound: by the share, or by this actor,
//            |                                                            | which says that there is none
// RouteSplit | a thread routes the split, and stops if the router is gone | SplitRouted
// Leave      | its shares leave, too                                      | -
//
// The memory of a share is free again when the share's actor and its tiles have let go of it.
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
  std::uint32_t threads = 1;  // threads and memory are for all jobs together
  std::uint64_t memory_bytes = 0;
  // Bytes of shares.
  std::shared_ptr<std::atomic<std::uint64_t>> used = std::make_shared<std::atomic<std::uint64_t>>();
  std::shared_ptr<NodeMeter> meter = std::make_shared<NodeMeter>();
  std::chrono::milliseconds progress_interval{100};
  std::filesystem::path data = {};  // folders that a coordinator names must lie in it; empty: anywhere
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
    caf::actor_addr share;
    std::optional<FindShare> wanted;  // the last request that was passed on: the share may not have got it
  };
  std::map<JobId, Opened> shares_;
  std::map<JobId, Term> terms_;   // the highest known: requests of lower terms are refused
  Prepared<ShareOpened> answer_;  // the next one
  // By router; a thread has ended, or ends soon, when its router is gone.
  std::map<caf::actor_addr, std::jthread> routing_;
};

}  // namespace tessera
