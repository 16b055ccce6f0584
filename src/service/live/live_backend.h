// What front ends ask of live results: results that the service keeps in memory, to which points are added and from
// which points are removed (docs/live.md).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "service.pb.h"
#include "src/service/caller.h"
#include "src/service/jobs/jobs_backend.h"
#include "src/service/reply.h"

namespace tessera::service {

// New points or source indices, as a caller sends them.
struct PointsBody {
  std::string_view type;  // the media type: application/json, application/x-protobuf, application/x-npy
  const std::string& bytes;
  bool replace = false;  // the points of the result that are equal to new ones are removed
};

// Thread-safe. 404 for a result that does not exist; 409 for a result that is not live; 403 for a caller who may not
// change the result.
class LiveBackend {
 public:
  virtual ~LiveBackend() = default;

  // Return when the change survives the end of the process. 400 and 422, after which nothing has changed, for points
  // that cannot be added or removed, and when memory is exhausted. 410 when the caller has gone before the change was
  // begun. 500 and 507 when it is not known whether the change was made.
  virtual Reply<proto::PointsChanged> add(std::string_view name, const PointsBody& points, const Caller& caller) = 0;
  virtual Reply<proto::PointsChanged> remove(std::string_view name, const PointsBody& ids, const Caller& caller) = 0;

  // Delivers the versions after number `last` (nothing: from now on), in order, as they are made. Any thread may call
  // `on_event`, which must not block. Versions that are no longer known are replaced by one event that says so.
  using OnVersion = std::function<void(const std::shared_ptr<const proto::Event>&)>;
  virtual Reply<std::unique_ptr<Subscription>> follow(std::string_view name, std::optional<std::uint64_t> last,
                                                      OnVersion on_event) = 0;

  // Nothing for a result that is not live.
  virtual std::optional<proto::LiveInfo> live(std::string_view name) const = 0;
};

}  // namespace tessera::service
