// The service: jobs and results of one data folder, whoever asks and however. Knows nothing of HTTP; safe from any
// thread. What it has accepted it does, over any number of restarts.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/cluster/cluster_options.h"

namespace tessera {

// What a caller may do; each includes the ones before.
enum class Role : std::uint8_t { none, read, submit, admin };

struct Caller {
  std::string name;  // of the token
  Role role = Role::none;
  std::stop_token stop = {};  // it has gone, or has waited too long: what it asked for is of no use any more
};

// An answer, or the problem with its HTTP status.
template <class T>
using Reply = boost::outcome_v2::basic_result<T, proto::Problem, boost::outcome_v2::policy::terminate>;

struct ServiceLimits {
  std::uint32_t running = 1;                 // jobs at once
  std::uint32_t queued = 10'000;             // jobs that wait; more: 429
  std::uint32_t jobs_of_a_caller = 1000;     // accepted or running
  std::uint32_t ended_of_a_caller = 1000;    // ended jobs that are remembered; of more those that ended first are not
  std::uint64_t points = 0, disk_bytes = 0;  // of one job; 0: what the machine has
  std::uint64_t reserve_bytes = std::uint64_t{64} << 20;  // of the disk, that jobs and uploads leave free
  std::uint64_t upload_bytes = 0;                         // of all uploads together; 0: what the disk has
  // A job during which the process died is begun again, alone, so that its neighbours are not blamed; after so many
  // deaths one after the other it has failed, and only resume() begins it again.
  std::uint32_t deaths = 3;
};

struct ServiceOptions {
  std::filesystem::path data;                // made when missing
  std::vector<std::filesystem::path> roots;  // where inputs may lie
  std::uint64_t memory_bytes = 0;            // for all running jobs together
  std::uint32_t threads = 1;
  bool uploads = false;
  std::uint64_t retention_s = 0;  // ended jobs are forgotten after it; 0: never. Results never are.
  ServiceLimits limits;
  // How long the data folder's lock is another's without a sign of life. The same for all daemons of the folder.
  std::chrono::milliseconds data_lease{60'000};
  // Called once when the data folder is lost: another process holds it, or it is gone. The service does nothing any
  // more, and what it says may be wrong: a daemon ends here.
  std::function<void(const Error&)> lost = {};
  // Called while another process holds the data folder, with a sentence about it. True: it is tried again.
  std::function<bool(const Error&)> locked = {};
  std::optional<ClusterOptions> cluster = {};         // that works on its jobs; none: this process alone
  std::function<void(const std::string&)> log = {};   // what the service itself has to tell, a line at a time
  std::function<void(const std::string&)> note = {};  // the same of what is as it should be
};

// A file to be sent: open for reading, so that nothing can be put in its place any more.
struct ServedFile {
  int descriptor = -1;  // the receiver closes it
  std::uint64_t bytes = 0;
  std::string type;  // media type
  std::string etag;  // strong, quoted, from the manifest's checksum; of a file that still grows: empty
};

// What is asked of a result, in words; the service reads them as the commands do.
struct Question {
  enum class About : std::uint8_t {
    locate,
    star,
    cells,
    interpolate,
    dem,
    hull,
    section,
    solids,
    contours,
    profile,
    features,  // of the collection of kind `kind`: bbox, limit, after; item: that one alone
    map_tile   // level, row, column, style
  };
  About about = About::locate;
  std::string triangulation;
  std::string vertex = {};                          // star: its source index
  std::map<std::string, std::string> options = {};  // point, cell, tile, bbox, f, limit, value, method, weights, ...
  std::optional<std::string> body = {};  // locate, interpolate: many points; cells: a polygon; profile: a line
  std::string type = {};                 // of the body: a media type
  // The answer as a message of proto/query.proto. REQUIRES: has_message(about), and no f.
  bool as_message = false;
  std::stop_token stop = {};  // the caller has gone
};

// Whether there is a message for the answers; the others are files, pictures and GeoJSON.
constexpr bool has_message(Question::About about) {
  using About = Question::About;
  return about == About::locate || about == About::star || about == About::interpolate || about == About::profile;
}
inline constexpr const char* protobuf_type = "application/x-protobuf";

struct QuestionAnswer {
  std::string text = {};                // of this type, or
  std::optional<ServedFile> file = {};  // that has its own
  std::string type = {};
  bool final = true;  // it is provably that of the triangulation of all points
  // Of features, whose text is a JSON object without its last brace: where the next page begins, if there is one.
  std::optional<std::uint64_t> next = {};
};

// What of a result is offered as features on a map.
struct FeatureCollection {
  std::string id;             // NAME.kind
  std::string triangulation;  // NAME
  std::string kind;           // tiles, hull, contours
  std::string title = {}, description = {};
  std::array<double, 4> extent{};  // west, south, east, north
  std::string storage_crs = {};    // a URI: features are also told as the result has them; empty: they are not
};
// In which they are told unless another system is asked for.
inline constexpr const char* crs84_uri = "http://www.opengis.net/def/crs/OGC/1.3/CRS84";

struct JobQuery {
  std::vector<std::string> states = {}, processes = {};  // empty: all
  std::string after = {};                                // the job that ended the page before
  std::uint32_t limit = 100;
};

// What a front end asks of the service; it knows no more of it. Safe from any thread.
class Backend {
 public:
  virtual ~Backend() = default;

