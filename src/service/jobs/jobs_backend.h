// What front ends ask of jobs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "service.pb.h"
#include "src/service/caller.h"
#include "src/service/reply.h"

namespace tessera::service {

struct JobQuery {
  std::vector<std::string> states = {}, processes = {};  // empty: all
  std::string after = {};                                // the last job of the page before
  std::uint32_t limit = 100;
};

// Events are delivered as long as this object lives.
class Subscription {
 public:
  virtual ~Subscription() = default;
};

// Thread-safe. A job that does not exist is 404; one that was removed is 410.
class JobsBackend {
 public:
  virtual ~JobsBackend() = default;

  virtual Reply<proto::JobList> list(const JobQuery& query) = 0;
  virtual Reply<proto::StatusInfo> status(std::string_view id) = 0;
  // Dismisses a job. A running or waiting job is dismissed when this returns, and can be resumed; an ended job is
  // forgotten (410 from then on). Results stay. Threads and memory of a running job are free soon, mostly within tenths
  // of a second: work on tiles is broken off, and the images of tiles in memory, up to 256 MiB, are written.
  virtual Reply<proto::StatusInfo> dismiss(std::string_view id, const Caller& caller) = 0;
  virtual Reply<proto::StatusInfo> resume(std::string_view id, const Caller& caller) = 0;
  virtual Reply<ServedFile> log(std::string_view id) = 0;
  virtual Reply<ServedFile> report(std::string_view id) = 0;
  // The progress of the tiles of a triangulation that runs or has succeeded; with the planes between tiles when asked
  // for.
  virtual Reply<proto::JobTiles> tiles(std::string_view id, bool with_layout) = 0;
  // What a verify, export or info job found, as JSON; 404 result-not-ready before it ends.
  virtual Reply<std::string> outcome(std::string_view id) = 0;

  // Delivers events after `last` (0: from now on), of one job or of all (""), in order, as they come. Any thread may
  // call `on_event`, which must not block. Events that are no longer kept are replaced by a status of each job.
  using OnEvent = std::function<void(const std::shared_ptr<const proto::Event>&)>;
  virtual Reply<std::unique_ptr<Subscription>> subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) = 0;
};

}  // namespace tessera::service
