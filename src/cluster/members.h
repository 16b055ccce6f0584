// Who belongs to a cluster, as its coordinator sees it: told what it hears and when, it says who is lost. Pure.
//
// A node is a member from its Hello on, and free for work once it has reached all others. It is lost when its lease
// ends, when its connection does, or when it cannot be reached by others that can reach each other: what was on its way
// is gone. Whoever was lost does not come back: its process begins anew, as another one.
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
  std::string address;  // HOST:PORT by which others reach it
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
  std::uint64_t certificate_end_s = 0;  // until when its certificate is valid, by the system's clock; 0: not known
};

// What a node has in use, as it says with each word.
struct NodeUse {
  std::uint64_t memory_bytes = 0;        // by jobs
  std::uint64_t scratch_free_bytes = 0;  // that it may still write there
};

// A node, as whoever asks for it is told.
struct NodeState {
  MemberInfo info;
  bool own = false;  // of the coordinator's process
  bool free = false;
  bool leaves = false;                       // takes no more work, and ends when all it has is elsewhere
  std::string last_words;                    // how the process before its own has ended; empty: in order
  std::uint64_t seconds = 0, silent_ms = 0;  // since it came, since it was heard
  NodeUse use;
};

// A node's place in its cluster, as it sees it itself.
struct NodePlace {
  bool member = false;          // its lease runs
  bool leaves = false;          // takes no more work
  std::string trouble;          // why not
  std::uint64_t others = 0;     // processes of nodes that it reaches
  std::uint64_t silent_ms = 0;  // since the coordinator was heard; of no member, since it began or was one
};

class Members {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  struct Member {
    MemberInfo info;
    std::uint64_t number = 0;  // in order of coming
    Time came, heard;
    bool free = false;  // has reached all others
    NodeUse use;
  };
  struct Loss {
    Member member;
    std::string why;
  };

  explicit Members(Duration lease) : lease_(lease) {}

  // False: it was lost, and must begin anew.
  bool hello(const MemberInfo& info, const NodeUse& use, Time now);
  // It has reached all that were members when it came. Returns whether it is news.
  bool reached_all(const NodeUuid& uuid);
  // False: it is no member.
  bool renew(const NodeUuid& uuid, const NodeUse& use, Time now);
  // `from` cannot reach `to` any more, or never could. Who of them is lost is decided when others have had the time to
  // say the same.
  void unreachable(const NodeUuid& from, const NodeUuid& to, Time now);
  std::optional<Loss> lose(const NodeUuid& uuid, std::string why);
  // All who are lost by now. To be asked often, against the lease: when it was not, for this process was stopped or
  // had no processor, leases go on for as long.
  std::vector<Loss> lose_silent(Time now);

  const std::map<NodeUuid, Member>& all() const { return members_; }
  const Member* find(const NodeUuid& uuid) const;

 private:
  NodeUuid worst_connected() const;

  Duration lease_;
  std::map<NodeUuid, Member> members_;
  std::set<NodeUuid> lost_;
  std::set<std::pair<NodeUuid, NodeUuid>> broken_;  // the lesser first
  std::optional<Time> broken_since_, asked_;
  std::uint64_t numbers_ = 0;
};

}  // namespace tessera
