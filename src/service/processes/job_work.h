// The work of one job: what it is given, and what it has done at the end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "job_record.pb.h"
#include "src/base/ledger.h"
#include "src/base/progress.h"

namespace tessera::service {

struct JobWork {
  const proto::JobRecord& job;
  Progress& progress;
  Ledger& ledger;
  std::function<void(const std::string&)> log;
  std::filesystem::path scratch;
};

struct JobDone {
  std::string outcome;  // JSON
  std::uint64_t points = 0;
  std::vector<std::pair<std::string, double>> seconds;  // by phase
};

}  // namespace tessera::service
