// Messages between nodes and their coordinator about the cluster itself. As for jobs, they contain no pointers and no
// doubles.
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "actors/inspect_message.h"
#include "actors/protocol.h"
#include "src/cluster/members.h"

namespace tessera {

// Changes when any message between nodes changes.
inline constexpr std::uint32_t wire_version = 11;

// any process -> a process of the cluster: who coordinates?
struct WhoIs {
  caf::actor asks;
};
struct CoordinatorIs {
  caf::actor registry;  // at the sender; or else
  std::string address;  // its address; empty: not known
};

// node -> coordinator
struct Hello {
  std::uint32_t wire = wire_version;
  std::string cluster, shared;
  MemberInfo info;
  NodeUse use;
  std::string last_words;  // how the process before it ended; empty: in order
  caf::actor member, node;
};
struct Welcome {
  std::vector<std::string> uuids, addresses;  // of the other nodes, to which it is to connect
  std::string coordinator;                    // address of the coordinator
};
struct Refused {
  std::string why;
};
struct ReachedAll {
  std::string uuid;
};
struct Renew {
  std::string uuid;
  NodeUse use;
};
struct Renewed {};
// coordinator -> node: the node is lost, and may come back as another node (`again`); or it is drained, and ends.
struct Expelled {
  std::string why;
  bool again = true;
};
struct Unreachable {
  std::string from, to;
};
// coordinator, or the code that ends the node's process -> node: leave in order. The node tells the coordinator by
// Leaving, each time.
struct AskToLeave {};
// node -> coordinator: the node is to leave, by its own wish or because this or an earlier coordinator has asked it. It
// works for `jobs` jobs, which the coordinator may not all know yet.
struct Leaving {
  std::string uuid;
  std::uint64_t jobs = 0;
};

// job -> coordinator of the cluster: tell this actor of nodes that come and go.
struct Follow {
  caf::actor follower;
};
// -> coordinator of the cluster: take all work from a node, and let it go. `node` is a name or uuid.
struct Drain {
  std::string node;
};
struct Drained {
  bool found = false;   // there is such a node
  std::string refused;  // why it stays; empty: it goes
};
struct AskMembers {};
struct MemberList {
  std::vector<NodeState> members;  // in the order of coming
  std::vector<caf::actor> nodes;   // actors of the members, in the same order
  std::uint64_t lost = 0;          // nodes that were ever lost; drained nodes do not count
};

// the process -> its own node: what is the node's membership?
struct AskStatus {};

using MemberHandle = caf::typed_actor<caf::reacts_to<WhoIs>, caf::reacts_to<CoordinatorIs>, caf::reacts_to<Welcome>,
                                      caf::reacts_to<Refused>, caf::reacts_to<Renewed>, caf::reacts_to<Expelled>,
                                      caf::reacts_to<AskToLeave>, caf::reacts_to<Leave>,
                                      caf::replies_to<AskStatus>::with<MembershipStatus>,
                                      caf::reacts_to<caf::tick_atom>, caf::reacts_to<caf::connect_atom>>;
using RegistryHandle = caf::typed_actor<caf::reacts_to<WhoIs>, caf::reacts_to<Hello>, caf::reacts_to<ReachedAll>,
                                        caf::reacts_to<Renew>, caf::reacts_to<Unreachable>, caf::reacts_to<Leaving>,
                                        caf::reacts_to<Follow>, caf::replies_to<Drain>::with<Drained>,
                                        caf::reacts_to<NodeLet>, caf::replies_to<AskMembers>::with<MemberList>,
                                        caf::reacts_to<Leave>, caf::reacts_to<caf::tick_atom>>;

TESSERA_MESSAGE(MemberInfo, x.uuid, x.name, x.address, x.threads, x.memory_bytes, x.certificate_end_s)
TESSERA_MESSAGE(NodeUse, x.memory_bytes, x.scratch_free_bytes)
TESSERA_MESSAGE(WhoIs, x.asks)
TESSERA_MESSAGE(CoordinatorIs, x.registry, x.address)
TESSERA_MESSAGE(Hello, x.wire, x.cluster, x.shared, x.info, x.use, x.last_words, x.member, x.node)
TESSERA_MESSAGE(Welcome, x.uuids, x.addresses, x.coordinator)
TESSERA_MESSAGE(Refused, x.why)
TESSERA_MESSAGE(ReachedAll, x.uuid)
TESSERA_MESSAGE(Renew, x.uuid, x.use)
TESSERA_MESSAGE(Renewed)
TESSERA_MESSAGE(Expelled, x.why, x.again)
TESSERA_MESSAGE(Unreachable, x.from, x.to)
TESSERA_MESSAGE(AskToLeave)
TESSERA_MESSAGE(Leaving, x.uuid, x.jobs)

}  // namespace tessera

TESSERA_STAYS_HERE(tessera::AskMembers)
TESSERA_STAYS_HERE(tessera::AskStatus)
TESSERA_STAYS_HERE(tessera::Drain)
TESSERA_STAYS_HERE(tessera::Drained)
TESSERA_STAYS_HERE(tessera::Follow)
TESSERA_STAYS_HERE(tessera::MemberList)
TESSERA_STAYS_HERE(tessera::MembershipStatus)

CAF_BEGIN_TYPE_ID_BLOCK(tessera_cluster, caf::first_custom_type_id + 200)
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::AskToLeave))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::CoordinatorIs))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Expelled))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Hello))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Leaving))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::ReachedAll))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Refused))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Renew))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Renewed))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Unreachable))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::Welcome))
CAF_ADD_TYPE_ID(tessera_cluster, (tessera::WhoIs))
CAF_END_TYPE_ID_BLOCK(tessera_cluster)
