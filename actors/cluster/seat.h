// The membership of this process in a cluster: the actor of the node that is a member, the registry if this process
// coordinates, and the port.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "actors/cluster/messages.h"
#include "actors/engine/membership.h"

namespace tessera {

class Seat final : public Membership {
 public:
  // `last_words` says how the process before this one ended; empty: in order.
  explicit Seat(ClusterOptions options, std::string last_words = {})
      : options_(std::move(options)), last_words_(std::move(last_words)) {}
  const ClusterOptions& options() const override { return options_; }
  void prepare(caf::actor_system_config& config) override;
  Status take(caf::actor_system& system, const Own& own) override;
  void leave() noexcept override;
  MembershipStatus membership_status() const override;
  void depart() const override;
  std::vector<NodeState> members() const override;
  std::uint64_t lost() const override { return list().lost; }
  bool gathering() const override;
  std::vector<NodeHandle> nodes(bool all, const std::stop_token& stop) const override;
  void follow(const FollowerHandle& job) const override;
  Result<bool> drain(const std::string& node) const override;

 private:
  MemberList list() const;

  ClusterOptions options_;
  std::string last_words_;
  caf::actor_system* system_ = nullptr;
  RegistryHandle registry_;
  MemberHandle member_;
  NodeUuid uuid_;  // of this process as a node
  std::uint16_t port_ = 0;
  std::chrono::steady_clock::time_point taken_ = std::chrono::steady_clock::now();
};

}  // namespace tessera
