#include "actors/node_actor.h"

#include <string>
#include <utility>

#include "actors/failing.h"
#include "actors/part_actor.h"

namespace tessera {

NodeActor::NodeActor(caf::actor_config& config, NodeOptions options, std::shared_ptr<PartSource> source)
    : NodeHandle::base(config), options_(std::move(options)), source_(std::move(source)) {}

NodeActor::behavior_type NodeActor::make_behavior() {
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { used_.erase(down.source); });
  // Whoever did not get the answer watches its own peers.
  set_error_handler([this](caf::scheduled_actor*, caf::error& reason) {
    options_.hooks.tell([&] { return "node: a message came back: " + caf::to_string(reason); });
  });
  return {[this](const OpenPart& wanted) {
    const auto coordinator = caf::actor_cast<CoordinatorHandle>(wanted.coordinator);
    PartOpened answer;
    try {
      auto opened = open(wanted);
      if (opened) {
        answer = std::move(opened).value();
      } else {
        answer.failure = failure_of(opened.error());
      }
    } catch (...) {  // one job that cannot be opened is no reason to lose the others
      answer = {};
      answer.failure = failure_of(std::current_exception(), "opening a job");
    }
    answer.node = wanted.node;
    send(coordinator, std::move(answer));
  }};
}

Result<PartOpened> NodeActor::open(const OpenPart& wanted) {
  BOOST_OUTCOME_TRY(spec, spec_from_bytes(wanted.spec));
  std::uint64_t used = 0;
  for (const auto& [part, bytes] : used_) used += bytes;
  if (used + spec.memory_bytes > options_.memory_bytes) {
    return error(Errc::memory, "job " + std::to_string(wanted.job.value) + " wants " +
                                   std::to_string(spec.memory_bytes >> 20) + " MiB of memory, but the node has " +
                                   std::to_string((options_.memory_bytes - used) >> 20) + " MiB left");
  }
  BOOST_OUTCOME_TRY(made, source_->open(spec, wanted.node));
  const std::shared_ptr<const Part> part = std::move(made);
  const std::uint64_t memory = spec.memory_bytes;
  const auto coordinator = caf::actor_cast<CoordinatorHandle>(wanted.coordinator);
  PartOpened opened;
  opened.settled = part->settled;
  const auto start = [&](auto tag) {
    return this->spawn<PartActor, decltype(tag)::value>(wanted.node, std::move(spec), part, coordinator, options_.hooks,
                                                        options_.progress_interval);
  };
  using Options = caf::spawn_options;
  const PartHandle handle = options_.detached ? start(std::integral_constant<Options, caf::detached>{})
                                              : start(std::integral_constant<Options, caf::no_spawn_options>{});
  monitor(handle);
  used_.emplace(handle.address(), memory);
  opened.part = caf::actor_cast<caf::actor>(handle);
  return opened;
}

}  // namespace tessera
