// The members of a cluster, as its coordinator sees them. It is told what was heard and when, and says which nodes are
// lost. A plain object without I/O, clock and threads.
//
// A node is a member from its Hello on, and is free for work once it has reached all other members. A node is lost when
// its lease ends, when its connection to the coordinator breaks, or when other nodes cannot reach it: messages that
// were on their way are gone then. A lost node does not come back. Its process begins anew, as another node.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tessera {

using NodeUuid = std::string;  // made when the process begins

struct MemberInfo {
  NodeUuid uuid;
  std::string name;
  std::string address;  // HOST:PORT where others reach it
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
  std::uint64_t certificate_end_s = 0;  // end of its certificate's validity, in seconds since 1970; 0: not known
};

// What a node uses, as it says with each message.
struct NodeUse {
  std::uint64_t memory_bytes = 0;        // used by jobs
  std::uint64_t scratch_free_bytes = 0;  // that it may still write to scratch
};

// What the list of nodes says of one node.
struct NodeState {
  MemberInfo info;
  bool own = false;  // it is the coordinator's own process
  // It has reached all others, and can get work.
  bool free = false;
  bool leaves = false;                       // gets no more work, and ends when its tiles are elsewhere
  std::string last_words;                    // how the process before this one ended; empty: in order
  std::uint64_t seconds = 0, silent_ms = 0;  // since it came; since it was last heard
  NodeUse use;
};

// A node's membership, as the node itself sees it.
struct MembershipStatus {
  bool member = false;       // its lease runs
  bool leaves = false;       // gets no more work
  std::string trouble;       // why it is no member
  std::uint64_t others = 0;  // how many other nodes it reaches
  // Since the coordinator was last heard; without one, since the process began or was a member.
  std::uint64_t silent_ms = 0;
};

class Members {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  struct Member {
    MemberInfo info;
    std::uint64_t number = 0;  // 1, 2, ... in the order of coming
    Time came, heard;
    bool free = false;  // has reached all others
    NodeUse use;
  };
  struct Loss {
    Member member;
    std::string why;
  };

  explicit Members(Duration lease) : lease_(lease) {}

  // Adds a node, or renews its lease. Returns false when the node was lost: its process must begin anew.
  bool hello(const MemberInfo& info, const NodeUse& use, Time now);
  // The node has reached all nodes that were members when it came. Returns true when this call has
  // made it free for work. Returns false when it was free before, is no member, or is reported unreachable.
  bool mark_reached_all(const NodeUuid& uuid);
  // Renews the lease of a node. Returns false when it is no member.
  bool renew(const NodeUuid& uuid, const NodeUse& use, Time now);
  // `from` cannot reach `to`. lose_silent() decides later which of the two is lost, when other nodes have had the time
  // to report as well.
  void note_unreachable(const NodeUuid& from, const NodeUuid& to, Time now);
  // Removes a node from the members for ever. Returns nothing when it is no member.
  std::optional<Loss> lose(const NodeUuid& uuid, std::string why);
  // Removes and returns all nodes that are lost by now. REQUIRES: called several times in each lease. When the last
  // call is longer ago than a quarter of the lease, because this process was stopped or had no processor, leases are
  // extended by the excess.
  std::vector<Loss> lose_silent(Time now);

  const std::map<NodeUuid, Member>& all() const { return members_; }
  const Member* find(const NodeUuid& uuid) const;

 private:
  NodeUuid worst_connected() const;

  Duration lease_;
  std::map<NodeUuid, Member> members_;
  std::set<NodeUuid> lost_;
  std::set<std::pair<NodeUuid, NodeUuid>> broken_;  // connections that are broken; the lesser uuid first
  std::optional<Time> broken_since_, asked_;
  std::uint64_t numbers_ = 0;
};

}  // namespace tessera
