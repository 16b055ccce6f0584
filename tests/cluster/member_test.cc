// A node among others that die while it comes. The test is the coordinator.
#include "actors/cluster/member.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "actors/cluster/network.h"
#include "actors/cluster/registry.h"
#include "tests/cluster/cluster_testing.h"

namespace tessera {
namespace {

// What a coordinator would hear.
class Heard {
 public:
  void note(const std::string& what) {
    const std::lock_guard lock(mutex_);
    all_.push_back(what);
    changed_.notify_all();
  }
  // Waits for it.
  void expect(const std::string& what) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return std::find(all_.begin(), all_.end(), what) != all_.end(); });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> all_;
};

// Welcomes whoever comes, and tells him of another node at `address`.
class Host final : public RegistryHandle::base {
 public:
  Host(caf::actor_config& config, Heard& heard, std::string address)
      : RegistryHandle::base(config), heard_(heard), address_(std::move(address)) {}
  behavior_type make_behavior() override {
    return {[](const WhoIs&) {},
            [this](const Hello& hello) {
              send(caf::actor_cast<MemberHandle>(hello.member), Welcome{{"other"}, {address_}, address_});
            },
            [this](const ReachedAll&) { heard_.note("reached all"); },
            [](const Renew&) {},
            [this](const Unreachable& pair) { heard_.note("unreachable " + pair.to); },
            [](const Leaving&) {},
            [](const Follow&) {},
            [](const Drain&) { return Drained{}; },
            [](const NodeLet&) {},
            [](const AskMembers&) { return MemberList{}; },
            [this](const Leave&) { quit(); },
            [](caf::tick_atom) {}};
  }

 private:
  Heard& heard_;
  std::string address_;
};

class System : public caf::actor_system_config {
 public:
  explicit System(const ClusterOptions& options) {
    add_message_types<caf::id_block::tessera>();
    add_message_types<caf::id_block::tessera_cluster>();
    load_network(*this, options);
  }
};

// The other one has died before it could be reached, and the coordinator knows it, or will: it is done without.
TEST_F(ClusterTest, ANodeThatCannotReachOneThatHasDiedIsFreeAllTheSame) {
  Heard heard;
  auto with = options("comes");
  System config(with);
  caf::actor_system system(config);
  const auto host = system.spawn<Host>(heard, "127.0.0.1:" + std::to_string(free_port()));
  MemberOptions member;
  member.cluster = with;
  member.info = {"comes", "comes", "127.0.0.1:1", 1, 1};
  member.registry = caf::actor_cast<caf::actor>(host);
  member.use = [] { return NodeUse{}; };
  member.jobs = [] { return std::uint64_t{0}; };
  const auto comes = system.spawn<Member>(std::move(member));
  heard.expect("unreachable other");
  heard.expect("reached all");
  caf::anon_send(comes, Leave{});
  caf::anon_send(host, Leave{});
}

// Twice a second, as long as nobody mends it: the log is not the place for each.
TEST_F(ClusterTest, ANodeThatIsRefusedAgainAndAgainIsALineOnce) {
  auto with = options("coordinator");
  int lines = 0;
  with.log = [&](const std::string& line) { lines += line.find("is refused") == std::string::npos ? 0 : 1; };
  System config(with);
  caf::actor_system system(config);
  const auto registry = system.spawn<Registry>(with);
  {
    caf::scoped_actor node{system};
    Hello hello;
    hello.info = {"uuid", "stranger", "127.0.0.1:1", 1, 1};
    hello.member = hello.node = caf::actor_cast<caf::actor>(node.ptr());
    for (const char* cluster : {"another", "another", "another", "a third"}) {
      hello.cluster = cluster;
      node->send(registry, hello);
      node->receive([](const Refused&) {});
    }
  }
  EXPECT_EQ(lines, 2);
  caf::anon_send(registry, Leave{});
}

}  // namespace
}  // namespace tessera
