// A node's part of a job: what it is told, and what its tiles need to work.
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

// What a job may use of a node, and how it ends early.
struct ShareOptions {
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;
  bool resumable = true;       // leave images when the job is interrupted
  std::uint32_t grace_s = 0;   // seconds that tiles go on without a coordinator, for another to take over
  std::string lock_file = {};  // of the result folder: once it is another's, nothing is written any more (check_held())

  friend bool operator==(const ShareOptions&, const ShareOptions&) = default;
};

// Everything a node must be told of a job. Nothing in it refers to memory: it can cross a wire (proto/job.proto).
struct ShareSpec : ShareOptions {
  std::string run_folder, out_folder;
  std::string stages;    // of which kind, for a job over a result; empty: of a cloud
  std::string programs;  // what the programs of the stages must know: bytes that only they understand
  RoutingTable table;    // as it is when the part is opened
  // Of a cluster's nodes, which are of any size: each gives one of so many equal shares of its threads and memory. 0:
  // one node has the job, and threads and memory are as given.
  std::uint32_t shares = 0;

  friend bool operator==(const ShareSpec&, const ShareSpec&) = default;
};
std::string to_bytes(const ShareSpec& spec);
Result<ShareSpec> spec_from_bytes(const std::string& bytes);

// What a part needs in one of the job's stages.
struct ShareStage {
  TileContext context;
  ScheduleOptions schedule;
  // Set where there are other nodes: what settled tiles have left is where those will find it. Called before the part
  // says that its tiles are settled.
  std::function<Status()> sync_settled;
};

// What a part is made of. Owned by the part's actor, which outlives its tiles. What there is for each tile of the whole
// run, its plan has in memory, too, or all parts of a process share: a part may have few of very many tiles.
struct Share {
  virtual ~Share() = default;
  std::vector<ShareStage> stages;  // of the job, in order; tiles run the program of one after the other
  std::shared_ptr<const RoutingTable> table = std::make_shared<const RoutingTable>();  // that the part was opened with
  std::shared_ptr<const std::vector<std::uint64_t>> weights;  // by tile, of the whole run; 0: there is none
  // Of the stage that the table has: tiles here that have come to its end in an earlier process; and whether all was
  // quiet once, and each other tile has left what its end is made from.
  std::vector<TileReceipt> stored;
  bool settled = false;
  OutboxOptions outboxes;
  std::filesystem::path scratch;  // of this part alone; none: what waits for other nodes is held in memory
  HeapTrim heap_trim;
  std::unique_ptr<MailCounts> mail;  // none: nobody counts
  std::stop_source stopping;  // of all work that leaves nothing behind when it is stopped; the stages have its token
};

// How a node comes by its parts: from a run folder in production, from memory in the harness.
class ShareSource {
 public:
  virtual ~ShareSource() = default;
  virtual Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) = 0;
};

}  // namespace tessera
