// What front ends ask of results: to list, send and remove them and their exports. Questions to them are elsewhere.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "service.pb.h"
#include "src/service/caller.h"
#include "src/service/reply.h"

namespace tessera::service {

// Thread-safe. Lists are sorted by name, and come in pages: at most `limit` names, those after the name `after`.
class ResultsBackend {
 public:
  virtual ~ResultsBackend() = default;

  virtual Reply<proto::TriangulationList> list(std::uint32_t limit, std::string_view after) = 0;
  virtual Reply<proto::TriangulationInfo> info(std::string_view name) = 0;
  // The versions of a triangulation as a JSON object, as `tessera log --json` prints them.
  virtual Reply<std::string> versions(std::string_view name) = 0;
  virtual Reply<ServedFile> file(std::string_view name, std::string_view path) = 0;
  // 409 while a job uses the triangulation.
  virtual Reply<void> remove(std::string_view name, const Caller& caller) = 0;
  // The exports of a triangulation: files and folders.
  virtual Reply<proto::ExportList> exports(std::string_view name, std::uint32_t limit, std::string_view after) = 0;
  // 409 while a job writes the export.
  virtual Reply<void> remove_export(std::string_view name, std::string_view file, const Caller& caller) = 0;
};

}  // namespace tessera::service
