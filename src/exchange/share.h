// A node's share of a job: what the node is told, and what its tiles need to work.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/exchange/heap_trim.h"
#include "src/exchange/mail_counts.h"
#include "src/exchange/outbox.h"
#include "src/exchange/routing_table.h"
#include "src/exchange/schedule.h"
#include "src/exchange/tile_life.h"

namespace tessera {

// What a job may use of a node, and how the job ends early.
struct ShareOptions {
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;
  bool resumable = true;       // leave images when the job is interrupted
  std::uint32_t grace_s = 0;   // seconds for which tiles go on without a coordinator, until another one takes over
  std::string lock_file = {};  // of the result folder: nothing is written once another process has it (check_held())

  friend bool operator==(const ShareOptions&, const ShareOptions&) = default;
};

// Everything that a node must be told of a job. It contains no pointers, so it can be sent to another process
// (proto/job.proto).
struct ShareSpec : ShareOptions {
  std::string run_folder, out_folder;
  std::string stages;    // which kind of stages, for a job over a result; empty: a job over a cloud
  std::string programs;  // what the programs of the stages must know, as bytes that only they understand
  RoutingTable table;    // as it is when the share is opened
  // In a cluster, whose nodes differ in size: each node gives the job one of so many equal shares of its threads and
  // memory. 0: the job runs on one node, and `threads` and `memory_bytes` are as given.
  std::uint32_t shares = 0;

  friend bool operator==(const ShareSpec&, const ShareSpec&) = default;
};
std::string to_bytes(const ShareSpec& spec);
Result<ShareSpec> spec_from_bytes(const std::string& bytes);

// What a share needs in one stage of the job.
struct ShareStage {
  TileContext context;
  ScheduleOptions schedule;
  // Makes what settled tiles have left visible to other nodes. Called before the share says that its tiles are settled.
  // Empty when there are no other nodes.
  std::function<Status()> sync_settled;
};

// What a share consists of. The share's actor owns it, and outlives the share's tiles. Arrays with an entry for every
// tile of the run exist once in a process and are shared, because a share may have few of very many tiles.
struct Share {
  virtual ~Share() = default;
  std::vector<ShareStage> stages;  // of the job, in order; tiles run the program of one stage after the other
  std::shared_ptr<const RoutingTable> table =
      std::make_shared<const RoutingTable>();                 // with which the share was opened
  std::shared_ptr<const std::vector<std::uint64_t>> weights;  // by tile, of the whole run; 0: there is no such tile
  // Both of the stage that the table names. `stored` has the tiles of this node that came to the end of the stage in an
  // earlier process. `settled` says whether all was quiet before, and each other tile has left what its end is made
  // from.
  std::vector<TileReceipt> stored;
  bool settled = false;
  OutboxOptions outboxes;
  std::filesystem::path scratch;  // folder of this share alone; empty: what waits for other nodes is held in memory
  HeapTrim heap_trim;
  std::unique_ptr<MailCounts> mail;  // null: nothing is counted
  std::stop_source stopping;  // stops all work that leaves nothing behind when it is stopped; the stages have its token
};

// Opens shares: from a run folder in production, from memory in the harness.
class ShareSource {
 public:
  virtual ~ShareSource() = default;
  // Opens the share of the node `self`.
  virtual Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) = 0;
};

}  // namespace tessera
