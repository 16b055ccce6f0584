// What a job tells in words and figures: the manifest, the summary, report.html.
#pragma once

#include <filesystem>
#include <vector>

#include "src/base/progress.h"
#include "src/delaunay/run/run_summary.h"
#include "src/job/job_options.h"
#include "src/job/report/html_report.h"
#include "src/job/report/summary.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

// Makes the manifest without duplicates, seconds and figures, which are known later.
Manifest manifest_of(const JobOptions& options, const RoutedCloud& run, const RunSummary& tiles);
void add_duplicates(JobSummary& summary, const Manifest& manifest);
// Makes the summary without duplicates, seconds and peak memory.
JobSummary summary_of(const JobOptions& options, const std::filesystem::path& out, const Manifest& manifest,
                      const RunSummary& tiles);
// Makes the summary of a finished result from what its manifest keeps. Warnings and memory budget are missing.
JobSummary summary_of(const Manifest& manifest, const std::filesystem::path& out);
// Adds to the manifest the figures of the summary that it keeps for people.
void add_figures(const JobSummary& summary, Manifest& manifest);
ReportData report_of(const JobSummary& summary, const Manifest& manifest, const RunSummary& tiles,
                     std::vector<PhaseSpan> spans);

}  // namespace tessera
