// What a finished job says about itself, for people and for programs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/duplicate_policy.h"
#include "src/base/figures.h"

namespace tessera {

struct JobSummary {
  std::string out;
  int dimension = 3;
  std::uint64_t points_read = 0, invalid = 0, filtered = 0, duplicates = 0;
  std::optional<std::uint64_t> other_heights;     // of the duplicates; in 2D, if heights are known
  DuplicatePolicy keep = DuplicatePolicy::first;  // which of equal points is the vertex
  std::uint64_t vertices = 0, cells = 0;
  std::uint64_t tiles = 0;  // tiles that hold points
  ExchangeFigures exchange;
  std::uint64_t result_bytes = 0;
  std::string digest;  // "" when a tile stored by an older version has no digest
  std::uint64_t peak_memory_bytes = 0;
  std::uint32_t threads = 1;
  std::uint64_t memory_budget_bytes = 0;                // 0: not known
  std::vector<std::pair<std::string, double>> seconds;  // by phase, in order
  double total_s = 0;
  std::vector<std::string> warnings;  // sentences about the input
};

// Returns the end of "12 duplicates, 3 of them at other heights, of which the lowest are kept", from " duplicates" on.
std::string duplicates_text(std::uint64_t other_heights, DuplicatePolicy keep);

std::string summary_text(const JobSummary& summary);  // several lines, each with its line end
std::string summary_json(const JobSummary& summary);  // one line: {"event":"summary",...}

}  // namespace tessera
