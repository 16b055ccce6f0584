// A service: jobs and results of one data folder, for any kind of client. Does not know HTTP. Thread-safe. An accepted
// job is done, over any number of restarts.
//
// Jobs, results, questions, processes, inputs, nodes and health are objects of their own; this one makes them.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/cluster/cluster_options.h"
#include "src/service/backend.h"
#include "src/service/limits.h"

namespace tessera::service {

struct ServiceOptions {
  std::filesystem::path data;                // made when missing
  std::vector<std::filesystem::path> roots;  // folders of inputs
  std::uint64_t memory_bytes = 0;            // for all running jobs together
  std::uint32_t threads = 1;
  bool uploads = false;
  std::uint64_t retention_s = 0;  // ended jobs are forgotten after it; 0: never. Results are always kept.
  ServiceLimits limits;
  // How long another process keeps the data folder's lock without a sign of life. The same for all daemons of the
  // folder.
  std::chrono::milliseconds data_lease{60'000};
  // Called once when the data folder is lost: another process holds it, or it is gone. From then on the service does
  // nothing, and its answers may be wrong. A daemon ends here.
  std::function<void(const Error&)> lost = {};
  // Called with a sentence while another process holds the data folder. Returns true to try again.
  std::function<bool(const Error&)> locked = {};
  // Results that are kept in memory and changed there, and the memory for all of them, which is a part of
  // `memory_bytes`; 0: half of it.
  std::vector<std::string> live = {};
  std::uint64_t live_memory_bytes = 0;
  std::uint64_t live_log_bytes = std::uint64_t{64} << 20;  // a log that is longer is soon stored in the result
  std::optional<ClusterOptions> cluster = {};         // the cluster that works on jobs; nothing: this process alone
  std::function<void(const std::string&)> log = {};   // gets warnings and errors of the service itself, line by line
  std::function<void(const std::string&)> note = {};  // gets lines about normal events
};

class Service {
 public:
  // Takes the data folder (one daemon a folder), reads its jobs, and continues unfinished ones. Errors: usage for wrong
  // options; io for a folder that cannot be used or that another daemon holds; corrupt for a folder of a newer version.
  static Result<std::unique_ptr<Service>> open(ServiceOptions options);
  // Interrupts running jobs, which can be resumed.
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  // Its objects live as long as this one.
  Backend backend();
  ProcessesBackend& processes();
  JobsBackend& jobs();
  ResultsBackend& results();
  QuestionsBackend& questions();
  InputsBackend& inputs();
  NodesBackend& nodes();
  LiveBackend& live();
  const HealthBackend& health() const;

 private:
  struct Impl;
  explicit Service(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::service
