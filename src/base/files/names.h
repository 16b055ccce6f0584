// Every name in a result folder, in a run folder and in other folders, and the names of files that are being written.
//
//   OUT/manifest.json              what the result is; written last
//   OUT/triangulation.pvtu         the master file, over the tiles
//   OUT/tiles/000042.vtu           a tile with its cells
//   OUT/tiles/000042.pts           a tile kept as points
//   OUT/tiles/node-000000.done     while the run is unfinished: the entries of the tiles that node 0 has stored;
//                                  older software wrote an entry to a file of its own, 000042.done
//   OUT/tiles/000042-2.vtu, .pts   a tile as version 2 of the result wrote it
//   OUT/.versions/000001.json      the manifest of version 1, once there is a newer one; 000001.copy.json: a copy of it
//   OUT/.versions/log.json         what each version was made of (src/result/version_log.h)
//   OUT/.versions/pass/            what the writer of a version needs meanwhile: values/000042.bin, sent/000042.bin
//   OUT/duplicates.bin             when there are any; duplicates-HEX.bin, with its checksum, once points were removed
//   or
//                                  added in place
//   OUT/report.html
//   OUT/.lock/                     while a process works in the folder (folder_lock.h)
//   OUT/.run/                      the run folder, while the run is unfinished; until points are routed each process
//                                  has a run folder of its own, OUT/.run.new-4711-.../
//     plan.json                    what was routed; written last
//     segments.bin                 where a tile's points are (src/tiling/routed_cloud.h)
//     points/000000-000007.bin     routed points, as many as one buffer held
//     attributes/000000-000007.bin their attributes; absent when nothing is carried
//     routing.bin                  while many nodes route: what the nodes must know
//     stretches/000003.bin         what one attempt at an input split has routed
//     state/000042.bin, finals/000042.bin, mail/000042.bin, duplicates/000042.bin
//                                  scratch of a tile: frames (frame.h)
//     settled/node-000000.bin      scratch of all tiles of node 0
//     settled.done                 all tiles are settled
//     terms/1                      the first coordinator of a cluster that has worked on the run
//   NAME.tmp, NAME.tmp-4711-...    NAME while it is written; with a number where two processes may write the same file
//
// Names in the data folder of a service:
//
//   DATA/format                    the number of the format of the data folder
//   DATA/reserve                   occupies space that a start on a full disk needs
//   DATA/id                        tells this data folder from any other: nodes of a cluster share one
//   DATA/scratch/NODE/             scratch of a node of a cluster that has no disk of its own
//   DATA/jobs/ID/                  a job: job.json, what it is; log.txt; outcome.json, what it found
//   DATA/tokens                    who may ask (src/service/http/tokens.h)
//   DATA/forgotten.txt             the ids of jobs that were removed, a line each
//   DATA/events.json               which numbers the next events may have
//   DATA/results/NAME/             a result folder; with exports/ in it, what it was exported to
//   DATA/answers/TOKEN/            the input of a question and its answer, while the question is answered
//   DATA/uploads/NAME/FILE         an input; .FILE.part while it is uploaded
//   .../exports/3dtiles/           the tileset of a result, which the dashboard shows
//   .../.unfinished-ID             the output of job ID until it is whole
//   .../.removed-...               what is being removed
//   .../.desk-7/                   what daemon number 7 of this data folder is just putting there
//                                  (src/service/staging_folder.h)
//   DATA/terms/7                   says that there was a daemon number 7
//
// Names in a tileset (src/result/tileset):
//
//   TILESET/tileset.json           the tree of its nodes; written last
//   TILESET/nodes/000042.glb       the surface of a node
//
// Names in a folder of certificates (src/cluster/certs):
//
//   CERTS/ca.pem, CERTS/ca.key     the authority of a cluster, its key
//   CERTS/NAME.pem, CERTS/NAME.key a node of the cluster, its key
//
// Names in the folder of a cluster on one machine (src/front/apps/cluster.cc):
//
//   DIR/cluster.json               its processes and ports
//   DIR/token                      the token of the cluster's API, readable by its owner alone
//   DIR/certs/, DIR/data/          as above
//   DIR/logs/NAME.log              the log of node NAME
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "src/base/ids.h"
#include "src/base/tile_kind.h"

