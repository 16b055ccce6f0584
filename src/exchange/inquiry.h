// What a coordinator that takes over a job learns from the nodes: which of them have a share of the job, and by which
// routing table these shares go. It is told whom the coordinator asks, what the nodes answer, and who is lost. It tells
// when all have answered, and what follows from the answers. A plain object without I/O and threads: it knows a node by
// the number of the question, because a node may have no number in the job.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/exchange/routing_table.h"

namespace tessera {

class Inquiry {
 public:
  using Question = std::size_t;
  // What a node has answered. Without a share only `threads`, `memory_bytes` and `name` count.
  struct Answer {
    bool has_share = false;
    NodeId self;         // the node's number in the job
    bool begun = false;  // the share has begun its tiles
    RoutingTable table;
    std::vector<TileId> released;  // tiles that are the share's by its table, and that it has given up
    std::uint32_t threads = 1;
    std::uint64_t memory_bytes = 0;
    std::string name;
  };
  struct Answered {
    Question question = 0;
    Answer answer;
  };

  // Notes that a node is asked. Returns the number of the question.
  Question ask();
  // Takes the answer to a question. REQUIRES: is_open(question).
  void take(Question question, Answer answer);
  // Returns whether the question was neither answered nor withdrawn.
  bool is_open(Question question) const { return open_.at(question); }
  // Returns whether the question was answered, and the answer still counts.
  bool is_answered(Question question) const;

  // What a lost node had to do with the inquiry.
  enum class Lost : std::uint8_t { nothing, question, answer };
  // Notes that a node is lost: its question, or its answer, does not count any more. When the node had a share, that
  // share may still send messages, so its number is not given to another node.
  Lost lose(Question question);
  // Notes that a share which was found has ended since.
  void end_share(NodeId self);

  // Returns whether answers are still to come.
  bool waits() const;
  // Returns whether no node is asked and none has answered.
  bool nobody() const { return !waits() && answers_.empty(); }
  // In the order in which they came.
  const std::vector<Answered>& answers() const { return answers_; }
  void forget_answers() { answers_.clear(); }

  // Returns the newest table by which any share goes, or nothing when no node has a share. No share has heard of any
  // later table. Between equal epochs, `present` is older.
  std::optional<RoutingTable> newest(const RoutingTable& present) const;
  // Returns how many numbers of nodes are taken, when the job goes on by this table; none: when it begins anew.
  std::uint32_t numbers(const std::optional<RoutingTable>& table) const;
  // Returns, by tile, whether the node that has the tile by this table has given it up. `tiles` is the number of tiles.
  std::vector<bool> given_up(const RoutingTable& table, std::size_t tiles) const;

 private:
  std::vector<bool> open_;  // by question
  std::vector<Answered> answers_;
  std::uint32_t numbers_lost_ = 0;  // numbers below it belong to shares whose nodes were lost after they had answered
};

}  // namespace tessera
