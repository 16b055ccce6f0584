// Figures and the health of a service.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "actors/engine/engine.h"
#include "src/service/data_folder.h"
#include "src/service/health_backend.h"
#include "src/service/jobs/job_table.h"
#include "src/service/jobs/upkeep.h"
#include "src/service/questions/questions.h"

namespace tessera::service {

// What a service's health is judged by.
struct HealthSources {
  const Engine& engine;
  const DataFolder& data_folder;
  const JobTable& jobs;
  const Upkeep& upkeep;
  const Questions& questions;
  std::filesystem::path data;
  std::uint64_t memory_bytes = 0;
  std::optional<std::int64_t> certificate_end_s = {};  // of a cluster's node; nothing: this process works alone
};

class ServiceHealth final : public HealthBackend {
 public:
  explicit ServiceHealth(HealthSources of) : of_(std::move(of)) {}

  ServiceFigures figures() const override;
  std::optional<std::string> unready() const override;
  std::optional<std::string> lost() const override;

 private:
  const HealthSources of_;
};

}  // namespace tessera::service
