// Measures a job's folder while nodes and the engine's threads write into it.
#pragma once

#include <filesystem>
#include <thread>

#include "src/base/ledger.h"
#include "src/base/result.h"

namespace tessera::service {

// Measures the folder from time to time, less often when measuring takes long, and draws the growth from the ledger. So
// a job can exceed its bound by what it writes between two measurements.
class DiskWatch {
 public:
  // Both arguments must stay valid as long as this object. The folder may not exist yet.
  DiskWatch(std::filesystem::path folder, Ledger& ledger);

  // Measures the folder for the last time. Errors: those of the ledger; io when the folder cannot be read.
  Status finish();

 private:
  Status look() const;

  const std::filesystem::path folder_;
  Ledger& ledger_;
  std::jthread thread_;  // last, because it uses the others
};

}  // namespace tessera::service