  // Asked again with the same key and inputs it is the same job, with other inputs 422. `fresh` says which.
  struct Submitted {
    proto::StatusInfo status;
    bool fresh = true;
  };
  virtual Reply<Submitted> submit(const proto::Inputs& inputs, const Caller& caller,
                                  std::string_view idempotency_key = {}) = 0;
  // Of triangulate, region, dem and contours.
  virtual Reply<proto::Estimate> estimate(const proto::Inputs& inputs, const Caller& caller) = 0;
  // Short ones are answered at once: what `tessera info --json` prints. Statistics of many points, and compressed
  // files, are not: 400, and to be submitted as a job.
  virtual Reply<std::string> info(const proto::InfoInputs& inputs, const Caller& caller) = 0;

  virtual Reply<proto::JobList> jobs(const JobQuery& query) = 0;
  virtual Reply<proto::StatusInfo> job(std::string_view id) = 0;
  // A running or waiting job is dismissed when this returns, and can be resumed; one that has ended is forgotten (410
  // from then on). Results stay. Threads and memory of a running one are free soon, most of the time in
  // tenths of a second: work on tiles is broken off, and images of those in memory are written up to 256 MiB.
  virtual Reply<proto::StatusInfo> dismiss(std::string_view id, const Caller& caller) = 0;
  virtual Reply<proto::StatusInfo> resume(std::string_view id, const Caller& caller) = 0;
  virtual Reply<ServedFile> log(std::string_view id) = 0;
  virtual Reply<ServedFile> report(std::string_view id) = 0;
  // How far the tiles of a triangulation are that runs or has succeeded; with the planes between them when asked.
  virtual Reply<proto::JobTiles> tiles(std::string_view id, bool with_layout) = 0;
  // What a verify, export or info job found, as JSON; 404 result-not-ready before.
  virtual Reply<std::string> outcome(std::string_view id) = 0;

  // Events after `last` (0: from now on), of one job or of all ("" ), in order, as they come; called by any thread,
  // must not block. Events that are no longer kept are replaced by a status of each job. Ends when the handle dies.
  class Subscription {
   public:
    virtual ~Subscription() = default;
  };
  using OnEvent = std::function<void(const std::shared_ptr<const proto::Event>&)>;
  virtual Reply<std::unique_ptr<Subscription>> subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) = 0;

  virtual Reply<proto::TriangulationList> triangulations(std::uint32_t limit, std::string_view after) = 0;
  virtual Reply<proto::TriangulationInfo> triangulation(std::string_view name) = 0;
  virtual Reply<ServedFile> file(std::string_view name, std::string_view path) = 0;
  // 409 while a job works on it.
  virtual Reply<void> remove_triangulation(std::string_view name, const Caller& caller) = 0;
  // What a triangulation was made into, by name: files and folders, in pages as above.
  virtual Reply<proto::ExportList> exports(std::string_view name, std::uint32_t limit, std::string_view after) = 0;
  // One of them. 409 while a job writes it.
  virtual Reply<void> remove_export(std::string_view name, std::string_view file, const Caller& caller) = 0;

  // What tells this result from any other that had its name, or will: its answers, by this program, are always the
  // same.
  virtual Reply<std::string> identity(std::string_view name) = 0;
  // Waits for the disk. 404, 400 for words that say nothing, 422 for points or polygons that are none and for more than
  // one answer may take, 410 when the caller or the result has gone meanwhile, 500 for a damaged tile.
  virtual Reply<QuestionAnswer> ask(const Question& question) = 0;

  // What there is for maps, of all results that say where on the earth they are, by name.
  virtual Reply<std::vector<FeatureCollection>> collections() = 0;
  // 404 also for a name that there could be, but is none: a result without coordinate system, or contour lines.
  virtual Reply<FeatureCollection> collection(std::string_view id) = 0;
  // West, south, east and north of the raster of heights of a result; 404 when it has none.
  virtual Reply<std::array<double, 4>> map_extent(std::string_view name) = 0;