namespace tessera {

// Result folders.
inline constexpr int newest_format = 5, oldest_format = 2;  // the formats that can be read
// The format of results that were never changed and have all their cells, and of results with versions or tiles kept as
// points.
inline constexpr int unchanged_format = 3, changed_format = 4;
// The format of results whose points were changed in place: each version has its own list of duplicates.
inline constexpr int updated_format = 5;
// The format of results of periodic clouds: one beyond those of other results, so that programs that do not know of
// periods refuse it.
inline constexpr int periodic_format = 6;
std::filesystem::path manifest_file(const std::filesystem::path& out);
std::filesystem::path master_file(const std::filesystem::path& out);
std::filesystem::path tiles_folder(const std::filesystem::path& out);
// The file of a tile that version `version` of the result wrote. For version 1 the name has no number of the version.
std::filesystem::path tile_file(const std::filesystem::path& out, TileId tile, std::uint32_t version = 1,
                                TileKind kind = TileKind::cells);
// The version that wrote a file of a tiles folder, if the version is above 1. Nothing for other names.
std::optional<std::uint32_t> version_of_tile_file(const std::filesystem::path& file);
// The kind of a tile's file, by its ending. Nothing for other endings.
std::optional<TileKind> kind_of_tile_file(const std::filesystem::path& file);
// The manifests of older versions. They are links to the manifest, or copies where a file cannot have two names. With
// copies it cannot be known whether a process still reads that version.
std::filesystem::path versions_folder(const std::filesystem::path& out);
std::filesystem::path version_file(const std::filesystem::path& out, std::uint32_t version);
std::filesystem::path version_copy(const std::filesystem::path& out, std::uint32_t version);
// The version of a version_file() or version_copy(). Nothing for other names.
std::optional<std::uint32_t> version_of_file(const std::filesystem::path& file);
// A version of a result, by the name of its manifest in versions_folder(). Such a path stands for that version wherever
// a result folder is read, also while the version is the current one and the path does not exist.
struct NamedVersion {
  std::filesystem::path out;
  std::uint32_t version = 1;
};
std::optional<NamedVersion> named_version(const std::filesystem::path& path);
std::filesystem::path version_log_file(const std::filesystem::path& out);
// What the writer of a version needs until the version is written.
std::filesystem::path pass_folder(const std::filesystem::path& out);
std::filesystem::path done_file(const std::filesystem::path& out, NodeId node);
// The cells that a node has written of a tile before the tile's other cells are known: a temporary name.
std::filesystem::path early_file(const std::filesystem::path& out, TileId tile, NodeId node);
std::filesystem::path duplicates_file(const std::filesystem::path& out);
// The duplicates of a version of format 5, by the checksum of the file.
std::filesystem::path duplicates_file(const std::filesystem::path& out, std::uint64_t xxh3);
bool is_duplicates_name(const std::filesystem::path& file);
// The attributes of the points in duplicates_file().
std::filesystem::path duplicate_rows_file(const std::filesystem::path& out);
std::filesystem::path duplicate_rows_file(const std::filesystem::path& out, std::uint64_t xxh3);
bool is_duplicate_rows_name(const std::filesystem::path& file);
std::filesystem::path report_file(const std::filesystem::path& out);
std::filesystem::path lock_folder(const std::filesystem::path& out);
std::filesystem::path new_lock_folder(const std::filesystem::path& out, const std::string& owner);
std::filesystem::path run_folder(const std::filesystem::path& out);
std::filesystem::path new_run_folder(const std::filesystem::path& out);

// Run folders.
std::filesystem::path plan_file(const std::filesystem::path& run);
// What the run has made. It is written just before the outcome gets its place, and is the last file that is removed.
std::filesystem::path outcome_file(const std::filesystem::path& run);
std::filesystem::path points_folder(const std::filesystem::path& run);
std::filesystem::path attributes_folder(const std::filesystem::path& run);
std::filesystem::path segments_file(const std::filesystem::path& run);
std::filesystem::path points_file(const std::filesystem::path& run, ShuffleFileId bundle);
std::filesystem::path attributes_file(const std::filesystem::path& run, ShuffleFileId bundle);
std::filesystem::path routing_file(const std::filesystem::path& run);
std::filesystem::path routed_splits_folder(const std::filesystem::path& run);
std::filesystem::path routed_split_file(const std::filesystem::path& run, std::uint32_t attempt);

// What a tile keeps in scratch files, as frames of this kind. Numbers must never change, because a newer program may
// resume a run.
enum class ScratchKind : std::uint32_t {
  state = 1,       // the image of a tile that is not in memory
  finals = 2,      // the tile's final cells
  mail = 3,        // points that came for the tile while it was not in memory
  duplicates = 4,  // the tile's duplicates
  settled = 5,     // the tile once nothing can change it
  // What nodes that route together tell each other, in files of their own.
  routing = 6,
  split = 7,
  // What the stages of a job over a result keep of a tile.
  kept = 8,
};
// The kinds that are files of a tile of a run.
inline constexpr ScratchKind scratch_kinds[] = {ScratchKind::state, ScratchKind::finals, ScratchKind::mail,
                                                ScratchKind::duplicates, ScratchKind::settled};
// The folder in which a stage of a run keeps its files. For the first stage it is the run folder itself.
std::filesystem::path stage_folder(const std::filesystem::path& run, std::uint32_t stage);
std::filesystem::path scratch_folder(const std::filesystem::path& run, ScratchKind kind);
std::filesystem::path scratch_file(const std::filesystem::path& run, ScratchKind kind, TileId tile);
// The settled tiles of a node.
std::filesystem::path settled_file(const std::filesystem::path& run, NodeId node);
std::filesystem::path settled_marker(const std::filesystem::path& run);
std::filesystem::path terms_folder(const std::filesystem::path& run);

// The data folder of a service.
std::filesystem::path data_reserve_file(const std::filesystem::path& data);
std::filesystem::path data_format_file(const std::filesystem::path& data);
std::filesystem::path share_scratch_folder(const std::filesystem::path& scratch, std::uint64_t number);
// The updates that wait for another node.
std::filesystem::path outbox_scratch_file(const std::filesystem::path& share, NodeId node);
bool is_share_scratch_name(const std::filesystem::path& file);
// How the last process with this scratch folder ended, for the next process.
std::filesystem::path last_words_file(const std::filesystem::path& scratch);
std::filesystem::path data_identity_file(const std::filesystem::path& data);
std::filesystem::path node_scratch_folder(const std::filesystem::path& data, const std::string& node);
std::filesystem::path jobs_folder(const std::filesystem::path& data);
std::filesystem::path job_folder(const std::filesystem::path& data, const std::string& id);
std::filesystem::path job_record_file(const std::filesystem::path& job);
std::filesystem::path job_log_file(const std::filesystem::path& job);
std::filesystem::path job_outcome_file(const std::filesystem::path& job);
std::filesystem::path forgotten_jobs_file(const std::filesystem::path& data);
std::filesystem::path event_numbers_file(const std::filesystem::path& data);
std::filesystem::path results_folder(const std::filesystem::path& data);
std::filesystem::path exports_folder(const std::filesystem::path& out);
std::filesystem::path tileset_of_result(const std::filesystem::path& out);
// Where the processes of these names write by default, and where maps look.
std::filesystem::path dem_of_result(const std::filesystem::path& out);
std::filesystem::path contours_of_result(const std::filesystem::path& out);
std::filesystem::path surface_of_result(const std::filesystem::path& out);
std::filesystem::path uploads_folder(const std::filesystem::path& data);
std::filesystem::path answers_folder(const std::filesystem::path& data);
// `ending` includes the point.
std::filesystem::path answer_file(const std::filesystem::path& folder, const std::string& ending);
std::filesystem::path asked_points_file(const std::filesystem::path& folder, const std::string& ending);
std::filesystem::path tokens_file(const std::filesystem::path& data);
std::filesystem::path part_file(const std::filesystem::path& final_name);
// A folder in `folder`, which is renamed to its final name when it is whole.
std::filesystem::path unfinished_folder(const std::filesystem::path& folder, const std::string& job);
// staging_folder_path() is the staging folder of daemon number `term`. A folder that was renamed to removed_folder()
// belongs to no job any more; each needs another token.
std::filesystem::path staging_folder_path(const std::filesystem::path& folder, std::uint64_t term);
std::optional<std::uint64_t> term_of_staging_folder(const std::filesystem::path& file);
std::filesystem::path removed_folder(const std::filesystem::path& folder, const std::string& token);

// Tilesets.
std::filesystem::path tileset_file(const std::filesystem::path& tileset);
std::filesystem::path tileset_nodes_folder(const std::filesystem::path& tileset);
std::filesystem::path tileset_node_file(const std::filesystem::path& tileset, std::uint32_t node);

// Folders of certificates.
std::filesystem::path authority_file(const std::filesystem::path& certs);
std::filesystem::path authority_key_file(const std::filesystem::path& certs);
std::filesystem::path node_certificate_file(const std::filesystem::path& certs, const std::string& node);
std::filesystem::path node_key_file(const std::filesystem::path& certs, const std::string& node);

// The folder of a cluster on one machine.
std::filesystem::path local_cluster_file(const std::filesystem::path& folder);
std::filesystem::path local_token_file(const std::filesystem::path& folder);
std::filesystem::path local_certificates_folder(const std::filesystem::path& folder);
std::filesystem::path local_data_folder(const std::filesystem::path& folder);
std::filesystem::path local_logs_folder(const std::filesystem::path& folder);
std::filesystem::path local_log_file(const std::filesystem::path& folder, const std::string& node);

// The name of a file until the file is whole. temporary_name() is for a file that one writer writes at a time.
// temporary_name_of_process() is different for each process on every machine.
std::filesystem::path temporary_name(const std::filesystem::path& final_name);
std::filesystem::path temporary_name_of_process(const std::filesystem::path& final_name);

// Whether a name directly under OUT, or under its tiles folder, is one that storing, finishing or reporting makes,
// temporary names included. Such files may be deleted with the result.
bool is_result_name(const std::filesystem::path& file);
bool is_tile_name(const std::filesystem::path& file);
bool is_settled_name(const std::filesystem::path& file);
// Whether a name stands directly in a run folder.
bool is_run_name(const std::filesystem::path& file);
// Whether a file is one that only an unfinished run needs.
bool is_done_name(const std::filesystem::path& file);
bool is_temporary_name(const std::filesystem::path& file);
// The lock of `out`, or a lock that is being made.
bool is_lock_name(const std::filesystem::path& file);
// A new_run_folder() of any process.
bool is_new_run_name(const std::filesystem::path& file);
// Whether a name stands directly in the folder of a job, temporary names included.
bool is_job_name(const std::filesystem::path& file);
// The token of a removed_folder(). Nothing for other names.
std::optional<std::string> token_of_removed(const std::filesystem::path& file);
// The node of a node_certificate_file(). Empty for other names, including the authority's.
std::string node_of_certificate(const std::filesystem::path& file);
// The job of an unfinished_folder(). Empty for other names.
std::string job_of_unfinished(const std::filesystem::path& file);

}  // namespace tessera
