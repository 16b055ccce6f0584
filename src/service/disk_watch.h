// What a job's folder holds while others than the job's own thread write into it: nodes, and the engine's threads.
#pragma once

#include <filesystem>
#include <thread>

#include "src/base/ledger.h"
#include "src/base/result.h"

namespace tessera {

// Looks now and then, the more seldom the longer a look takes, and draws what it finds from the ledger. So a job can be
// beyond its bound by what it writes between two looks.
class DiskWatch {
 public:
  // Both outlive this. The folder need not be there yet.
  DiskWatch(std::filesystem::path folder, Ledger& ledger);

  // The last look. Error of the ledger; io when the folder cannot be looked at.
  Status finish();

 private:
  Status look() const;

  const std::filesystem::path folder_;
  Ledger& ledger_;
  std::jthread thread_;  // last: it uses the others
};

}  // namespace tessera
