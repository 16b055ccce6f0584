#include "actors/node_actor.h"

#include <string>
#include <utility>

#include "actors/failing.h"
#include "actors/part_actor.h"

namespace tessera {

NodeActor::NodeActor(caf::actor_config& config, NodeOptions options, std::shared_ptr<PartSource> source)
    : NodeHandle::base(config), options_(std::move(options)), source_(std::move(source)) {}

NodeActor::behavior_type NodeActor::make_behavior() {
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
  const std::uint64_t memory = spec.memory_bytes, left = options_.memory_bytes - *used_;
  if (memory > left) {
    return error(Errc::memory, "job " + std::to_string(wanted.job.value) + " wants " + std::to_string(memory >> 20) +
                                   " MiB of memory, but the node has " + std::to_string(left >> 20) + " MiB left");
  }
  BOOST_OUTCOME_TRY(made, source_->open(spec, wanted.node));
  *used_ += memory;
  // Before the part lets go of the run: whoever has waited for that may begin the next job.
  const std::shared_ptr<const Part> part(made.release(), [used = used_, memory](const Part* last) {
    *used -= memory;
    delete last;
  });
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
  opened.part = caf::actor_cast<caf::actor>(handle);
  return opened;
}

}  // namespace tessera