  // Bytes `offset`... of an upload are taken as they come. Nothing is there under its name before finish().
  class Upload {
   public:
    virtual ~Upload() = default;
    virtual Reply<void> write(std::string_view bytes) = 0;
    virtual Reply<void> finish() = 0;
  };
  virtual Reply<std::unique_ptr<Upload>> upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                                const Caller& caller) = 0;
  virtual Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) = 0;
  // Also of what has come of a file. 409 while it is being sent.
  virtual Reply<void> remove_upload(std::string_view folder, std::string_view file, const Caller& caller) = 0;

  // What a folder holds that jobs may read, by name, in pages as above: point files, with what their headers tell, and
  // folders. "": of all roots, and the uploads. 400 for what is no folder below the roots.
  virtual Reply<proto::InputList> inputs(std::string_view folder, std::uint32_t limit, std::string_view after,
                                         const Caller& caller) = 0;

  // Who works on the jobs, in order of coming.
  virtual Reply<proto::NodeList> nodes() = 0;
  // Takes all work from a node, by its name or id, and has its process end. What it was; 409 for the only one.
  virtual Reply<proto::NodeInfo> drain(std::string_view node, const Caller& caller) = 0;

  // For /metrics and /readyz.
  struct Figures {
    std::uint64_t accepted = 0, running = 0;                  // now
    std::uint64_t successful = 0, failed = 0, dismissed = 0;  // since the start
    std::uint64_t points = 0;                                 // triangulated since the start
    std::uint64_t updates_waiting = 0;                        // in the mail of tiles, and on the way to it, now
    std::uint64_t memory_budget_bytes = 0, memory_used_bytes = 0, disk_free_bytes = 0;
    std::vector<std::pair<std::string, double>> phase_seconds;
    std::uint64_t subscribers = 0;
    std::uint64_t open_results = 0;                                 // that are kept open for questions
    std::vector<std::pair<std::string, std::uint64_t>> nodes = {};  // by state
    std::uint64_t nodes_lost = 0;                                   // since the start
    std::uint64_t bytes_between = 0, credit_waits = 0;  // sent from node to node, and waited for, since the start
    double certificate_end_s = 0;  // when the cluster's certificate of this process expires, since 1970; 0: no cluster
  };
  virtual Figures figures() const = 0;
  // Nothing when jobs can be taken, else why not: a full or read-only folder, a scheduler that does not answer.
  virtual std::optional<std::string> unready() const = 0;
  // Why nothing it says is to be believed any more, once its data folder is another daemon's or gone. Quick.
  virtual std::optional<std::string> lost() const = 0;
};

class Service final : public Backend {
 public:
  // Takes the data folder (one daemon a folder), reads what it holds, goes on with unfinished jobs. Error usage for
  // options that do not fit, io for a folder that cannot be used or is another's, corrupt for one of a newer version.
  static Result<std::unique_ptr<Service>> open(ServiceOptions options);
  // Running jobs are interrupted and stay resumable.
  ~Service() override;

  Reply<Submitted> submit(const proto::Inputs& inputs, const Caller& caller,
                          std::string_view idempotency_key = {}) override;
  Reply<proto::Estimate> estimate(const proto::Inputs& inputs, const Caller& caller) override;
  Reply<std::string> info(const proto::InfoInputs& inputs, const Caller& caller) override;
  Reply<proto::JobList> jobs(const JobQuery& query) override;
  Reply<proto::StatusInfo> job(std::string_view id) override;
  Reply<proto::StatusInfo> dismiss(std::string_view id, const Caller& caller) override;
  Reply<proto::StatusInfo> resume(std::string_view id, const Caller& caller) override;
  Reply<ServedFile> log(std::string_view id) override;
  Reply<ServedFile> report(std::string_view id) override;
  Reply<proto::JobTiles> tiles(std::string_view id, bool with_layout) override;
  Reply<std::string> outcome(std::string_view id) override;
  Reply<std::unique_ptr<Subscription>> subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) override;
  Reply<proto::TriangulationList> triangulations(std::uint32_t limit, std::string_view after) override;
  Reply<proto::TriangulationInfo> triangulation(std::string_view name) override;
  Reply<ServedFile> file(std::string_view name, std::string_view path) override;
  Reply<void> remove_triangulation(std::string_view name, const Caller& caller) override;
  Reply<proto::ExportList> exports(std::string_view name, std::uint32_t limit, std::string_view after) override;
  Reply<void> remove_export(std::string_view name, std::string_view file, const Caller& caller) override;
  Reply<std::string> identity(std::string_view name) override;
  Reply<QuestionAnswer> ask(const Question& question) override;
  Reply<std::vector<FeatureCollection>> collections() override;
  Reply<FeatureCollection> collection(std::string_view id) override;
  Reply<std::array<double, 4>> map_extent(std::string_view name) override;
  Reply<std::unique_ptr<Upload>> upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                        const Caller& caller) override;
  Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) override;
  Reply<void> remove_upload(std::string_view folder, std::string_view file, const Caller& caller) override;
  Reply<proto::InputList> inputs(std::string_view folder, std::uint32_t limit, std::string_view after,
                                 const Caller& caller) override;
  Reply<proto::NodeList> nodes() override;
  Reply<proto::NodeInfo> drain(std::string_view node, const Caller& caller) override;
  Figures figures() const override;
  std::optional<std::string> unready() const override;
  std::optional<std::string> lost() const override;

 private:
  struct Impl;
  explicit Service(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
