// What front ends ask of inputs: to list them, and to receive uploads.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "service.pb.h"
#include "src/service/caller.h"
#include "src/service/reply.h"

namespace tessera::service {

// Receives the bytes of an upload as they come. The file gets its name in finish().
class Upload {
 public:
  virtual ~Upload() = default;
  virtual Reply<void> write(std::string_view bytes) = 0;
  virtual Reply<void> finish() = 0;
};

// Thread-safe.
class InputsBackend {
 public:
  virtual ~InputsBackend() = default;

  // The entries of a folder that jobs may read, sorted by name, in pages: point files with what their headers say, and
  // folders. "" lists all roots and the uploads. 400 for what is no folder below the roots.
  virtual Reply<proto::InputList> list(std::string_view folder, std::uint32_t limit, std::string_view after,
                                       const Caller& caller) = 0;
  // Receives an upload from `offset` on.
  virtual Reply<std::unique_ptr<Upload>> upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                                const Caller& caller) = 0;
  virtual Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) = 0;
  // Also removes a partial upload. 409 while the file is being sent.
  virtual Reply<void> remove_upload(std::string_view folder, std::string_view file, const Caller& caller) = 0;
};

}  // namespace tessera::service
