// Writes objects to S3: small ones by one request, large ones in parts. Source: Amazon S3 API Reference, "PutObject",
// "CreateMultipartUpload", "UploadPart", "CompleteMultipartUpload", "AbortMultipartUpload", "DeleteObject".
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/objects.h"
#include "src/input/remote/s3.h"
#include "src/input/remote/transfers.h"

namespace tessera::remote {

// An object of more bytes is sent in parts of so many, or of more if there would be more than 10,000 of them.
inline constexpr std::uint64_t part_bytes = std::uint64_t{8} << 20;

// Thread-safe.
class S3Writer {
 public:
  S3Writer(S3Access access, std::shared_ptr<Transfers> transfers)
      : access_(std::move(access)), transfers_(std::move(transfers)) {}

  // Objects::put(). An object appears when all of its bytes have arrived. After an error the parts that have arrived
  // are given up; a process that is killed leaves them to the store.
  Status put(std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
             const std::stop_token& stop);
  // Objects::remove().
  Status remove(const std::string& name, const std::stop_token& stop);
  // Objects::check_writable().
  Status check_writable(const std::string& name, const std::stop_token& stop);

 private:
  class Putting;
  // The reply to a request for an object. `parameters` follow the '?' of its address, sorted.
  struct Ask {
    std::string method, parameters;
    std::vector<std::string> headers = {};
    std::shared_ptr<const std::vector<std::byte>> body = {};
  };
  Result<HttpReply> send(const std::string& name, const Ask& ask, const std::stop_token& stop);
  Result<HttpRequest> request_of(const std::string& name, const Ask& ask);
  Result<std::string> begin_parts(const std::string& name, const std::stop_token& stop);
  // Does not try again, and tells no errors: the store removes what is left in its own time.
  void give_up(const std::vector<std::pair<std::string, std::string>>& names_and_ids);
  // Whether the store has an object of this name with these bytes.
  Result<bool> has(const std::string& name, const std::vector<std::byte>& bytes, const std::stop_token& stop);
  Result<std::uint64_t> bytes_of(const std::string& name, const std::stop_token& stop);

  std::mutex mutex_;
  S3Access access_;  // guarded by the mutex: a reply may tell the region
  std::shared_ptr<Transfers> transfers_;
};

}  // namespace tessera::remote
